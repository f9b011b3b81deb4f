// Clear dye: what a ray sees of it is an integral along a line, here done step by step.

#include "path_kit.h"
#include "slow_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using testing::RunningMean;
using testing::z_score;

constexpr double kLaser_nm = 480;
constexpr double kEmission_nm = 555;

SheetLight sheet(BeamProfile profile, double numerical_aperture) {
    SheetLight light;
    light.position = {-150, 5, 3};
    light.direction = {1, 0, 0};
    light.normal = {0, 0, 1};
    light.width_um = 90;
    light.thickness_um = 12;
    light.profile = profile;
    light.numerical_aperture = numerical_aperture;
    light.waist = {0, 5, 3};
    return light;
}

BeamLight beam(BeamProfile profile, double numerical_aperture) {
    BeamLight light;
    light.position = {-150, 5, 3};
    light.direction = {1, 0, 0};
    light.radius_um = 14;
    light.profile = profile;
    light.numerical_aperture = numerical_aperture;
    light.waist = {20, 5, 3};
    return light;
}

std::vector<std::pair<std::string, Light>> lights() {
    std::vector<std::pair<std::string, Light>> all;
    const auto add = [&](const char* name, auto shape) {
        all.emplace_back(name, testing::laser(std::move(shape), kLaser_nm, 1e-3));
    };
    add("gaussian sheet", sheet(BeamProfile::Gaussian, 0));
    add("box sheet", sheet(BeamProfile::Box, 0));
    add("focused sheet", sheet(BeamProfile::Gaussian, 0.1));
    add("gaussian beam", beam(BeamProfile::Gaussian, 0));
    add("box beam", beam(BeamProfile::Box, 0));
    add("focused beam", beam(BeamProfile::Gaussian, 0.2));
    PointLight point;
    point.position = {-70, 10, -20};
    add("point outside", point);
    point.position = {5, 12, -9};
    add("point inside", point);
    RectangleLight rectangle;
    rectangle.center = {-90, 5, 3};
    rectangle.normal = {1, 0, 0};
    rectangle.up = {0, 0, 1};
    rectangle.width_um = 40;
    rectangle.height_um = 30;
    add("rectangle", rectangle);
    return all;
}

// Absorbs the laser strongly and its own light weakly.
Dye own_absorber() {
    Dye dye = testing::flat_dye(1, 470, 600, 540, 600, 0.7);
    dye.molar_absorption_per_M_cm =
        Spectrum({470, 500, 530, 600}, {0.002e10 / std::log(10.0), 0.002e10 / std::log(10.0), 1e7, 0.5e7});
    return dye;
}

Scene cuvette(const Light& light, double uM) {
    Scene scene;
    scene.dyes = {own_absorber()};
    scene.media = {testing::dye_in(BoxRegion{{-50, -40, -30}, {50, 40, 30}}, 0, uM)};
    scene.media.push_back(testing::host(SlabRegion{2, -20, 100}, 0, 0.002));  // a filter that only absorbs
    scene.lights = {light};
    return scene;
}

const Ray kRay{{-20, 3, -80}, normalized({0.25, 0.04, 1})};

// Compares one ray with the sum over its points; gives the spread of a single sample over the mean.
double compare(const Scene& scene, const std::string& name, const Ray& ray, int samples, double tolerance,
               reference::Along along = {180, 6000, 24}) {
    const double truth = testing::photons_of(scene.lights[0]) *
                         reference::converted_once(scene, scene.lights[0], ray, {0, kLaser_nm, kEmission_nm}, along);
    const auto seen = testing::spectral_radiance(scene, testing::ray_from(ray.origin, ray.direction), {kEmission_nm},
                                                 {samples, 61, 1});
    const RunningMean& radiance = seen.mean_converted;
    EXPECT_GT(truth, 0) << name;
    EXPECT_NEAR(radiance.mean / truth, 1, tolerance) << name;
    EXPECT_LT(std::abs(radiance.mean - truth), 5 * radiance.standard_error() + 2e-4 * truth) << name;
    EXPECT_GT(std::abs(radiance.mean - (1 + 5 * tolerance) * truth), 5 * radiance.standard_error() + 2e-4 * truth)
        << name;
    EXPECT_EQ(seen.counts.bound_violations, 0) << name;
    const double spread = radiance.standard_error() * std::sqrt(static_cast<double>(samples)) / radiance.mean;
    std::printf("  %-16s spread of one sample %.3f\n", name.c_str(), spread);
    return spread;
}

