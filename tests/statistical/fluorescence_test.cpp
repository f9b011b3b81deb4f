// Fluorescence in scattering media: exact fluxes out of slabs and half spaces, cascades of conversions, and photons
// followed one by one.

#include "path_kit.h"
#include "photon_walk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::host;
using testing::RunningMean;
using testing::z_score;

constexpr double kPi = std::numbers::pi;
constexpr double kLaser_nm = 450;
constexpr double kWide_um = 1e7;

double irradiance(const Light& light) {  // of a wide beam, in photons per s and um^2
    const double radius = std::get<BeamLight>(light.shape).radius_um;
    return testing::photons_of(light) / (kPi * radius * radius);
}

// Rays into a plane z, from all directions of its half space in proportion to the cosine: pi times their mean radiance
// is the flux that leaves there.
testing::RayMaker hemisphere(double z_um, double toward) {
    return [=](Rng& rng) {
        const double mu = std::sqrt(rng.uniform());
        const Vec3 direction = turned({0, 0, toward}, mu, rng.uniform());
        return Ray{{0, 0, z_um}, direction};
    };
}

void expect_share(const RunningMean& seen, double truth, double tolerance, double share, const std::string& what) {
    const double error = seen.standard_error() / truth;
    std::printf("  %-28s %+.3f %% +- %.3f %%\n", what.c_str(), 100 * (seen.mean / truth - 1), 100 * error);
    EXPECT_NEAR(seen.mean / truth, 1, tolerance) << what;
    EXPECT_LT(std::abs(z_score(seen, truth)), 5) << what;
    EXPECT_GT(std::abs(z_score(seen, (1 + share) * truth)), 5) << what;
}

// Fluence of the laser times escape of the glow, discrete ordinates: 1 cm, isotropic scattering 10 and 8 /cm,
// absorption 0.2 (half of it the dye's, yield 0.5) and 0.05 /cm.
TEST(FluorescentSlab, FluxesOutOfBothFaces) {
    Scene scene;
    scene.dyes = {testing::flat_dye(1e-5, 400, 500, 500, 600, 0.5)};
    scene.media = {host(SlabRegion{2, 0, 1e4}, 0, 0), dye_in(SlabRegion{2, 0, 1e4}, 0, 1)};
    scene.media[0].scattering = Spectrum({450, 500}, {10e-4, 8e-4});
    scene.media[0].absorption = Spectrum({450, 500}, {0.1e-4, 0.05e-4});
    scene.lights = {testing::wide_beam(kLaser_nm, 1, -10, kWide_um)};
    const double unit = irradiance(scene.lights[0]) / kPi;
    const auto nm = testing::wavelengths_in(500, 600, 4);
    const auto front = testing::spectral_radiance(scene, hemisphere(-1, 1), nm, {60000, 81});
    expect_share(front.mean_converted, 0.04096438573128347 * unit / 100, 0.03, 0.06, "out of the front");
    const auto back = testing::spectral_radiance(scene, hemisphere(10001, -1), nm, {60000, 82});
    expect_share(back.mean_converted, 0.01926949922327948 * unit / 100, 0.03, 0.08, "out of the back");
    expect_share(testing::line_radiance(scene, hemisphere(-1, 1), kLaser_nm, {60000, 83}), 0.6704986790361837 * unit,
                 0.01, 0.03, "laser reflected");
}

// Plane albedo of a half space that scatters isotropically, for light along the normal: 1 - H(1) sqrt(1 - w), with
// ln H(1) = -1/pi Int_0^pi/2 ln(1 - w t cot t) / (cos^2 t + sin^2 t) dt.
double half_space_albedo(double w) {
    constexpr int kSteps = 20000;
    double total = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double t = 0.5 * kPi * (i + 0.5) / kSteps;
        total += std::log(1 - w * t / std::tan(t)) * 0.5 * kPi / kSteps;
    }
    return 1 - std::exp(-total / kPi) * std::sqrt(1 - w);
}

