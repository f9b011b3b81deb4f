#pragma once

#include "fluovox/core/vec.h"
#include "fluovox/transport/photon.h"
#include "fluovox/transport/photon_media.h"

namespace fluovox {

/// A sink for PhotonTracer that hears nothing: a base for those that want some of what happens, by functions of the
/// same names.
struct DeafSink {
    void flight(const Photon& /*photon*/, const Flight& /*flight*/, const Zone& /*zone*/) const {}
    void absorbed(const Photon& /*photon*/, int /*medium*/, double /*weight*/) const {}
    void absorbed(const Photon& /*photon*/, int /*medium*/, double /*weight*/, Vec3 /*position*/) const {}
    void converted(const Photon& /*photon*/, int /*dye*/, double /*absorbed*/, double /*reemitted*/) const {}
    void emission(const Photon& /*photon*/) const {}
    void escaped(const Photon& /*photon*/) const {}
    void cut(const Photon& /*photon*/, double /*weight*/) const {}
    void vertex(const Photon& /*photon*/, int /*medium*/) const {}
};

}  // namespace fluovox
