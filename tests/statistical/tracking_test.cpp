// Free flights, transmittance and turns: what every path is made of.

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/optical_field.h"

#include "random_grids.h"
#include "scene_kit.h"
#include "slow_light.h"
#include "statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace fluovox {
namespace {

using testing::chi_squared_p;
using testing::host;
using testing::kFiveSigma;
using testing::kolmogorov_smirnov_p;
using testing::RunningMean;
using testing::z_score;

constexpr double kFar = std::numeric_limits<double>::infinity();

Wavelengths lanes_at(const std::vector<double>& nm) {
    Wavelengths wavelengths(static_cast<int>(nm.size()));
    for (int k = 0; k < wavelengths.count(); ++k) {
        wavelengths.nm[k] = nm[static_cast<std::size_t>(k)];
        wavelengths.pdf_per_nm[k] = 1;
    }
    return wavelengths;
}

// Optical depth along a ray by looking at every point.
double depth_by_points(const Scene& scene, const Ray& ray, double from_um, double to_um, double nm, Loss loss) {
    double depth = 0;
    constexpr int kPoints = 40000;
    const double step = (to_um - from_um) / kPoints;
    for (int i = 0; i < kPoints; ++i) {
        const Vec3 p = ray.at(from_um + (i + 0.5) * step);
        for (const SceneMedium& medium : scene.media) {
            const double amount = reference::amount_at(scene, medium, p);
            if (amount == 0) continue;
            const double absorption =
                medium.dye >= 0 ? absorption_per_um_per_uM(scene.dyes[static_cast<std::size_t>(medium.dye)], nm)
                                : coefficient_per_um(medium.absorption, nm);
            const double scattering = medium.dye >= 0 ? 0 : coefficient_per_um(medium.scattering, nm);
            depth += step * amount * (absorption + (loss == Loss::Extinction ? scattering : 0));
        }
    }
    return depth;
}

Ray random_chord(Rng& rng, double radius) {
    const Vec3 from = radius * sample_isotropic(rng.uniform(), rng.uniform());
    const Vec3 to = 0.5 * radius * sample_isotropic(rng.uniform(), rng.uniform());
    return {from, normalized(to - from)};
}

Scene nested_regions() {
    Scene scene;
    scene.dyes = {testing::flat_dye(1e-3, 400, 500, 500, 600, 0.5)};
    scene.media = {
        host(BoxRegion{{-50, -40, -30}, {50, 40, 30}}, 0.004, 0.001),
        host(SphereRegion{{10, 0, 0}, 25}, 0.01, 0.002),
        host(CylinderRegion{{-60, -10, -10}, {60, 20, 10}, 12}, 0.006, 0.004),
        host(SlabRegion{1, -5, 15}, 0.003, 0.0005),
        testing::dye_in(SphereRegion{{-20, 0, 0}, 30}, 0, 7),
        host(Everywhere{}, 0, 1e-4),
    };
    return scene;
}

TEST(BeerLambert, ConstantRegionsAddUpWhereTheyOverlap) {
    const Scene scene = nested_regions();
    OpticalField field(scene);
    std::vector<MediumSpan> spans;
    Rng rng(1, 0, 0);
    for (int i = 0; i < 60; ++i) {
        const Ray ray = random_chord(rng, 100);
        field.gather(ray, spans);
        const double end = 40 + 120 * rng.uniform();
        const Lanes seen = field.transmittance(ray, spans, end, field.optics(lanes_at({450, 550})),
                                               i % 2 == 0 ? Loss::Extinction : Loss::Absorption, rng);
        for (int k = 0; k < 2; ++k) {
            const double depth = depth_by_points(scene, ray, 0, end, k == 0 ? 450 : 550,
                                                 i % 2 == 0 ? Loss::Extinction : Loss::Absorption);
            EXPECT_NEAR(-std::log(seen[k]), depth, 2e-3 * depth + 1e-6) << "ray " << i;
        }
    }
}

TEST(BeerLambert, AnExclusiveRegionReplacesWhatItCutsOut) {
    Scene scene = nested_regions();
    scene.media[0].cut_by = {1, 2};
    scene.media[4].cut_by = {1};
    scene.media[5].cut_by = {0, 3};
    OpticalField field(scene);
    std::vector<MediumSpan> spans;
    Rng rng(2, 0, 0);
    int twins = 0;
    for (int i = 0; i < 60; ++i) {
        const Ray ray = random_chord(rng, 100);
        field.gather(ray, spans);
        const Lanes seen = field.transmittance(ray, spans, 150, field.optics(lanes_at({450})), Loss::Extinction, rng);
        const double depth = depth_by_points(scene, ray, 0, 150, 450, Loss::Extinction);
        EXPECT_NEAR(-std::log(seen[0]), depth, 2e-3 * depth + 1e-6) << "ray " << i;
        const double uncut = depth_by_points(nested_regions(), ray, 0, 150, 450, Loss::Extinction);
        twins += std::abs(-std::log(seen[0]) - uncut) > 2e-3 * uncut + 1e-6 ? 1 : 0;
    }
    EXPECT_GT(twins, 30);
}

TEST(BeerLambert, AnExclusiveSlabReplacesTheHalfSpaceAndTheEverywhereAroundIt) {
    const auto described = [](Region region, double absorption, bool exclusive) {
        MediumDescription medium;
        medium.region = region;
        medium.absorption = absorption;
        medium.exclusive = exclusive;
        return medium;
    };
    SceneDescription description;
    description.media = {described(Everywhere{}, 1e-4, false), described(SlabRegion{2, 0}, 1e-3, false),
                         described(SlabRegion{2, 10, 30}, 1e-2, true)};
    const Scene scene = build_scene(description);
    OpticalField field(scene);
    std::vector<MediumSpan> spans;
    Rng rng(15, 0, 0);
    const Ray ray{{0, 0, -10}, {0, 0, 1}};
    field.gather(ray, spans);
    const Lanes seen = field.transmittance(ray, spans, 100, field.optics(lanes_at({500})), Loss::Extinction, rng);
    EXPECT_NEAR(-std::log(seen[0]), 80e-4 + 70e-3 + 20e-2, 1e-9);
}

// Noise, a constant box and a dye, all at once.
Scene grids_and_a_box() {
    Rng rng(3, 0, 0);
    Scene scene;
    scene.dyes = {testing::flat_dye(0.004, 400, 500, 500, 600, 0.5)};
    scene.media.push_back(host(testing::random_grid(rng, testing::random_affine(rng), 0), 0.02, 0.01));
    scene.media.push_back(testing::dye_in(testing::random_grid(rng, testing::random_affine(rng), 0.05F), 0));
    scene.media.push_back(host(BoxRegion{{-80, -80, -80}, {80, 80, 80}}, 0.002, 0.001));
    return scene;
}

struct Transmitted {
    RunningMean ratio, twin;  // estimate over truth, and over the truth of one per cent more extinction
    std::int64_t violations = 0;
};

Transmitted transmitted(Loss loss, int lane) {
    const Scene scene = grids_and_a_box();
    OpticalField field(scene);
    const PathOptics optics = field.optics(lanes_at({450, 550}));
    std::vector<MediumSpan> spans;
    Rng rng(4, static_cast<std::uint64_t>(lane), 0);
    Transmitted result;
    for (int i = 0; i < 24; ++i) {
        const Ray ray = random_chord(rng, 150);
        const double depth = depth_by_points(scene, ray, 0, 220, lane == 0 ? 450 : 550, loss);
        if (depth > 4) continue;
        field.gather(ray, spans);
        for (int n = 0; n < 20000; ++n) {
            const double seen = field.transmittance(ray, spans, 220, optics, loss, rng)[lane];
            result.ratio.add(seen / std::exp(-depth));
            result.twin.add(seen / std::exp(-1.01 * depth));
        }
    }
    result.violations = field.counts().bound_violations;
    return result;
}

TEST(BeerLambert, RatioTrackingThroughGridsIsUnbiased) {
    for (const Loss loss : {Loss::Extinction, Loss::Absorption}) {
        for (const int lane : {0, 1}) {
            const Transmitted found = transmitted(loss, lane);
            EXPECT_GT(found.ratio.count, 100000);
            EXPECT_LT(std::abs(z_score(found.ratio, 1)), 5);
            EXPECT_EQ(found.violations, 0);
            if (loss == Loss::Extinction && lane == 0) {
                EXPECT_GT(std::abs(z_score(found.twin, 1)), 5);
            }
        }
    }
}

// With roulette where little is left, and all or nothing from the start.
TEST(BeerLambert, OneWavelengthThroughAGridIsUnbiasedHoweverEarlyRouletteBegins) {
    Scene scene = grids_and_a_box();
    scene.media.resize(1);
    OpticalField field(scene);
    const double coefficient = field.optics(lanes_at({450})).media[0].extinction[0];
    for (const double dim : {0.1, 0.4, 1.0}) {
        Rng rng(17, 0, 0);
        RunningMean ratio;
        RunningMean twin;
        int between = 0;
        for (int i = 0; i < 24; ++i) {
            const Ray ray = random_chord(rng, 150);
            const double depth = depth_by_points(scene, ray, 0, 220, 450, Loss::Extinction);
            if (depth > 3) continue;
            for (int n = 0; n < 40000; ++n) {
                const double seen = field.ratio_transmittance(0, ray, 220, coefficient, dim, rng);
                between += seen > 0 && seen < dim ? 1 : 0;
                ratio.add(seen / std::exp(-depth));
                twin.add(seen / std::exp(-1.03 * depth));
            }
        }
        EXPECT_EQ(between, 0) << dim;
        EXPECT_LT(std::abs(z_score(ratio, 1)), 5) << dim;
        EXPECT_GT(std::abs(z_score(twin, 1)), 5) << dim;
    }
    EXPECT_EQ(field.counts().bound_violations, 0);
}

TEST(BeerLambert, DarknessBehindManyMeanFreePathsKeepsItsExpectation) {
    // The roulette of ratio tracking acts here: the depth is 12.
    Scene scene;
    scene.media = {
        host(SparseGrid::from_function({0, 0, 0}, {100, 10, 10}, {}, [](Voxel v) { return v.x % 7; }), 0.04, 0)};
    OpticalField field(scene);
    const PathOptics optics = field.optics(lanes_at({500}));
    const Ray ray{{-5, 4.2, 4.7}, {1, 0, 0}};
    const double depth = depth_by_points(scene, ray, 0, 120, 500, Loss::Extinction);
    ASSERT_GT(depth, 10);
    std::vector<MediumSpan> spans;
    Rng rng(5, 0, 0);
    RunningMean seen;
    for (int n = 0; n < 1000000; ++n)
        seen.add(field.transmittance(ray, spans, 120, optics, Loss::Extinction, rng)[0]);
    EXPECT_LT(std::abs(z_score(seen, std::exp(-depth))), 5);
    EXPECT_GT(std::abs(z_score(seen, std::exp(-1.05 * depth))), 5);
}

TEST(FreeFlight, AsManyPassUnscatteredAsBeerLambertSays) {
    const Scene scene = grids_and_a_box();
    Scene scattering_only = scene;
    for (SceneMedium& medium : scattering_only.media)
        medium.absorption = 0.0;
    scattering_only.media[1].amount = 0;  // the dye
    OpticalField field(scene);
    const PathOptics optics = field.optics(lanes_at({450}));
    std::vector<MediumSpan> spans;
    Rng rng(6, 0, 0);
    RunningMean passed;
    RunningMean twin;
    for (int i = 0; i < 24; ++i) {
        const Ray ray = random_chord(rng, 150);
        const double depth = depth_by_points(scattering_only, ray, 0, 400, 450, Loss::Extinction);
        field.gather(ray, spans);
        Lanes likeness;
        for (int n = 0; n < 80000; ++n) {
            const double through = field.sample_scattering(ray, spans, optics, rng, likeness) ? 0 : 1;
            passed.add(through - std::exp(-depth));
            twin.add(through - std::exp(-1.01 * depth));
        }
    }
    EXPECT_LT(std::abs(z_score(passed, 0)), 5);
    EXPECT_GT(std::abs(z_score(twin, 0)), 5);
    EXPECT_EQ(field.counts().bound_violations, 0);
}

// Two slabs of different scattering, the second overlapped by a third medium.
Scene two_slabs(bool gridded) {
    Scene scene;
    if (!gridded) {
        scene.media = {host(SlabRegion{0, 5, 15}, 0.05, 0.02), host(SlabRegion{0, 15, 45}, 0.02, 0),
                       host(BoxRegion{{30, -9, -9}, {60, 9, 9}}, 0.03, 0)};
        return scene;
    }
    const auto slabs = [](Voxel v) { return v.x < 15 ? 2.0 : v.x < 45 ? 1.0 : 0.0; };
    scene.media = {host(SparseGrid::from_function({5, -20, -20}, {60, 20, 20}, {}, slabs), 0.025, 0.02),
                   host(BoxRegion{{30, -9, -9}, {60, 9, 9}}, 0.03, 0)};
    return scene;
}

double two_slab_p(bool gridded, double wrong) {
    const Scene scene = two_slabs(gridded);
    OpticalField field(scene);
    const PathOptics optics = field.optics(lanes_at({500}));
    const Ray ray{{0, 1.3, -0.8}, normalized({1, 0.05, 0.03})};
    std::vector<MediumSpan> spans;
    field.gather(ray, spans);
    Scene pure = scene;
    for (SceneMedium& medium : pure.media)
        medium.absorption = 0.0;
    constexpr int kSteps = 700;
    std::vector<double> depth = {0};  // at tenths of a micrometre
    for (int i = 0; i < kSteps; ++i) {
        double step = 0;
        for (int j = 0; j < 10; ++j) {
            const Vec3 p = ray.at(0.1 * i + 0.005 + 0.01 * j);
            for (const SceneMedium& medium : pure.media) {
                const double amount = medium.grid ? medium.grid->trilinear(p) : contains(medium.region, p) ? 1 : 0;
                step += 0.01 * amount * coefficient_per_um(medium.scattering, 500);
            }
        }
        depth.push_back(depth.back() + wrong * step);
    }
    const auto cdf = [&](double t) {
        const double place = std::min(10 * t, kSteps - 1e-9);
        const auto i = static_cast<std::size_t>(place);
        const double here = depth[i] + (place - static_cast<double>(i)) * (depth[i + 1] - depth[i]);
        return std::expm1(-here) / std::expm1(-depth.back());
    };
    std::vector<double> flights;
    Rng rng(7, gridded ? 1 : 0, 0);
    Lanes likeness;
    for (int n = 0; n < 1000000; ++n) {
        if (const auto scattering = field.sample_scattering(ray, spans, optics, rng, likeness))
            flights.push_back(scattering->t_um);
    }
    return kolmogorov_smirnov_p(flights, cdf);
}

TEST(FreeFlight, FollowsItsDistributionThroughTwoSlabs) {
    EXPECT_GT(two_slab_p(false, 1), kFiveSigma);
    EXPECT_LT(two_slab_p(false, 1.03), kFiveSigma);
}

TEST(FreeFlight, FollowsItsDistributionThroughTwoSlabsOfVoxels) {
    EXPECT_GT(two_slab_p(true, 1), kFiveSigma);
    EXPECT_LT(two_slab_p(true, 1.03), kFiveSigma);
}

TEST(FreeFlight, GoesToEachMediumAsOftenAsItScatters) {
    Scene scene;
    scene.media = {
        host(BoxRegion{{0, -9, -9}, {50, 9, 9}}, 0.03, 0),
        host(SparseGrid::from_function({-10, -20, -20}, {70, 20, 20}, {}, [](Voxel) { return 0.5; }), 0.04, 0),
        host(Everywhere{}, 0.01, 0)};
    OpticalField field(scene);
    const PathOptics optics = field.optics(lanes_at({500}));
    const Ray ray{{0, 0, 0}, {1, 0, 0}};
    std::vector<MediumSpan> spans;
    field.gather(ray, spans);
    std::vector<double> hits(3, 0);
    Rng rng(8, 0, 0);
    Lanes likeness;
    double inside = 0;
    for (int n = 0; n < 400000; ++n) {
        const auto scattering = field.sample_scattering(ray, spans, optics, rng, likeness);
        ASSERT_TRUE(scattering);  // the last medium is everywhere
        if (scattering->t_um > 50) continue;
        ++inside;
        ++hits[static_cast<std::size_t>(scattering->medium)];
    }
    EXPECT_GT(chi_squared_p(hits, {inside * 3 / 6, inside * 2 / 6, inside * 1 / 6}), kFiveSigma);
    EXPECT_LT(chi_squared_p(hits, {inside * 3.05 / 6, inside * 1.95 / 6, inside * 1 / 6}), kFiveSigma);
}

// Media whose colours differ, so that each wavelength has its own free flights.
Scene coloured_media() {
    Rng rng(9, 0, 0);
    Scene scene;
    scene.media.push_back(host(BoxRegion{{0, -90, -90}, {40, 90, 90}}, 0, 0.001));
    scene.media.back().scattering = Spectrum({400, 700}, {0.05, 0.0});
    scene.media.push_back(host(SlabRegion{0, 20, 70}, 0, 0.002));
    scene.media.back().scattering = Spectrum({400, 700}, {0.004, 0.03});
    scene.media.push_back(host(testing::random_grid(rng, Affine{}, 0), 0, 0.001));
    scene.media.back().scattering = PowerLaw{500, 0.03, -4};
    scene.media.push_back(host(testing::random_grid(rng, Affine{}, 0), 0, 0.001));
    scene.media.back().scattering = PowerLaw{500, 0.02, 1};
    return scene;
}

TEST(SpectralPaths, LikenessTurnsTheHerosFlightsIntoThoseOfEachWavelength) {
    const Scene scene = coloured_media();
    OpticalField field(scene);
    const std::vector<double> wavelengths = {500, 430, 560, 640};
    const PathOptics optics = field.optics(lanes_at(wavelengths));
    Rng rng(10, 0, 0);
    Rng rays(10, 3, 0);
    int twins_told = 0;
    std::vector<MediumSpan> spans;
    for (int r = 0; r < 4; ++r) {
        Ray ray = random_chord(rays, 60);
        field.gather(ray, spans);
        std::vector<RunningMean> passes(4);
        std::vector<RunningMean> early(4);
        std::vector<RunningMean> twins(4);
        std::vector<double> all(4);
        std::vector<double> first(4);
        for (std::size_t k = 0; k < 4; ++k) {
            Scene pure = scene;
            for (SceneMedium& medium : pure.media)
                medium.absorption = 0.0;
            all[k] = std::exp(-depth_by_points(pure, ray, 0, 400, wavelengths[k], Loss::Extinction));
            first[k] = 1 - std::exp(-depth_by_points(pure, ray, 0, 70, wavelengths[k], Loss::Extinction));
        }
        for (int n = 0; n < 200000; ++n) {
            Lanes likeness;
            const auto scattering = field.sample_scattering(ray, spans, optics, rng, likeness);
            for (int k = 0; k < 4; ++k) {
                const auto i = static_cast<std::size_t>(k);
                passes[i].add(scattering ? 0 : likeness[k]);
                early[i].add(scattering && scattering->t_um < 70 ? likeness[k] : 0);
                twins[i].add(scattering ? 0 : 1);  // forgets the likeness
            }
        }
        for (std::size_t k = 0; k < 4; ++k) {
            EXPECT_LT(std::abs(z_score(passes[k], all[k])), 5) << "ray " << r << ", lane " << k;
            EXPECT_LT(std::abs(z_score(early[k], first[k])), 5) << "ray " << r << ", lane " << k;
        }
        twins_told += std::abs(z_score(twins[3], all[3])) > 5 ? 1 : 0;
    }
    EXPECT_GE(twins_told, 2);  // a chord may happen to be alike for two wavelengths
    EXPECT_EQ(field.counts().bound_violations, 0);
}

TEST(SpectralPaths, ScatteringAtAPointIsThatOfAllMediaThere) {
    const Scene scene = coloured_media();
    OpticalField field(scene);
    const PathOptics optics = field.optics(lanes_at({500, 640}));
    Rng rng(11, 0, 0);
    std::vector<MediumSpan> spans;
    std::vector<Lanes> by_medium;
    RunningMean ratio;
    for (int r = 0; r < 20; ++r) {
        const Ray ray = random_chord(rng, 60);
        field.gather(ray, spans);
        const double t = 5 + 100 * rng.uniform();
        double truth = 0;
        for (const SceneMedium& medium : scene.media) {
            const Vec3 p = ray.at(t);
            const double amount = medium.grid ? medium.grid->trilinear(p) : contains(medium.region, p) ? 1 : 0;
            truth += amount * coefficient_per_um(medium.scattering, 640);
        }
        if (truth <= 0) continue;
        for (int n = 0; n < 20000; ++n)
            ratio.add(field.scattering_at(ray, t, spans, optics, by_medium, rng)[1] / truth);
    }
    EXPECT_GE(ratio.count, 100000);
    EXPECT_LT(std::abs(z_score(ratio, 1)), 5);
    EXPECT_GT(std::abs(z_score(ratio, 1.01)), 5);
}

TEST(Reach, HoldsEveryPointWithAMedium) {
    const Scene scene = grids_and_a_box();
    Scene bounded = scene;
    bounded.media.erase(bounded.media.begin() + 1);  // the one with a background is everywhere
    OpticalField field(bounded);
    std::vector<MediumSpan> spans;
    Rng rng(14, 0, 0);
    for (int i = 0; i < 300; ++i) {
        const Ray ray = random_chord(rng, 300);
        field.gather(ray, spans);
        const Interval reach = field.reach(ray, spans);
        for (int j = 0; j < 200; ++j) {
            const double t = 600 * rng.uniform();
            if (bounded.media[0].grid->trilinear(ray.at(t)) > 1e-9) {
                EXPECT_GE(t, reach.begin);
                EXPECT_LE(t, reach.end);
            }
        }
    }
    OpticalField endless(scene);
    EXPECT_EQ(endless.reach({{0, 0, 0}, {1, 0, 0}}, {}).end, kFar);
}

}  // namespace
}  // namespace fluovox
