#pragma once

// Radiance along rays of our own, without film and camera.

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/path_tracer.h"

#include "scene_kit.h"
#include "statistics.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace fluovox::testing {

using RayMaker = std::function<Ray(Rng&)>;

/// Always the same ray.
inline RayMaker ray_from(Vec3 origin, Vec3 direction) {
    return [ray = Ray{origin, normalized(direction)}](Rng&) { return ray; };
}

/// How a radiance is estimated.
struct PathRun {
    int samples = 10000;
    std::uint64_t seed = 1;
    int orders = 1;
    int scatterings = PathTask::kNoLimit;
    bool rotate = true;  ///< each wavelength is the hero as often as the others
};

/// Photons s^-1 um^-2 sr^-1 of a laser line that arrive unconverted.
inline RunningMean line_radiance(const Scene& scene, const RayMaker& rays, double nm, const PathRun& run) {
    const Illumination illumination(scene);
    PathTracer tracer(scene, illumination);
    const PathOptics optics = tracer.field().optics(Wavelengths::one(nm));
    PathTask task;
    task.optics = &optics;
    task.scatterings = run.scatterings;
    task.light_photons.assign(scene.lights.size(), Lanes(1));
    for (const auto& line : illumination.lines()) {
        if (line.wavelength_nm != nm) continue;
        for (std::size_t l = 0; l < scene.lights.size(); ++l)
            task.light_photons[l][0] = line.photons[l];
    }
    RunningMean result;
    PathRadiance radiance;
    for (int n = 0; n < run.samples; ++n) {
        Rng rng(run.seed, 7, static_cast<std::uint64_t>(n));
        tracer.estimate(rays(rng), task, rng, radiance);
        result.add(radiance.elastic[0]);
    }
    return result;
}

/// Radiance per nanometre at several wavelengths that share paths.
struct SpectralRadiance {
    std::vector<RunningMean> elastic, converted;  ///< per wavelength
    RunningMean mean_converted;                   ///< over the wavelengths
    std::vector<RunningMean> by_dye;              ///< mean over the wavelengths, per dye
    TrackingCounts counts;
};

inline SpectralRadiance spectral_radiance(const Scene& scene, const RayMaker& rays, const std::vector<double>& nm,
                                          const PathRun& run) {
    const Illumination illumination(scene);
    PathTracer tracer(scene, illumination);
    const std::size_t count = nm.size();
    SpectralRadiance result;
    result.elastic.resize(count);
    result.converted.resize(count);
    result.by_dye.resize(scene.dyes.size());
    PathRadiance radiance;
    for (int n = 0; n < run.samples; ++n) {
        Rng rng(run.seed, 8, static_cast<std::uint64_t>(n));
        const std::size_t turn = run.rotate ? static_cast<std::size_t>(rng.uniform() * static_cast<double>(count)) : 0;
        Wavelengths wavelengths(static_cast<int>(count));
        for (std::size_t k = 0; k < count; ++k) {
            wavelengths.nm[static_cast<int>(k)] = nm[(k + turn) % count];
            wavelengths.pdf_per_nm[static_cast<int>(k)] = 1;
        }
        const PathOptics optics = tracer.field().optics(wavelengths);
        PathTask task;
        task.optics = &optics;
        task.orders = run.orders;
        task.scatterings = run.scatterings;
        if (illumination.has_continuous()) {
            task.light_photons.assign(scene.lights.size(), Lanes(wavelengths.count()));
            for (std::size_t l = 0; l < scene.lights.size(); ++l) {
                for (int k = 0; k < wavelengths.count(); ++k)
                    task.light_photons[l][k] = illumination.continuous_photons(static_cast<int>(l), wavelengths.nm[k]);
            }
        }
        tracer.estimate(rays(rng), task, rng, radiance);
        const Lanes converted = radiance.converted();
        for (std::size_t k = 0; k < count; ++k) {
            result.elastic[(k + turn) % count].add(radiance.elastic[static_cast<int>(k)]);
            result.converted[(k + turn) % count].add(converted[static_cast<int>(k)]);
        }
        result.mean_converted.add(converted.sum() / static_cast<double>(count));
        for (std::size_t d = 0; d < result.by_dye.size(); ++d)
            result.by_dye[d].add(radiance.by_dye[d].sum() / static_cast<double>(count));
    }
    result.counts = tracer.field().counts();
    return result;
}

/// `count` wavelengths evenly inside a band, none at its ends.
inline std::vector<double> wavelengths_in(double from_nm, double to_nm, int count) {
    std::vector<double> nm;
    for (int i = 0; i < count; ++i)
        nm.push_back(from_nm + (to_nm - from_nm) * (i + 0.5) / count);
    return nm;
}

/// A beam of even irradiance so wide that nobody sees its edge, along +z from `z_um`.
inline Light wide_beam(double nm, double power_W, double z_um, double radius_um) {
    BeamLight beam;
    beam.position = beam.waist = {0, 0, z_um};
    beam.direction = {0, 0, 1};
    beam.radius_um = radius_um;
    beam.profile = BeamProfile::Box;
    return laser(beam, nm, power_W);
}

/// Photons per second of the whole light at one of its lines.
inline double photons_of(const Light& light) {
    return line_photons(light, light.spectrum.lines.at(0));
}

}  // namespace fluovox::testing