TEST(ClearCuvette, RadianceAlongARayIsTheIntegralForEveryLight) {
    for (const auto& [name, light] : lights())
        compare(cuvette(light, 8), name, kRay, 100000, 0.002);
}

TEST(ClearCuvette, IsAlmostWithoutNoiseUnderASheet) {
    EXPECT_LT(compare(cuvette(lights()[0].second, 0.1), "thin", {{0, 3, -80}, {0, 0, 1}}, 100000, 0.002), 0.4);
}

// The same dye as voxels, turned and sheared: points are looked up by one stochastic tap.
Scene voxel_cuvette(const Light& light, double uM) {
    Affine map;
    map.rows = {Vec3{1.6, 0.5, 0.1}, Vec3{-0.6, 1.7, 0.2}, Vec3{0.2, -0.3, 1.8}};
    map.offset = {2, 4, 1};
    Scene scene;
    scene.dyes = {own_absorber()};
    scene.media = {
        testing::dye_in(SparseGrid::from_function({-20, -17, -13}, {20, 17, 13}, map,
                                                  [&](Voxel v) { return uM * (1 + 0.5 * ((v.x + v.z) & 1)); }),
                        0)};
    scene.lights = {light};
    return scene;
}

TEST(ClearCuvette, VoxelsOfDyeGiveTheIntegralOfTheirTrilinearField) {
    const auto all = lights();
    for (const std::size_t i : {0U, 3U, 7U})
        compare(voxel_cuvette(all[i].second, 6), all[i].first, kRay, 600000, 0.006, {180, 2500, 1});
}

TEST(ClearCuvette, BrightnessIsLinearInTheConcentrationWhenThinAndSaturatesAsPredictedWhenThick) {
    const Light light = lights()[1].second;  // box sheet
    const Dye dye = own_absorber();
    const double mu_x = absorption_per_um_per_uM(dye, kLaser_nm);
    const double mu_m = absorption_per_um_per_uM(dye, kEmission_nm);
    const Ray ray{{0, 3, -80}, {0, 0, 1}};  // across the sheet, 50 um behind the wall
    std::vector<double> brightness;
    const std::vector<double> concentrations = {0.001, 0.002, 0.1, 1, 10, 30, 100};
    for (const double uM : concentrations) {
        Scene scene = cuvette(light, uM);
        scene.media.resize(1);
        const auto seen = testing::spectral_radiance(scene, testing::ray_from(ray.origin, ray.direction),
                                                     {kEmission_nm}, {200000, 62});
        // The light crosses 50 um of dye, what it makes another 33 to 45 um.
        const double fluence = testing::photons_of(light) / (90 * 12) * std::exp(-mu_x * uM * 50);
        const double closed = fluence * 0.7 * mu_x * uM / 60 / (4 * std::numbers::pi) *
                              (std::exp(-mu_m * uM * 27) - std::exp(-mu_m * uM * 39)) / (mu_m * uM);
        EXPECT_NEAR(seen.mean_converted.mean / closed, 1, 0.002) << uM;
        EXPECT_LT(std::abs(z_score(seen.mean_converted, closed)), 5) << uM;
        brightness.push_back(seen.mean_converted.mean);
    }
    EXPECT_NEAR(brightness[1] / brightness[0], 2, 0.004);
    EXPECT_GT(brightness[4], brightness[5]);  // past the maximum the light no longer gets here
    EXPECT_GT(brightness[5], brightness[6]);
}

}  // namespace
}  // namespace fluovox
