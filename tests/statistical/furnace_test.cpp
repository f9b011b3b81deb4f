// A medium that absorbs nothing cannot be seen where the same light comes from everywhere.

#include "path_kit.h"
#include "random_grids.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using testing::host;
using testing::PathRun;
using testing::RunningMean;
using testing::z_score;

Light surround_line(double nm) {
    return testing::laser(UniformLight{1}, nm, 0);
}

Light surround_continuum(double from_nm, double to_nm) {
    Light light;
    light.shape = UniformLight{1};
    light.spectrum.energy_per_nm = Spectrum::box(from_nm, to_nm, 1 / (to_nm - from_nm));
    return light;
}

// Rays from around the origin that look everywhere, from inside and outside of the specimen.
Ray anywhere(Rng& rng) {
    const Vec3 from = 120 * std::cbrt(rng.uniform()) * sample_isotropic(rng.uniform(), rng.uniform());
    return {from, sample_isotropic(rng.uniform(), rng.uniform())};
}

SparseGrid blob(const Affine& map) {
    return SparseGrid::from_function({-20, -20, -20}, {20, 20, 20}, map, [](Voxel v) {
        const double r = std::hypot(v.x, v.y, v.z);
        return r < 19 ? 1 + std::sin(0.5 * v.x) * std::cos(0.7 * v.y) : 0.0;
    });
}

std::vector<std::pair<const char*, std::vector<SceneMedium>>> shapes() {
    Rng rng(51, 0, 0);
    Affine map = testing::random_affine(rng);
    map.offset = {3, 4, 5};
    std::vector<std::pair<const char*, std::vector<SceneMedium>>> all;
    all.push_back({"box", {host(BoxRegion{{-50, -30, -20}, {50, 30, 20}}, 0.05, 0, 0.8)}});
    all.push_back({"sphere", {host(SphereRegion{{5, 6, 7}, 60}, 0.05, 0)}});
    all.push_back({"cylinder", {host(CylinderRegion{{-50, 0, 10}, {40, 30, -10}, 25}, 0.1, 0, -0.4)}});
    all.push_back({"slab", {host(SlabRegion{1, -20, 30}, 0.03, 0, 0.5)}});
    all.push_back({"voxels", {host(blob(map), 0.04, 0, 0.6)}});
    std::vector<SceneMedium> nested = {host(SphereRegion{{0, 0, 0}, 80}, 0.02, 0, 0.9),
                                       host(BoxRegion{{-20, -20, -20}, {20, 40, 20}}, 0.08, 0),
                                       host(blob({}), 0.03, 0, 0.3)};
    nested[0].cut_by = {1};
    all.emplace_back("nested", std::move(nested));
    return all;
}

TEST(Furnace, AMediumThatOnlyScattersIsInvisible) {
    for (auto& [name, media] : shapes()) {
        Scene scene;
        scene.lights = {surround_line(500)};
        scene.media = media;
        const double truth = testing::photons_of(scene.lights[0]);
        const RunningMean seen = testing::line_radiance(scene, anywhere, 500, {20000, 1, 0});
        EXPECT_NEAR(seen.mean / truth, 1, 0.001) << name;
        EXPECT_LT(std::abs(z_score(seen, truth)), 5) << name;
        for (SceneMedium& medium : scene.media)
            medium.absorption = 0.05 * std::get<double>(medium.scattering);
        const RunningMean twin = testing::line_radiance(scene, anywhere, 500, {20000, 1, 0});
        EXPECT_GT(std::abs(z_score(twin, truth)), 5) << name;
    }
}

TEST(Furnace, StaysSoForColouredScatteringWhereWavelengthsShareTheirPaths) {
    const std::vector<double> nm = testing::wavelengths_in(450, 650, 8);
    for (auto& [name, media] : shapes()) {
        Scene scene;
        scene.lights = {surround_continuum(400, 700)};
        scene.media = media;
        for (std::size_t i = 0; i < scene.media.size(); ++i) {
            const double at500 = std::get<double>(scene.media[i].scattering);
            scene.media[i].scattering = i % 2 == 0 ? Coefficient(PowerLaw{500, at500, -1.6})
                                                   : Coefficient(Spectrum({400, 700}, {0.2 * at500, 2 * at500}));
        }
        const auto seen = testing::spectral_radiance(scene, anywhere, nm, {100000, 2, 0});
        for (std::size_t k = 0; k < nm.size(); ++k) {
            const double truth = continuous_photons_per_nm(scene.lights[0], nm[k]);
            EXPECT_LT(std::abs(z_score(seen.elastic[k], truth)), 5) << name << " at " << nm[k];
            EXPECT_NEAR(seen.elastic[k].mean / truth, 1, 0.006) << name << " at " << nm[k];
        }
        EXPECT_EQ(seen.counts.bound_violations, 0);
    }
}

