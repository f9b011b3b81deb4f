#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/optics/light.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/photon.h"
#include "fluovox/transport/photon_space.h"

#include <vector>

namespace fluovox {

/// Launches photons from all lights of a scene, each light in proportion to the photons it sends out. The numerical
/// aperture of a sheet or beam is n sin(theta) in the medium where it starts.
class PhotonSource {
public:
    /// Throws SceneError when no light sends out anything, uniform light has no finite box to come in through, or a
    /// numerical aperture is not below the index where the light starts.
    PhotonSource(const Scene& scene, const PhotonSpace& space);

    /// From now on launches half of the photons in proportion to what a photon of each light is worth, with weights
    /// that make up for it: not all of one where two lights matter alike. Nothing changes when none is worth anything.
    void favour(const std::vector<double>& worth_per_photon);

    /// Of all lights together, per second.
    double photons_per_s() const { return total_; }
    Photon launch(Rng& rng) const;
    /// The light a photon would come from, for those who need to know it: sets `light`.
    Photon launch(Rng& rng, std::size_t& light) const;

private:
    std::vector<Light> lights_;
    const PhotonSpace* space_;
    std::vector<double> rates_;
    std::vector<double> shares_;  // of the photons launched, per light; empty: as the rates
    double total_ = 0;
};

}  // namespace fluovox
