// What single rays see: a furnace of many colours, and dye in voxels, whose light is an integral along the ray.

#include "fluovox/core/rng.h"

#include "path_kit.h"
#include "slow_light.h"
#include "validation/case.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

namespace fluovox::validation {
namespace {

using testing::dye_in;
using testing::host;

/// Rays from around the origin, inside and outside of the body, that look everywhere.
Ray anywhere(Rng& rng) {
    const Vec3 from = 120 * std::cbrt(rng.uniform()) * sample_isotropic(rng.uniform(), rng.uniform());
    return {from, sample_isotropic(rng.uniform(), rng.uniform())};
}

SparseGrid wavy_ball(const Affine& map, double value) {
    return SparseGrid::from_function({-20, -20, -20}, {20, 20, 20}, map, [value](Voxel v) {
        const double r = std::hypot(v.x, v.y, v.z);
        return r < 19 ? value * (1 + std::sin(0.5 * v.x) * std::cos(0.7 * v.y)) : 0.0;
    });
}

/// Radiance of one of eight wavelengths that share their paths, over that of the light that comes from everywhere.
Case furnace_case(const std::string& name, const std::vector<SceneMedium>& bodies, std::size_t colour) {
    const std::vector<double> nm = testing::wavelengths_in(450, 650, 8);
    Scene scene;
    Light surround;
    surround.shape = UniformLight{1};
    surround.spectrum.energy_per_nm = Spectrum::box(400, 700, 1.0 / 300);
    scene.lights = {surround};
    scene.media = bodies;
    const double truth = continuous_photons_per_nm(surround, nm[colour]);
    Case result;
    result.name =
        fmt::format("coloured furnace, {}: radiance at {:.1f} nm over that of the surround", name, nm[colour]);
    result.expected = 1;
    result.source = "a medium that only scatters is invisible";
    result.scale = 0;
    result.fixed = 1200000;
    result.estimate = [=](std::int64_t samples, std::uint64_t seed) {
        constexpr int kRuns = 24;
        return mean_of_runs_at_once(kRuns, seed, [&](std::uint64_t run) {
            const testing::PathRun settings{static_cast<int>(samples / kRuns), run, 0};
            return testing::spectral_radiance(scene, anywhere, nm, settings).elastic[colour].mean / truth;
        });
    };
    return result;
}

void add_furnaces(std::vector<Case>& cases) {
    const PowerLaw blue{500, 0.05, -1.6};
    const Spectrum red({400, 700}, {0.01, 0.1});
    const auto coloured = [](SceneMedium medium, Coefficient scattering) {
        medium.scattering = std::move(scattering);
        return medium;
    };
    const SceneMedium box = coloured(host(BoxRegion{{-50, -30, -20}, {50, 30, 20}}, 0, 0, 0.8), blue);
    const SceneMedium ball = coloured(host(SphereRegion{{5, 6, 7}, 60}, 0, 0), red);
    const SceneMedium rod = coloured(host(CylinderRegion{{-50, 0, 10}, {40, 30, -10}, 25}, 0, 0, -0.4), red);
    Affine map;
    map.rows = {Vec3{1.6, 0.5, 0.1}, Vec3{-0.6, 1.7, 0.2}, Vec3{0.2, -0.3, 1.8}};
    const SceneMedium voxels = coloured(host(wavy_ball(map, 1), 0, 0, 0.6), blue);
    cases.push_back(furnace_case("box", {box}, 0));
    cases.push_back(furnace_case("sphere and cylinder", {ball, rod}, 7));
    cases.push_back(furnace_case("voxels in a sphere", {voxels, ball}, 3));
}

/// Voxels of dye, turned and sheared, under one light: radiance along a ray over its integral.
Case voxel_ray_case(const std::string& name, decltype(Light::shape) shape) {
    constexpr double kLaser_nm = 480;
    constexpr double kEmission_nm = 555;
    Affine map;
    map.rows = {Vec3{1.6, 0.5, 0.1}, Vec3{-0.6, 1.7, 0.2}, Vec3{0.2, -0.3, 1.8}};
    map.offset = {2, 4, 1};
    const auto checkered = [](Voxel v) { return 6 * (1 + 0.5 * ((v.x + v.z) & 1)); };
    Scene scene;
    Dye dye = testing::flat_dye(1, 470, 600, 540, 600, 0.7);
    // Absorbs the laser strongly and its own light weakly.
    dye.molar_absorption_per_M_cm =
        Spectrum({470, 500, 530, 600}, {0.002e10 / std::log(10.0), 0.002e10 / std::log(10.0), 1e7, 0.5e7});
    scene.dyes = {dye};
    scene.media = {dye_in(SparseGrid::from_function({-20, -17, -13}, {20, 17, 13}, map, checkered), 0)};
    scene.lights = {testing::laser(std::move(shape), kLaser_nm, 1e-3)};
    const Ray ray{{-20, 3, -80}, normalized({0.25, 0.04, 1})};
    Case result;
    result.name = "clear dye in voxels, " + name + ": radiance along a ray over its integral";
    result.expected = 1;
    result.uncertainty = 1e-4;  // of the sum over the ray's points
    result.source = "inner filter at both wavelengths, step by step (tests/reference)";
    result.scale = 0;
    result.fixed = 4800000;
    result.estimate = [=](std::int64_t samples, std::uint64_t seed) {
        constexpr int kRuns = 24;
        const double truth =
            testing::photons_of(scene.lights[0]) *
            reference::converted_once(scene, scene.lights[0], ray, {0, kLaser_nm, kEmission_nm}, {180, 6000, 1});
        return mean_of_runs_at_once(kRuns, seed, [&](std::uint64_t run) {
            const testing::PathRun settings{static_cast<int>(samples / kRuns), run, 1};
            return testing::spectral_radiance(scene, testing::ray_from(ray.origin, ray.direction), {kEmission_nm},
                                              settings)
                       .mean_converted.mean /
                   truth;
        });
    };
    return result;
}

}  // namespace

std::vector<Case> ray_cases() {
    std::vector<Case> cases;
    add_furnaces(cases);
    SheetLight sheet;
    sheet.position = {-150, 5, 3};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 90;
    sheet.thickness_um = 12;
    sheet.waist = {0, 5, 3};
    cases.push_back(voxel_ray_case("sheet", sheet));
    cases.push_back(voxel_ray_case("point light inside", PointLight{{5, 12, -9}}));
    return cases;
}

}  // namespace fluovox::validation
