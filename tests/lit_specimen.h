#pragma once

// A thick specimen in collimated light from the side, and paths that look at it.

#include "fluovox/optics/camera_ray.h"
#include "fluovox/transport/line_tracer.h"
#include "fluovox/transport/path_tracer.h"
#include "fluovox/transport/weight_window.h"

#include "scene_kit.h"
#include "statistics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace fluovox::testing {

/// A thick tube with a soft surface that goes across, and a massive lump.
inline SparseGrid specimen(const Affine& world_from_index) {
    const auto value = [](Voxel v) {
        const auto soft = [](double inside) { return std::clamp(inside, 0.0, 1.0); };
        const double tube = 3.5 - std::hypot(v.x - 30.0, v.y - 20.0 - 0.3 * v.z);
        const double lump = 12 - std::hypot(v.x - 40.0, v.y - 45.0, v.z - 20.0);
        return std::max(soft(tube), 0.6 * soft(lump));
    };
    return SparseGrid::from_function({-8, 0, 0}, {72, 64, 64}, world_from_index, value);
}

/// The specimen in light from the side, with a thin medium all around it or without.
inline Scene lit_specimen(double scattering, double around = 0) {
    Scene scene;
    scene.media = {host(specimen({}), scattering, 0.01)};
    if (around > 0) scene.media.push_back(host(SphereRegion{{32, 32, 32}, 60}, around, 0.2 * around));
    scene.lights = {laser(slanting_light({32, 32, 32}, 400), 488, 1)};
    scene.description.film = spectrometer(487, 489, 1);
    scene.description.camera = one_pixel({35, 35, 100}, {35, 35, 32}, {0, 1, 0}, 30);
    return scene;
}

constexpr std::int64_t kManyPaths = 1'000'000;

struct Seen {
    RunningMean radiance;
    TrackingCounts counts;
};

/// Paths of the scene's one line.
class LinePaths {
public:
    explicit LinePaths(const Scene& scene)
        : illumination_(scene),
          camera_(scene.description.camera),
          field_(scene),
          tracer_(scene, field_),
          optics_(field_.optics(Wavelengths::one(illumination_.lines()[0].wavelength_nm))) {
        tracer_.make_plan(line_task(illumination_.lines()[0], optics_), plan_);
    }

    LinePlan& plan() { return plan_; }
    const TrackingCounts& counts() { return field_.counts(); }

    /// From the camera, with the random numbers of sample `n`.
    double radiance(std::uint64_t seed, int n, int scatterings = PathTask::kNoLimit) {
        Rng rng(seed, 0, static_cast<std::uint64_t>(n));
        return tracer_.radiance(camera_.sample(0, 0, rng), plan_, scatterings, 0, rng);
    }
    /// The same path, with its course.
    double record(std::uint64_t seed, int n, PathRecord& record) {
        Rng rng(seed, 0, static_cast<std::uint64_t>(n));
        return tracer_.record(camera_.sample(0, 0, rng), plan_, PathTask::kNoLimit, rng, record);
    }

private:
    Illumination illumination_;
    CameraRays camera_;
    OpticalField field_;
    LineTracer tracer_;
    PathOptics optics_;
    LinePlan plan_;
};

/// Radiance of that line; `change` may add to the plan of its paths.
template <class Change>
Seen look_at(const Scene& scene, const Change& change, std::uint64_t seed, int samples,
             int scatterings = PathTask::kNoLimit) {
    LinePaths paths(scene);
    change(paths.plan());
    Seen seen;
    for (int n = 0; n < samples; ++n)
        seen.radiance.add(paths.radiance(seed, n, scatterings));
    seen.counts = paths.counts();
    return seen;
}

/// By how many standard errors.
inline double apart(const Seen& a, const Seen& b) {
    return (a.radiance.mean - b.radiance.mean) / std::hypot(a.radiance.standard_error(), b.radiance.standard_error());
}

}  // namespace fluovox::testing