// A dye that absorbs its own light as it does the laser's is, generation by generation, one more scatterer: with a
// share `yield w_dye` of the albedo. Taylor's series of the albedo gives the generations.
double generations(double w_scattering, double extra, int orders) {
    if (orders == PathTask::kNoLimit) return half_space_albedo(w_scattering + extra) - half_space_albedo(w_scattering);
    constexpr double h = 0.004;
    const auto a = [&](int k) { return half_space_albedo(w_scattering + k * h); };
    double sum = extra * (a(-2) - 8 * a(-1) + 8 * a(1) - a(2)) / (12 * h);
    if (orders > 1) sum += extra * extra / 2 * (-a(-2) + 16 * a(-1) - 30 * a(0) + 16 * a(1) - a(2)) / (12 * h * h);
    return sum;
}

Scene cascade(double w_scattering, double w_dye, double yield) {
    constexpr double kExtinction = 0.01;
    Scene scene;
    scene.dyes = {testing::flat_dye(w_dye * kExtinction, 400, 700, 500, 600, yield)};
    scene.media = {host(SlabRegion{2, 0}, w_scattering * kExtinction, (1 - w_scattering - w_dye) * kExtinction),
                   dye_in(SlabRegion{2, 0}, 0, 1)};
    scene.lights = {testing::wide_beam(kLaser_nm, 1, -10, kWide_um)};
    return scene;
}

TEST(Cascade, GenerationsOfConversionOutOfAHalfSpace) {
    EXPECT_NEAR(generations(0.9, 0.9 * 0.08, 1), 0.1313406881098878, 2e-6);  // published figures of the same identity
    EXPECT_NEAR(generations(0.9, 0.9 * 0.08, PathTask::kNoLimit), 0.6248877375450475 - 0.4149474791308169, 1e-6);
    struct Case {
        double w_scattering, w_dye, yield;
    };
    for (const Case& c : {Case{0.9, 0.08, 0.9}, Case{0.5, 0.4, 0.5}}) {
        const Scene scene = cascade(c.w_scattering, c.w_dye, c.yield);
        const double unit = irradiance(scene.lights[0]) / kPi;
        double before = 0;
        for (const int orders : {1, 2, PathTask::kNoLimit}) {
            const auto seen = testing::spectral_radiance(scene, hemisphere(-1, 1), testing::wavelengths_in(500, 600, 2),
                                                         {50000, 84, orders});
            const double truth = generations(c.w_scattering, c.yield * c.w_dye, orders);
            expect_share(seen.mean_converted, truth * unit / 100, 0.03, 0.06,
                         orders == PathTask::kNoLimit ? "all orders" : "orders " + std::to_string(orders));
            EXPECT_GT(truth, before);
            before = truth;
        }
    }
}

// A box of tissue with a ball of dye and a grid of dye in it, under a beam; camera of four pixels beside it.
Scene specimen() {
    Scene scene;
    scene.dyes = {testing::flat_dye(0.004, 440, 460, 500, 600, 0.8)};
    Affine map;
    map.rows = {Vec3{4, 1, 0}, Vec3{-1, 4, 0}, Vec3{0, 0, 4}};
    scene.media = {
        host(BoxRegion{{-50, -40, -30}, {50, 40, 30}}, 0, 0, 0.6), dye_in(SphereRegion{{-10, 5, 0}, 25}, 0, 3),
        dye_in(
            SparseGrid::from_function({0, -6, -5}, {8, 6, 6}, map, [](Voxel v) { return 2.0 + 2 * ((v.x + v.y) & 1); }),
            0)};
    scene.media[0].scattering = Spectrum({450, 500}, {0.03, 0.02});
    scene.media[0].absorption = Spectrum({450, 500}, {0.002, 0.001});
    BeamLight beam;
    beam.position = beam.waist = {-90, 0, 0};
    beam.direction = {1, 0, 0};
    beam.radius_um = 20;
    beam.profile = BeamProfile::Box;
    scene.lights = {testing::laser(beam, kLaser_nm, 1e-3)};
    Camera& camera = scene.description.camera;
    camera = testing::one_pixel({0, 0, 200}, {0, 0, 0}, {0, 1, 0}, 80, 0.6);
    camera.width = 4;
    camera.height = 2;
    camera.focus_um = 190;
    scene.description.film = testing::spectrometer(440, 600, 16);
    scene.description.film.unit = FilmUnit::Photons;
    return scene;
}

