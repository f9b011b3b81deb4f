// Phase functions: what is drawn follows the density, the density is right, and every estimator scatters by it.

#include "fluovox/medium/phase_function.h"

#include "fluovox/transport/fluence.h"
#include "fluovox/transport/render.h"

#include "scene_kit.h"
#include "statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using testing::chi_squared_p;
using testing::host;
using testing::kFiveSigma;

constexpr double kPi = std::numbers::pi;

// Of coarse particles: a forward peak, a glory and nothing at all in between.
PhaseTable peaked_table() {
    return {{-1, -0.9, -0.2, 0.1, 0.8, 1}, {6, 1, 0, 0, 5, 40}};
}

struct Kind {
    const char* name;
    PhaseFunction phase, wrong;  // `wrong` is a little off
    std::function<double(double)> formula;
};

double by_formula(double cosine, double g) {
    return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

double by_table(double c) {
    // Trapezia: 0.35 + 0.35 + 0 + 1.75 + 4.5, times 2 pi.
    const double sum = 2 * kPi * (0.5 * 7 * 0.1 + 0.5 * 0.7 + 0.5 * 0.7 * 5 + 0.5 * 0.2 * 45);
    const auto line = [&](double x0, double x1, double y0, double y1) {
        return (y0 + (y1 - y0) * (c - x0) / (x1 - x0)) / sum;
    };
    if (c < -0.9) return line(-1, -0.9, 6, 1);
    if (c < -0.2) return line(-0.9, -0.2, 1, 0);
    if (c < 0.1) return 0;
    return c < 0.8 ? line(0.1, 0.8, 0, 5) : line(0.8, 1, 5, 40);
}

std::vector<Kind> kinds() {
    return {{"isotropic", HenyeyGreenstein{0}, HenyeyGreenstein{0.02}, [](double) { return 1 / (4 * kPi); }},
            {"Henyey-Greenstein", HenyeyGreenstein{0.9}, HenyeyGreenstein{0.897},
             [](double c) { return by_formula(c, 0.9); }},
            {"two-term", TwoTermHenyeyGreenstein{0.8, -0.5, 0.7}, TwoTermHenyeyGreenstein{0.8, -0.5, 0.71},
             [](double c) { return 0.7 * by_formula(c, 0.8) + 0.3 * by_formula(c, -0.5); }},
            {"Rayleigh", Rayleigh{}, PhaseTable({-1, -0.5, 0, 0.5, 1}, {2, 1.35, 1, 1.25, 2}),
             [](double c) { return 3 / (16 * kPi) * (1 + c * c); }},
            {"table", peaked_table(), PhaseTable({-1, -0.9, -0.2, 0.1, 0.8, 1}, {6, 1, 0, 0, 5.1, 40}), by_table}};
}

TEST(PhaseFunction, CosinesFollowTheDensityOfEveryKind) {
    constexpr int kBins = 100;
    constexpr int kDraws = 1000000;
    for (const Kind& kind : kinds()) {
        std::vector<double> expected(kBins, 0);
        for (int i = 0; i < kBins * 200; ++i)
            expected[static_cast<std::size_t>(i / 200)] +=
                kDraws * 2 * kPi * kind.formula(-1 + (i + 0.5) * 2 / (kBins * 200)) * 2 / (kBins * 200);
        const auto p = [&](const PhaseFunction& phase) {
            std::vector<double> counts(kBins, 0);
            Rng rng(3, 0, 0);
            for (int n = 0; n < kDraws; ++n) {
                const double cosine = sample_phase_cosine(phase, rng.uniform());
                ++counts[static_cast<std::size_t>(std::min(kBins - 1.0, std::floor((cosine + 1) * 0.5 * kBins)))];
            }
            return chi_squared_p(counts, expected);
        };
        EXPECT_GT(p(kind.phase), kFiveSigma) << kind.name;
        EXPECT_LT(p(kind.wrong), kFiveSigma) << kind.name;
    }
}

TEST(PhaseFunction, DensityIsThatOfTheFormulaAndItsMeanCosineTheAnisotropy) {
    for (const Kind& kind : kinds()) {
        double total = 0;
        double mean = 0;
        constexpr int kSteps = 200000;
        for (int i = 0; i < kSteps; ++i) {
            const double cosine = -1 + (i + 0.5) * 2 / kSteps;
            const double density = phase_per_sr(kind.phase, cosine);
            ASSERT_NEAR(density, kind.formula(cosine), 1e-9 * (1 + density)) << kind.name << ' ' << cosine;
            total += 2 * kPi * density * 2 / kSteps;
            mean += 2 * kPi * cosine * density * 2 / kSteps;
        }
        EXPECT_NEAR(total, 1, 1e-6) << kind.name;
        EXPECT_NEAR(mean, mean_cosine(kind.phase), 1e-6) << kind.name;
    }
}

TEST(PhaseFunction, TablesThatAreNoneAreRefused) {
    using Numbers = std::vector<double>;
    const auto refused = [](const Numbers& cosines, const Numbers& values) {
        EXPECT_THROW((PhaseTable{cosines, values}), std::invalid_argument);
    };
    refused({-1, 1}, {0, 0});
    refused({-1, 0, 1}, {1, -1, 1});
    refused({-0.9, 1}, {1, 1});
    refused({-1, 0.9}, {1, 1});
    refused({-1, 0, 0, 1}, {1, 1, 1, 1});
    refused({-1, 1}, {1e308, 1e308});
    refused({}, {});
    EXPECT_NEAR(PhaseTable({-1, 1}, {3, 3}).given_integral(), 12 * kPi, 1e-12);
}

// A slab that scatters and absorbs, lit by a beam along z, with one scattering at most: everything has a closed form.
constexpr double kDepth_um = 10, kScattering = 0.02, kAbsorption = 0.01, kExtinction = kScattering + kAbsorption;

Scene slab(const PhaseFunction& phase) {
    BeamLight beam;
    beam.position = beam.waist = {0, 0, -1};
    beam.direction = {0, 0, 1};
    beam.radius_um = 5;
    beam.profile = BeamProfile::Box;
    Scene scene;
    scene.media = {host(SlabRegion{2, 0, kDepth_um}, kScattering, kAbsorption)};
    scene.media[0].phase = phase;
    scene.lights = {testing::laser(beam, 500, 1)};
    scene.description.render.max_scatterings = 1;
    scene.description.film = testing::spectrometer(490, 510, 1);
    return scene;
}

// Watts per steradian, of one watt, that leave at a cosine to +z after one scattering, for a phase function of value 1.
double single_scattering_per_sr(double cosine) {
    // Int mu_s exp(-mu z) exp(-mu (d - z) / c) dz forward, exp(-mu z / |c|) backward.
    const double c = std::abs(cosine);
    const double mu = kExtinction;
    if (cosine < 0) return kScattering * (1 - std::exp(-mu * kDepth_um * (1 + 1 / c))) / (mu * (1 + 1 / c));
    const double k = mu * (1 / c - 1);
    const double integral = k * kDepth_um < 1e-9 ? kDepth_um : -std::expm1(-k * kDepth_um) / k;
    return kScattering * std::exp(-mu * kDepth_um) * integral;
}

TEST(PhaseFunction, PhotonsLeaveASlabByIt) {
    constexpr int kBins = 30;  // of each face
    for (const Kind& kind : kinds()) {
        FluenceSettings settings;
        settings.photons = 1200000;
        settings.angle_bins = kBins;
        NoProgress progress;
        const FluenceResult got = trace_fluence(slab(kind.phase), settings, progress);
        std::vector<double> counts;
        std::vector<double> expected;
        std::vector<double> of_formula;
        for (const int face : {4, 5}) {
            for (int bin = 0; bin < kBins; ++bin) {
                // Weights differ by absorption alone; the expected variance is close to that of counts.
                const Estimate& e =
                    got.share.excitation.by_angle[static_cast<std::size_t>(face)][2][static_cast<std::size_t>(bin)];
                if (!(e.standard_error > 0)) continue;
                double sum = 0;
                constexpr int kSteps = 200;
                for (int i = 0; i < kSteps; ++i) {
                    const double angle = (bin + (i + 0.5) / kSteps) * 0.5 * kPi / kBins;
                    const double cosine = (face == 5 ? 1 : -1) * std::cos(angle);
                    sum += kind.formula(cosine) * single_scattering_per_sr(cosine) * 2 * kPi * std::sin(angle) * 0.5 *
                           kPi / kBins / kSteps;
                }
                const double scale = e.value / (e.standard_error * e.standard_error);  // to counts
                counts.push_back(e.value * scale);
                expected.push_back(sum * scale);
                of_formula.push_back(sum * scale * (face == 5 ? 1.05 : 1));
            }
        }
        EXPECT_GT(counts.size(), 20U);
        EXPECT_GT(chi_squared_p(counts, expected), kFiveSigma) << kind.name;
        EXPECT_LT(chi_squared_p(counts, of_formula), kFiveSigma) << kind.name << ": 5 % more forward is found out";
    }
}

TEST(PhaseFunction, ImagesFromTheCameraAndFromTheLightsFollowIt) {
    constexpr double kField_um = 60;
    for (const Kind& kind : kinds()) {
        for (const double degrees : {12.0, 50.0, 160.0}) {
            const double angle = degrees * kPi / 180;
            const Vec3 seen{std::sin(angle), 0, std::cos(angle)};  // flight of the light that is seen
            Scene scene = slab(kind.phase);
            scene.description.camera =
                testing::one_pixel(Vec3{0, 0, 5} + 200.0 * seen, {0, 0, 5}, {0, 1, 0}, kField_um);
            const double per_sr = kind.formula(seen.z) * single_scattering_per_sr(seen.z);
            const double expected = per_sr / (kField_um * kField_um * 1e-12) / 20;  // W/m2/sr/nm
            for (const char* estimator : {"path", "light"}) {
                scene.description.render.estimator = estimator;
                scene.description.render.samples = 200000;
                NoProgress progress;
                const Film film = render(scene, progress).film;
                const double error = std::sqrt(film.variance_of_mean(0, 0, 0));
                const double z = (film.mean(0, 0, 0) - expected) / (error + 1e-6 * expected);
                EXPECT_LT(std::abs(z), 5) << kind.name << ' ' << degrees << ' ' << estimator;
                EXPECT_GT(std::abs(film.mean(0, 0, 0) - 1.1 * expected), 5 * error)
                    << kind.name << ' ' << degrees << ' ' << estimator << ": 10 % more is found out";
            }
        }
    }
}

// Many scatterings, guided excitation of a dye: both estimators find the same.
TEST(PhaseFunction, FluorescenceInItAgreesBetweenTheEstimators) {
    for (const Kind& kind : kinds()) {
        const BoxRegion box{{-50, -50, 0}, {50, 50, 100}};
        Scene scene = slab(kind.phase);
        scene.media = {host(box, 0.02, 0.002), testing::dye_in(SphereRegion{{10, 0, 50}, 30}, 0, 1)};
        scene.media[0].phase = kind.phase;
        scene.dyes = {testing::flat_dye(0.005, 400, 530, 510, 610, 0.8)};
        scene.description.render.max_scatterings.reset();
        scene.description.film = testing::spectrometer(510, 610, 1);
        scene.description.camera = testing::one_pixel({0, 200, 50}, {0, 0, 50}, {0, 0, 1}, 90);
        std::array<double, 2> value{};
        double variance = 0;
        for (const int i : {0, 1}) {
            scene.description.render.estimator = i == 0 ? "path" : "light";
            scene.description.render.samples = i == 0 ? 200000 : 600000;
            NoProgress progress;
            const Film film = render(scene, progress).film;
            value.at(static_cast<std::size_t>(i)) = film.mean(2, 0, 0);
            variance += film.variance_of_mean(2, 0, 0);
        }
        EXPECT_LT(std::abs(value[0] - value[1]), 5 * std::sqrt(variance)) << kind.name;
        EXPECT_GT(0.2 * value[0], 5 * std::sqrt(variance)) << kind.name << ": 20 % would be found out";
    }
}

}  // namespace
}  // namespace fluovox
