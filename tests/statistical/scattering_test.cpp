// Elastic light: one scattering against slow sums, many against exact solutions of the transport equation.
//
// The exact values come from two independent deterministic solvers (matrix-exponential adding-doubling and
// discrete-ordinates eigenmodes, which agree to 1e-10), from Chandrasekhar's H-function (Radiative Transfer, 1950) and
// from Case's solution for a point in an infinite medium.

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

using testing::host;
using testing::line_radiance;
using testing::ray_from;
using testing::RunningMean;
using testing::z_score;

constexpr double kPi = std::numbers::pi;
constexpr double kLaser_nm = 500;
constexpr double kWide_um = 1e7;

double irradiance(const Light& light) {  // of a wide beam, in photons per s and um^2
    const double radius = std::get<BeamLight>(light.shape).radius_um;
    return testing::photons_of(light) / (kPi * radius * radius);
}

// `share`: how far off a wrong result would be that must be found out.
void expect_value(const RunningMean& seen, double truth, double tolerance, double share, const std::string& what) {
    const double error = seen.standard_error() / truth;
    std::printf("  %-28s %+.3f %% +- %.3f %%\n", what.c_str(), 100 * (seen.mean / truth - 1), 100 * error);
    EXPECT_NEAR(seen.mean / truth, 1, tolerance) << what;
    EXPECT_LT(std::abs(z_score(seen, truth)), 5) << what;
    EXPECT_GT(std::abs(z_score(seen, (1 + share) * truth)), 5) << what;
}

std::vector<std::pair<std::string, Light>> lights() {
    SheetLight sheet;
    sheet.position = sheet.waist = {-150, 5, 3};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 60;
    sheet.thickness_um = 12;
    BeamLight beam;
    beam.position = {-150, 5, 3};
    beam.waist = {0, 5, 3};
    beam.direction = {1, 0, 0};
    beam.radius_um = 14;
    BeamLight box = beam;
    box.profile = BeamProfile::Box;
    BeamLight focused = beam;
    focused.numerical_aperture = 0.2;
    PointLight inside;
    inside.position = {5, 12, -9};
    RectangleLight rectangle;
    rectangle.center = {-90, 5, 3};
    rectangle.normal = {1, 0, 0};
    rectangle.up = {0, 0, 1};
    rectangle.width_um = 40;
    rectangle.height_um = 30;
    return {{"sheet", testing::laser(sheet, kLaser_nm, 1e-3)},
            {"beam", testing::laser(beam, kLaser_nm, 1e-3)},
            {"box beam", testing::laser(box, kLaser_nm, 1e-3)},
            {"focused beam", testing::laser(focused, kLaser_nm, 1e-3)},
            {"point inside", testing::laser(inside, kLaser_nm, 1e-3)},
            {"rectangle", testing::laser(rectangle, kLaser_nm, 1e-3)}};
}

TEST(SingleScattering, OfABoxEqualsTheSumOverPoints) {
    const Ray ray{{-20, 3, -80}, normalized({0.25, 0.04, 1})};
    for (const auto& [name, light] : lights()) {
        Scene scene;
        scene.media = {host(BoxRegion{{-50, -40, -30}, {50, 40, 30}}, 0.02, 0.004, 0.7),
                       host(SlabRegion{2, -10, 50}, 0.01, 0.002, -0.3)};
        scene.lights = {light};
        const double truth =
            testing::photons_of(light) * reference::scattered_once(scene, light, ray, kLaser_nm, {180, 6000, 24});
        const RunningMean seen =
            line_radiance(scene, ray_from(ray.origin, ray.direction), kLaser_nm, {200000, 71, 0, 1});
        expect_value(seen, truth, 0.01, 0.03, name);
    }
}

TEST(SingleScattering, OfVoxelsEqualsTheSumOverPoints) {
    Affine map;
    map.rows = {Vec3{1.6, 0.5, 0.1}, Vec3{-0.6, 1.7, 0.2}, Vec3{0.2, -0.3, 1.8}};
    const Ray ray{{-20, 3, -80}, normalized({0.25, 0.04, 1})};
    const auto all = lights();
    for (const std::size_t i : {0U, 2U}) {
        Scene scene;
        scene.media = {host(SparseGrid::from_function({-20, -17, -13}, {20, 17, 13}, map,
                                                      [](Voxel v) { return 1 + 0.5 * ((v.x + v.z) & 1); }),
                            0.02, 0.004, 0.7),
                       host(BoxRegion{{-30, -60, -60}, {20, 60, 60}}, 0.005, 0)};
        scene.lights = {all[i].second};
        const double truth = testing::photons_of(scene.lights[0]) *
                             reference::scattered_once(scene, scene.lights[0], ray, kLaser_nm, {180, 2000, 1});
        const RunningMean seen =
            line_radiance(scene, ray_from(ray.origin, ray.direction), kLaser_nm, {300000, 72, 0, 1});
        expect_value(seen, truth, 0.02, 0.05, all[i].first);
    }
}