Ray launch(reference::Dice& dice) {
    std::uniform_real_distribution<double> u(0, 1);
    const double r = 20 * std::sqrt(u(dice));
    const double azimuth = 2 * kPi * u(dice);
    return {{-90, r * std::cos(azimuth), r * std::sin(azimuth)}, {1, 0, 0}};
}

TEST(PhotonByPhoton, TheCameraSeesWhatPhotonsFollowedOneByOneShow) {
    Scene scene = specimen();
    // No extinction is above 0.032 (tissue) + 0.012 (ball) + 0.016 (grid).
    const auto counts = reference::walk(scene, launch, {kLaser_nm, 150, 0.062, 1, 3000000, 87});
    scene.description.render.samples = 15000;
    NoProgress quiet;
    const RenderResult result = render(scene, quiet);
    EXPECT_EQ(result.counts.bound_violations, 0);
    EXPECT_EQ(result.film.nan_count(), 0);
    const double photons = testing::photons_of(scene.lights[0]);
    double sum = 0;
    double truth_sum = 0;
    double error_sum = 0;
    int glow_twins = 0;
    for (const bool glow : {true, false}) {
        const int layer = result.film.layer(glow ? kFluorescenceLayer : kElasticLayer);
        for (int pixel = 0; pixel < 8; ++pixel) {
            const auto hits = (glow ? counts.glow_in_pixel : counts.laser_in_pixel)[static_cast<std::size_t>(pixel)];
            const auto truth = counts.radiance(scene.description.camera, hits);
            double seen = 0;
            double variance = 0;
            for (int c = 0; c < 16; ++c) {
                seen += 10 * result.film.mean(layer, pixel, c);
                variance += 100 * result.film.variance_of_mean(layer, pixel, c);  // bins of one sample are nearly apart
            }
            seen /= photons * 1e12;
            const double error = std::hypot(truth.error, std::sqrt(2 * variance) / (photons * 1e12));
            EXPECT_LT(std::abs(seen - truth.value), 5 * error) << (glow ? "glow, " : "laser, ") << pixel;
            std::printf("  %s %d: %+.2f %% +- %.2f %%\n", glow ? "glow" : "laser", pixel,
                        100 * (seen / truth.value - 1), 100 * error / truth.value);
            if (!glow) continue;
            sum += seen;
            truth_sum += truth.value;
            error_sum = std::hypot(error_sum, error);
            glow_twins += std::abs(seen - 1.3 * truth.value) > 5 * error ? 1 : 0;
        }
    }
    EXPECT_LT(std::abs(sum - truth_sum), 5 * error_sum);
    EXPECT_GT(std::abs(sum - 1.08 * truth_sum), 5 * error_sum);
    EXPECT_GT(glow_twins, 4);
}

// Sum over the picture of the fluorescence with few scatterings, at both wavelengths together.
TEST(PhotonByPhoton, AgreesOrderByOrderOfScattering) {
    for (const int scatterings : {0, 1, 2}) {
        Scene scene = specimen();
        scene.description.render.max_scatterings = scatterings;
        scene.description.render.samples = 4000;
        reference::WalkSettings settings{kLaser_nm, 150, 0.062, 1, 1000000, 90};
        settings.scatterings = scatterings;
        const auto counts = reference::walk(scene, launch, settings);
        NoProgress quiet;
        const Film film = render(scene, quiet).film;
        double hits = 0;
        double seen = 0;
        double variance = 0;
        for (int pixel = 0; pixel < 8; ++pixel) {
            hits += counts.glow_in_pixel[static_cast<std::size_t>(pixel)];
            for (int c = 0; c < 16; ++c) {
                seen += 10 * film.mean(film.layer(kFluorescenceLayer), pixel, c);
                variance += 200 * film.variance_of_mean(film.layer(kFluorescenceLayer), pixel, c);
            }
        }
        const double unit = testing::photons_of(scene.lights[0]) * 1e12;
        const auto truth = counts.radiance(scene.description.camera, hits);
        const double error = std::hypot(truth.error, std::sqrt(variance) / unit);
        std::printf("  up to %d: %+.2f %% +- %.2f %%\n", scatterings, 100 * (seen / unit / truth.value - 1),
                    100 * error / truth.value);
        EXPECT_LT(std::abs(seen / unit - truth.value), 5 * error) << scatterings;
        EXPECT_GT(std::abs(seen / unit - 1.15 * truth.value), 5 * error) << scatterings;
    }
}

