#pragma once

// Light transport written a second time, as plainly as it can be: sums over small steps and lists of directions, no
// random numbers, nothing shared with the library's transport code. Slow, and meant to be read.

#include "fluovox/scene/scene.h"

#include <vector>

namespace fluovox::reference {

/// Amount of a medium at a point: none where another takes its place.
double amount_at(const Scene& scene, const SceneMedium& medium, Vec3 p);

/// Scattering, and extinction (scattering and all absorption), per micrometre at a point.
double scattering_at(const Scene& scene, Vec3 p, double nm);
double extinction_at(const Scene& scene, Vec3 p, double nm);

/// Optical depth between two points: boxes and slabs exactly, everything else in `steps` steps.
double optical_depth(const Scene& scene, Vec3 from, Vec3 to, double nm, int steps = 400);

/// A bundle of rays of one light at a point: where it comes from, how far off it starts, and the fluence it would bring
/// in a vacuum, per unit of the light's power.
struct Bundle {
    Vec3 to_light;
    double distance_um = 0;
    double fluence_per_um2 = 0;
};

/// All light that one light sends to a point, in bundles. `fineness`: of lights with many directions.
std::vector<Bundle> light_at(const Light& light, Vec3 p, int fineness = 24);

/// Fluence at a point that comes straight from the light, per unit of its power.
double direct_fluence(const Scene& scene, const Light& light, Vec3 p, double nm, int fineness = 24);

/// Radiance along a ray up to `end_um`, of light that a point scatters or converts after it came straight from the
/// light, per unit of the light's power.
struct Along {
    double end_um = 0;
    int steps = 2000;
    int fineness = 24;
};
double scattered_once(const Scene& scene, const Light& light, const Ray& ray, double nm, const Along& along);
/// From one wavelength to the other, by `dye`, an index into Scene::dyes.
struct Conversion {
    int dye = 0;
    double excitation_nm = 0, emission_nm = 0;
};
/// Per nanometre of emission.
double converted_once(const Scene& scene, const Light& light, const Ray& ray, const Conversion& by, const Along& along);

}  // namespace fluovox::reference
