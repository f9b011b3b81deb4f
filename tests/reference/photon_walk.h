#pragma once

// Photons followed one by one from a light until they are absorbed or leave: each draws its fate by the plain
// probabilities of nature, nothing is weighted, and those that happen to fly into the camera are counted. Slow.

#include "fluovox/optics/camera.h"
#include "fluovox/scene/scene.h"

#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace fluovox::reference {

using Dice = std::mt19937_64;

/// A photon of the light at its start.
using Launch = std::function<Ray(Dice&)>;

struct WalkCounts {
    double launched = 0;
    double absorbed_by_dye = 0, reemitted = 0, absorbed_by_host = 0;
    double escaped_as_laser = 0, escaped_as_glow = 0;
    std::vector<double> laser_in_pixel, glow_in_pixel;  ///< scattered or converted photons that reach a pixel

    /// Photon radiance, per launched photon, um^2 and sr, of `hits` in one pixel, and its standard error.
    struct Radiance {
        double value = 0, error = 0;
    };
    Radiance radiance(const Camera& camera, double hits) const;
};

struct WalkSettings {
    double laser_nm = 0;
    double ball_um = 0;      ///< everything lies inside the ball of this radius around the origin
    double most_per_um = 0;  ///< no extinction is above it
    int orders = 1;          ///< conversions of one photon; after these dyes only absorb
    std::int64_t photons = 0;
    std::uint64_t seed = 1;
    double film_from_nm = 0, film_to_nm = 1e9;  ///< glow at other wavelengths is not counted in pixels
    int scatterings = 1000000;                  ///< photons scattered more often are lost
};

/// Photons from `launch` through the media of `scene`. A photon that a dye takes is emitted again (the yield
/// permitting) at a wavelength drawn from that dye's emission. The camera is telecentric.
WalkCounts walk(const Scene& scene, const Launch& launch, const WalkSettings& settings);

}  // namespace fluovox::reference