// The laser excites only the first of three boxes, its glow only the second, and the glow of that only the third, which
// alone the film sees.
Scene three_dyes(int orders) {
    Scene scene;
    scene.description.render.fluorescence_orders = orders;
    scene.dyes = {testing::flat_dye(0.01, 440, 460, 500, 510, 0.9), testing::flat_dye(0.01, 499, 511, 550, 560, 0.8),
                  testing::flat_dye(0.01, 549, 561, 600, 610, 0.7)};
    for (int d = 0; d < 3; ++d) {
        scene.dyes[static_cast<std::size_t>(d)].name = "dye" + std::to_string(d);
        scene.media.push_back(dye_in(BoxRegion{{20.0 * d - 30, -25, -25}, {20.0 * d - 10, 25, 25}}, d, 5));
    }
    scene.media.push_back(host(BoxRegion{{-30, -25, -25}, {30, 25, 25}}, 0.01, 0, 0.5));
    BeamLight beam;
    beam.position = beam.waist = {-55, 0, 0};
    beam.direction = {1, 0, 0};
    beam.radius_um = 20;
    beam.profile = BeamProfile::Box;
    scene.lights = {testing::laser(beam, kLaser_nm, 1e-3)};
    scene.description.camera = testing::one_pixel({20, 0, 100}, {20, 0, 0}, {0, 1, 0}, 50, 0.7);
    scene.description.film = testing::spectrometer(600, 610, 1);
    scene.description.film.unit = FilmUnit::Photons;
    return scene;
}

TEST(PhotonByPhoton, AChainOfThreeDyesIsFollowedToItsEnd) {
    Scene scene = three_dyes(3);
    const Camera& camera = scene.description.camera;
    const auto from_55 = [](reference::Dice& dice) {
        Ray ray = launch(dice);
        ray.origin.x = -55;
        return ray;
    };
    const auto counts = reference::walk(scene, from_55, {kLaser_nm, 60, 0.06, 3, 3000000, 89, 600, 610});
    scene.description.render.samples = 200000;
    NoProgress quiet;
    const RenderResult result = render(scene, quiet);
    const int layer = result.film.layer(kFluorescenceLayer);
    const double unit = 10 / (testing::photons_of(scene.lights[0]) * 1e12);
    const double seen = unit * result.film.mean(layer, 0, 0);
    const double error = unit * std::sqrt(result.film.variance_of_mean(layer, 0, 0));
    const auto truth = counts.radiance(camera, counts.glow_in_pixel[0]);
    const double both = std::hypot(error, truth.error);
    std::printf("  chain of %.0f: %+.2f %% +- %.2f %%\n", counts.glow_in_pixel[0], 100 * (seen / truth.value - 1),
                100 * both / truth.value);
    EXPECT_LT(std::abs(seen - truth.value), 5 * both);
    EXPECT_GT(std::abs(seen - 1.3 * truth.value), 5 * both);
    scene = three_dyes(2);
    scene.description.render.samples = 2000;
    EXPECT_EQ(render(scene, quiet).film.mean(layer, 0, 0), 0);
}

TEST(PhotonByPhoton, ItsOwnBooksAreInBalance) {
    const auto counts = reference::walk(specimen(), launch, {kLaser_nm, 150, 0.062, 1, 200000, 88});
    EXPECT_EQ(counts.launched, counts.escaped_as_laser + counts.escaped_as_glow + counts.absorbed_by_host +
                                   counts.absorbed_by_dye - counts.reemitted);
    RunningMean yield;
    for (double n = 0; n < counts.absorbed_by_dye; ++n)
        yield.add(n < counts.reemitted ? 1 : 0);
    EXPECT_LT(std::abs(z_score(yield, 0.8)), 5);
}

}  // namespace
}  // namespace fluovox