// n = 1, 10 /cm absorption, 90 /cm scattering, g = 0.75, 0.02 cm, light along the normal; pi times the diffuse radiance
// over the irradiance. van de Hulst, Multiple Light Scattering (1980), table 35, computed anew.
struct SlabValue {
    double mu, reflected, transmitted;
};
const std::vector<SlabValue> kVanDeHulst = {
    {0.1, 0.13304492689229652, 0.16485885139198445}, {0.3, 0.13855863093861498, 0.2247302600422784},
    {0.5, 0.11956230246143269, 0.2778521568294993},  {0.7, 0.09411171294292907, 0.36889427211182735},
    {0.9, 0.07131543389260275, 0.7215508530454745},  {1.0, 0.06179542024429041, 2.402707861176428}};

void expect_van_de_hulst(const Scene& scene, const std::vector<SlabValue>& values, int samples, double tolerance,
                         double share) {
    const double incoming = irradiance(scene.lights[0]);
    for (const SlabValue& value : values) {
        const double sine = std::sqrt(1 - value.mu * value.mu);
        const RunningMean up =
            line_radiance(scene, ray_from({0, 0, -1}, {sine, 0, value.mu}), kLaser_nm, {samples, 73, 0});
        const RunningMean down =
            line_radiance(scene, ray_from({0, 0, 221}, {sine, 0, -value.mu}), kLaser_nm, {samples, 74, 0});
        const std::string mu = "mu " + std::to_string(value.mu);
        expect_value(up, value.reflected * incoming / kPi, tolerance, share, "reflected, " + mu);
        expect_value(down, value.transmitted * incoming / kPi, tolerance, share, "transmitted, " + mu);
    }
}

TEST(MultipleScattering, OfVanDeHulstsSlabByAngle) {
    Scene scene;
    scene.media = {host(SlabRegion{2, 0, 200}, 0.009, 0.001, 0.75)};
    scene.lights = {testing::wide_beam(kLaser_nm, 1, -10, kWide_um)};
    expect_van_de_hulst(scene, kVanDeHulst, 1000000, 0.01, 0.02);
}

TEST(MultipleScattering, OfVanDeHulstsSlabMadeOfVoxels) {
    // Only the optical depth counts in a slab: the ramps between the last voxels and the empty ones outside do no harm.
    Affine map;
    const double c = 20 * std::cos(0.4);
    const double s = 20 * std::sin(0.4);
    map.rows = {Vec3{c, -s, 0}, Vec3{s, c, 0}, Vec3{0, 0, 20}};
    map.offset = {0, 0, 20};
    Scene scene;
    scene.media = {host(SparseGrid::from_function({-160, -160, 0}, {160, 160, 10}, map, [](Voxel) { return 0.75; }),
                        0.009 / 0.75, 0.001 / 0.75, 0.75)};
    scene.lights = {testing::wide_beam(kLaser_nm, 1, -10, kWide_um)};
    expect_van_de_hulst(scene, {kVanDeHulst[1], kVanDeHulst[4]}, 200000, 0.03, 0.06);
}

TEST(MultipleScattering, OfAHalfSpaceUnderCollimatedLight) {
    // Albedo 0.9, isotropic, irradiance one: radiance per steradian.
    const std::vector<std::pair<double, double>> values = {
        {1.0, 0.12257230683847568}, {0.6, 0.13464680697129844}, {0.2, 0.14259962351837008}};
    Scene scene;
    scene.media = {host(SlabRegion{2}, 0.009, 0.001)};
    scene.media[0].region = SlabRegion{2, 0};
    scene.lights = {testing::wide_beam(kLaser_nm, 1, -10, kWide_um)};
    for (const auto& [mu, value] : values) {
        const RunningMean seen =
            line_radiance(scene, ray_from({0, 0, -1}, {std::sqrt(1 - mu * mu), 0, mu}), kLaser_nm, {100000, 75, 0});
        expect_value(seen, value * irradiance(scene.lights[0]), 0.01, 0.03, "half space, mu " + std::to_string(mu));
    }
}

TEST(MultipleScattering, OfAHalfSpaceUnderUniformLight) {
    // By reciprocity the radiance is the plane albedo: 1 - H(mu) sqrt(1 - w).
    struct Value {
        double albedo, mu, radiance;
    };
    for (const Value& value : {Value{0.9, 1.0, 0.41494747913081687}, Value{0.9, 0.1, 0.6293358207343371},
                               Value{0.99, 1.0, 0.7527207171602974}, Value{0.99, 0.5, 0.8151398983552155}}) {
        Scene scene;
        scene.media = {host(SlabRegion{2, 0}, 0.01 * value.albedo, 0.01 * (1 - value.albedo))};
        scene.lights = {testing::laser(UniformLight{1}, kLaser_nm, 0)};
        const RunningMean seen = line_radiance(
            scene, ray_from({0, 0, -1}, {std::sqrt(1 - value.mu * value.mu), 0, value.mu}), kLaser_nm, {100000, 76, 0});
        expect_value(seen, value.radiance * testing::photons_of(scene.lights[0]), 0.01, 0.03,
                     "uniform, mu " + std::to_string(value.mu));
    }
}

