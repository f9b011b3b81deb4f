#pragma once

#include "fluovox/scene/scene.h"
#include "fluovox/transport/deaf_sink.h"
#include "fluovox/transport/excitation_cache.h"
#include "fluovox/transport/glow_sample.h"
#include "fluovox/transport/optical_field.h"
#include "fluovox/transport/photon_tracer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace fluovox {

/// Samples of the pixels of a film through refracting surfaces: from the camera importance flies as photons do, is
/// refracted, reflected and scattered, and collects what glows on its way by an ExcitationCache that holds all light.
/// What is conserved along a ray is the radiance over the square of the refractive index. One per thread.
class CameraGather {
public:
    CameraGather(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits,
                 const ExcitationCache& cache);

    /// One sample of a pixel (row x width + column) with the random numbers of number `sample`: a value for each layer
    /// and channel, in the order of Film::add. Holds until the next call.
    std::span<const double> sample(int pixel, std::int64_t sample);

    TrackingCounts counts() const;

private:
    // What the tracer calls; only flights matter.
    struct Sink : DeafSink {
        explicit Sink(CameraGather* gather) : owner(gather) {}
        CameraGather* owner;
        void flight(const Photon& photon, const Flight& flight, const Zone& zone) const {
            owner->collect(photon, flight, zone);
        }
    };

    void collect(const Photon& photon, const Flight& flight, const Zone& zone);

    const Scene* scene_;
    const PhotonSpace* space_;
    const ExcitationCache* cache_;
    PhotonTracer<Sink> tracer_;
    GlowSample sample_;
    double camera_index_ = 1;
    std::vector<double> by_dye_;  // radiance per nm, um^-2 s^-1 sr^-1 nm^-1
};

}  // namespace fluovox