TEST(Furnace, WavelengthsThatShareWithoutTakingTurnsWouldBeWrong) {
    // The twin of the test above: the same wavelength always steers.
    Scene scene;
    scene.lights = {surround_continuum(400, 700)};
    scene.media = {host(SphereRegion{{0, 0, 0}, 60}, 0, 0)};
    scene.media[0].scattering = Spectrum({400, 700}, {0.001, 0.05});
    const std::vector<double> nm = testing::wavelengths_in(450, 650, 8);
    PathRun run{40000, 2, 0};
    run.rotate = false;
    const auto seen = testing::spectral_radiance(scene, anywhere, nm, run);
    EXPECT_GT(std::abs(z_score(seen.elastic[7], continuous_photons_per_nm(scene.lights[0], nm[7]))), 5);
}

// A grid whose background is not zero goes on for ever; what it takes from one wavelength it may leave to another.
TEST(Furnace, ABackgroundWithoutEndTakesOnlyItsOwnColours) {
    SparseGridBuilder builder(0.5F);
    builder.add_constant({0, 0, 0}, 8, 2);
    const SparseGrid grid = std::move(builder).finish({}, 512);
    const std::vector<double> nm = {450, 500, 600, 650};
    for (const bool scatters : {false, true}) {
        Scene scene;
        scene.lights = {surround_continuum(400, 700)};
        scene.media = {host(grid, 0, 0)};
        const Spectrum red({400, 550, 650}, {0, 0, 0.02});
        scene.media[0].absorption = red;
        if (scatters) scene.media[0].scattering = red;
        const auto seen = testing::spectral_radiance(scene, anywhere, nm, {4000, 5, 0});
        for (std::size_t k = 0; k < nm.size(); ++k) {
            const double truth = continuous_photons_per_nm(scene.lights[0], nm[k]);
            EXPECT_LT(std::abs(z_score(seen.elastic[k], k < 2 ? truth : 0)), 5) << nm[k];
            EXPECT_GT(std::abs(z_score(seen.elastic[k], k < 2 ? 0 : truth)), 5) << nm[k];
        }
    }
}

// Dye whose yield is one, and that absorbs its own light like that of the laser, is one more kind of scattering if all
// orders of conversion count: all photons together are again what comes from outside.
TEST(Furnace, ADyeThatLosesNoPhotonIsInvisibleInTheSumOfAllOrders) {
    for (const double scattering : {0.0, 0.03}) {
        Scene scene;
        scene.dyes = {testing::flat_dye(1e-3, 400, 700, 500, 600, 1)};
        scene.lights = {surround_line(450)};
        scene.media = {testing::dye_in(SphereRegion{{0, 0, 0}, 40}, 0, 10)};
        scene.media.push_back(host(SphereRegion{{0, 0, 0}, 40}, scattering, 0, 0.5));
        const double truth = testing::photons_of(scene.lights[0]);
        const auto at_center = testing::ray_from({0, 0, -50}, {0.1, 0.2, 1});
        const RunningMean line = testing::line_radiance(scene, at_center, 450, {40000, 3, 0});
        const auto glow = testing::spectral_radiance(scene, at_center, testing::wavelengths_in(500, 600, 4),
                                                     {40000, 4, PathTask::kNoLimit});
        const double sum = line.mean + 100 * glow.mean_converted.mean;
        const double error = std::hypot(line.standard_error(), 100 * glow.mean_converted.standard_error());
        EXPECT_LT(std::abs(sum - truth), 5 * error) << sum / truth << " +- " << error / truth;
        EXPECT_LT(error, 0.01 * truth);
    }
}

}  // namespace
}  // namespace fluovox