TEST(MultipleScattering, OfSlabsUnderUniformLightFromBothSides) {
    // Reflected plus transmitted, by reciprocity: albedo 0.9, g = 0.5.
    for (const auto& [depth, sum] : {std::pair{1.0, 0.12979327956165113 + 0.7390911205504866},
                                     std::pair{4.0, 0.2611786362941415 + 0.2505325001705679}}) {
        Scene scene;
        scene.media = {host(SlabRegion{2, 0, 100 * depth}, 0.009, 0.001, 0.5)};
        scene.lights = {testing::laser(UniformLight{1}, kLaser_nm, 0)};
        const RunningMean seen = line_radiance(scene, ray_from({0, 0, -1}, {0, 0, 1}), kLaser_nm, {100000, 77, 0});
        expect_value(seen, sum * testing::photons_of(scene.lights[0]), 0.01, 0.02, "slab " + std::to_string(depth));
    }
}

TEST(MultipleScattering, AroundAPointInAnInfiniteMedium) {
    // Fluence per photon, isotropic scattering: albedo 0.9 and a mean free path of 100 um.
    struct Value {
        double scattering, absorption, r_um, fluence_per_um2;
    };
    for (const Value& value :
         {Value{0.009, 0.001, 10, 8.918976939228646e-4}, Value{0.009, 0.001, 100, 0.14328386152545275e-4},
          Value{0.009, 0.001, 200, 0.03712639932400528e-4}}) {
        Scene scene;
        scene.media = {host(Everywhere{}, value.scattering, value.absorption)};
        PointLight point;
        point.position = {0, 0, 0};
        scene.lights = {testing::laser(point, kLaser_nm, 1)};
        const auto around = [&](Rng& rng) {
            return Ray{{value.r_um, 0, 0}, sample_isotropic(rng.uniform(), rng.uniform())};
        };
        const double photons = testing::photons_of(scene.lights[0]);
        const double direct =
            std::exp(-(value.scattering + value.absorption) * value.r_um) / (4 * kPi * value.r_um * value.r_um);
        const RunningMean seen = line_radiance(scene, around, kLaser_nm, {100000, 78, 0});
        expect_value(seen, (value.fluence_per_um2 - direct) * photons / (4 * kPi), 0.1, 0.25,
                     "point, " + std::to_string(value.r_um));
    }
}

TEST(SpectralPaths, EachWavelengthGetsWhatItGetsAlone) {
    // Scattering and absorption of two media differ over the spectrum; eight wavelengths together against each alone.
    const std::vector<double> nm = testing::wavelengths_in(450, 650, 8);
    const auto media = [] {
        std::vector<SceneMedium> all = {host(SlabRegion{2, 0, 150}, 0, 0, 0.6), host(SlabRegion{2, 100, 250}, 0, 0, 0)};
        all[0].scattering = PowerLaw{500, 0.012, -3};
        all[0].absorption = Spectrum({400, 550, 700}, {0.004, 0.0002, 0.003});
        all[1].scattering = Spectrum({400, 700}, {0.001, 0.02});
        all[1].absorption = 0.001;
        return all;
    };
    Scene together;
    together.media = media();
    together.lights = {testing::wide_beam(500, 1, -10, kWide_um)};
    together.lights[0].spectrum.lines.clear();
    together.lights[0].spectrum.energy_per_nm = Spectrum::box(400, 700, 1.0 / 300);
    const auto ray = ray_from({0, 0, -1}, {0.5, 0, 0.9});
    const auto seen = testing::spectral_radiance(together, ray, nm, {150000, 79, 0});
    for (std::size_t k = 0; k < nm.size(); ++k) {
        Scene alone;
        alone.media = media();
        alone.lights = {testing::wide_beam(nm[k], 1, -10, kWide_um)};
        const RunningMean one = line_radiance(alone, ray, nm[k], {60000, 80, 0});
        const double scale =
            continuous_photons_per_nm(together.lights[0], nm[k]) / testing::photons_of(alone.lights[0]);
        const double error = std::hypot(seen.elastic[k].standard_error(), scale * one.standard_error());
        EXPECT_LT(std::abs(seen.elastic[k].mean - scale * one.mean), 5 * error) << nm[k];
        EXPECT_GT(std::abs(seen.elastic[k].mean - 1.1 * scale * one.mean), 5 * error) << nm[k];
        std::printf("  %.1f nm %+.2f %% +- %.2f %%\n", nm[k], 100 * (seen.elastic[k].mean / (scale * one.mean) - 1),
                    100 * error / (scale * one.mean));
    }
}

}  // namespace
}  // namespace fluovox
