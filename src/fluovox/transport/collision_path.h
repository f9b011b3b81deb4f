#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/optics/light_sampling.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/glow_sample.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/optical_field.h"

#include <cstdint>
#include <span>
#include <vector>

namespace fluovox {

/// The estimator "collision", for comparison: plain paths from the camera, of one wavelength, that find a dye only
/// where they happen to be scattered in it (the source over the scattering coefficient is scored at each such place)
/// and then look for the light in a direction drawn evenly, with light sampled at each scattering. No guiding, nothing
/// shared. Unbiased; shows light that was converted once, where the hosts that scatter are constant. One per thread.
class CollisionPaths {
public:
    CollisionPaths(const Scene& scene, const Illumination& illumination);

    /// One sample of a pixel (row x width + column) with the random numbers of number `sample`: a value for each layer
    /// and channel, in the order of Film::add. Holds until the next call.
    std::span<const double> sample(int pixel, std::int64_t sample);

    const TrackingCounts& counts() { return field_.counts(); }

private:
    void trace(Ray ray, Rng& rng);
    void score(const Ray& ray, double t_um, double weight, Rng& rng);
    double fluence(Vec3 position, const Excitation& excitation, Rng& rng);
    double straight(Vec3 position, std::size_t light, const Excitation& excitation, const LightSample& sample,
                    Rng& rng);

    const Scene* scene_;
    const Illumination* illumination_;
    OpticalField field_;
    GlowSample sample_;
    PathOptics optics_, exciting_;
    std::vector<MediumSpan> spans_, shadow_spans_;
    std::vector<Lanes> by_medium_;
    std::vector<double> concentrations_, weights_;
};

/// Throws SceneError for scenes that these paths cannot show: dyes beside constant scattering hosts, hosts in grids,
/// refracting surfaces, light without width, a limited number of scatterings, cascades.
void require_samplable_by_collisions(const Scene& scene);

}  // namespace fluovox
