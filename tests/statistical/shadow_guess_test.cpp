// Guesses of how much light gets to where paths scatter: near the truth, and of no weight where they are not.

#include "fluovox/transport/light_shadows.h"
#include "fluovox/volume/grid_integral.h"
#include "fluovox/volume/shadow_grid.h"

#include "lit_specimen.h"
#include "random_grids.h"
#include "statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace fluovox {
namespace {

using testing::apart;
using testing::kManyPaths;
using testing::lit_specimen;
using testing::random_affine;
using testing::RunningMean;
using testing::Seen;
using testing::specimen;

// The integral of the field along a ray by the places where it passes from cell to cell.
template <class Rule>
double slow_integral(const SparseGrid& grid, const Ray& ray, double end_um, const Rule& rule) {
    const Vec3 origin = grid.index_from_world().point(ray.origin);
    const Vec3 speed = grid.index_from_world().direction(ray.direction);
    std::vector<double> places = {0, end_um};
    for (int axis = 0; axis < 3; ++axis) {
        if (speed[axis] == 0) continue;
        const double last = origin[axis] + end_um * speed[axis];
        for (double plane = std::ceil(std::min(origin[axis], last)); plane < std::max(origin[axis], last); ++plane)
            places.push_back((plane - origin[axis]) / speed[axis]);
    }
    std::sort(places.begin(), places.end());
    double total = 0;
    for (std::size_t i = 1; i < places.size(); ++i)
        total += rule(places[i - 1], places[i], [&](double t) { return grid.trilinear(ray.at(t)); });
    return total;
}

constexpr auto kSimpson = [](double a, double b, const auto& f) {
    return (b - a) / 6 * (f(a) + 4 * f(0.5 * (a + b)) + f(b));
};
constexpr auto kMidpoint = [](double a, double b, const auto& f) { return (b - a) * f(0.5 * (a + b)); };

// The largest error, as a share of what is there.
template <class Rule>
double worst_integral(const Rule& rule) {
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        Rng rng(seed, 0, 0);
        const SparseGrid grid = testing::random_grid(rng, seed == 1 ? Affine{} : random_affine(rng), 0);
        for (int n = 0; n < 30; ++n) {
            const Ray ray = testing::random_ray(grid, n, rng);
            const double slow = slow_integral(grid, ray, 2000, rule);
            worst = std::max(worst, std::abs(integral_along(grid, ray) - slow) / std::max(slow, 1.0));
        }
    }
    return worst;
}

TEST(GridIntegral, IsWhatSimpsonsRuleGivesCellByCell) {
    EXPECT_LT(worst_integral(kSimpson), 1e-6);
}

TEST(GridIntegral, TheMiddleOfEachCellWouldNotDo) {
    EXPECT_GT(worst_integral(kMidpoint), 1e-3);
}

TEST(GridIntegral, MayEndOnceItIsEnough) {
    Rng rng(7, 0, 0);
    const SparseGrid grid = testing::random_grid(rng, {}, 0);
    int ended = 0;
    for (int n = 0; n < 200; ++n) {
        const Ray ray = testing::random_ray(grid, n, rng);
        const double all = integral_along(grid, ray);
        GridIntegral integral(5);
        integral.add(grid, ray);
        if (integral.total() < 5) {
            EXPECT_DOUBLE_EQ(integral.total(), all);
            continue;
        }
        ++ended;
        const double rest = integral_along(grid, {ray.at(integral.end()), ray.direction});
        EXPECT_NEAR(integral.total() + rest, all, 1e-6 * all);
    }
    EXPECT_GT(ended, 10);
}

// Root mean square error of guesses in and around voxels, of light that comes from `to_light`.
double guess_error(const SparseGrid& grid, Vec3 made_for, Vec3 to_light, double coefficient) {
    const ShadowGrid shadows(grid, made_for, coefficient);
    EXPECT_GT(shadows.spots().size(), 400U);
    Rng rng(3, 0, 0);
    RunningMean squares;
    for (const Voxel& spot : shadows.spots()) {
        EXPECT_GT(grid.value(spot), 0);
        const auto beside = [&](int at) { return at + rng.uniform() - 0.5; };
        const Vec3 world = grid.world_from_index().point({beside(spot.x), beside(spot.y), beside(spot.z)});
        const double truth = std::exp(-coefficient * integral_along(grid, {world, to_light}));
        const double guess = ShadowGrid::guess(shadows.find(world, spot)).share;
        EXPECT_GE(guess, 0);
        EXPECT_LE(guess, 1);
        squares.add((guess - truth) * (guess - truth));
    }
    return std::sqrt(squares.mean);
}

TEST(ShadowGrid, GuessesWithinAFewPercentWhereverLightComesFrom) {
    Rng rng(5, 0, 0);
    std::vector<Vec3> directions = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}, normalized(Vec3{-1, 1, 1})};
    for (int i = 0; i < 12; ++i)
        directions.push_back(sample_isotropic(rng.uniform(), rng.uniform()));
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const SparseGrid grid = specimen(i % 2 == 0 ? Affine{} : random_affine(rng));
        EXPECT_LT(guess_error(grid, directions[i], directions[i], 0.2), 0.07) << i;
        // Light from elsewhere is not what was asked for.
        EXPECT_GT(guess_error(grid, -directions[i], directions[i], 0.2), 0.1) << i;
    }
}

constexpr double kScattering = 0.25;

Seen look_at(const Scene& scene, const LightShadows& shadows, std::uint64_t seed, int samples = 400000) {
    const auto guess = [&](LinePlan& plan) {
        for (LinePlan::ShiningLight& light : plan.lights)
            light.guess = shadows.find(0, light.index);
    };
    return testing::look_at(scene, guess, seed, samples);
}

LightShadows shadows_for(const Scene& scene) {
    return {scene, Illumination(scene), kManyPaths};
}

TEST(ShadowGuess, ChangesNoExpectation) {
    for (const double around : {0.0, 0.005}) {
        const Scene scene = lit_specimen(kScattering, around);
        const LightShadows shadows = shadows_for(scene);
        ASSERT_FALSE(shadows.empty());
        const Seen guessed = look_at(scene, shadows, 1);
        const Seen followed = look_at(scene, {}, 2);
        EXPECT_LT(std::abs(apart(guessed, followed)), 5) << around;
        EXPECT_EQ(guessed.counts.bound_violations, 0);
        Scene brighter = scene;
        brighter.lights[0].power_W *= 1.04;
        EXPECT_GT(std::abs(apart(look_at(brighter, shadows, 1), followed)), 5) << around;
    }
}

// Most where light gets through: deep inside it is dark with guesses or without.
TEST(ShadowGuess, TakesNoiseAway) {
    for (const double around : {0.0, 0.005}) {
        const Scene scene = lit_specimen(0.1, around);
        const LightShadows shadows = shadows_for(scene);
        ASSERT_FALSE(shadows.empty());
        const Seen guessed = look_at(scene, shadows, 1);
        const Seen followed = look_at(scene, {}, 2);
        EXPECT_LT(guessed.radiance.standard_error(), followed.radiance.standard_error()) << around;
    }
}

// What guesses say of the places of voxels, with their corrections or without: means over all of them.
struct Said {
    double guess = 0, truth = 0, chance = 0;
};

Said said_of(const Scene& scene, double scattering) {
    const SparseGrid& grid = *scene.media[0].grid;
    const Vec3 to_light = -std::get<SheetLight>(scene.lights[0].shape).direction;
    const ShadowGuess guesses(grid, to_light, scattering + 0.01);
    Said said;
    const std::vector<Voxel> spots = ShadowGrid(grid, to_light, 1).spots();
    const auto count = static_cast<double>(spots.size());
    for (const Voxel& spot : spots) {
        const Vec3 world = grid.world_from_index().point({1.0 * spot.x, 1.0 * spot.y, 1.0 * spot.z});
        const ShadowGuess::Guess guess = guesses.at(guesses.find(world, spot));
        said.guess += guess.share / count;
        said.chance += guess.chance / count;
        said.truth += std::exp(-(kScattering + 0.01) * integral_along(grid, {world, to_light})) / count;
    }
    return said;
}

TEST(ShadowGuess, IsSeldomCorrected) {
    const Said said = said_of(lit_specimen(kScattering), kScattering);
    EXPECT_LT(said.chance, 0.06);
    EXPECT_NEAR(said.guess, said.truth, 0.02);
}

// Guesses for another medium are bad ones, no more. They leave a quarter of the light to their corrections: without
// those, or with a fifth of them too many, it would be off by what shows here.
TEST(ShadowGuess, NeedNotBeGood) {
    const Scene scene = lit_specimen(kScattering);
    const Said said = said_of(scene, 4 * kScattering);
    EXPECT_LT(said.guess, 0.75 * said.truth);
    const Scene denser = lit_specimen(4 * kScattering);
    const Seen guessed = look_at(scene, shadows_for(denser), 3, 600000);
    EXPECT_LT(std::abs(apart(guessed, look_at(scene, {}, 4))), 5);
    Scene brighter = scene;
    brighter.lights[0].power_W *= 1.05;
    EXPECT_GT(std::abs(apart(guessed, look_at(brighter, {}, 4))), 5);
}

TEST(ShadowGrid, KeepsSpotsEvenlyHoweverManyVoxelsAreActive) {
    Rng rng(9, 0, 0);
    const SparseGrid grid = testing::random_grid(rng, {}, 0);  // of one active voxel, it says
    ASSERT_EQ(grid.active_voxels(), 1U);
    EXPECT_GT(grid.filled_voxels(), 10000U);
    const ShadowGrid shadows(grid, {0, 0, 1}, 0.1);
    EXPECT_GE(shadows.spots().size(), 512U);
    EXPECT_LE(shadows.spots().size(), 1024U);
    for (const Voxel& spot : shadows.spots())
        EXPECT_GT(grid.value(spot), 0);
}

TEST(LightShadows, AreMadeOnlyWhereTheyPay) {
    const Scene good = lit_specimen(kScattering);
    const auto made = [](const Scene& scene, std::int64_t paths = kManyPaths) {
        return !LightShadows(scene, Illumination(scene), paths).empty();
    };
    EXPECT_TRUE(made(good));
    EXPECT_FALSE(made(good, 100)) << "few paths";
    EXPECT_FALSE(made(lit_specimen(1e-4))) << "light is hardly scattered";
    Scene scene = good;
    scene.description.render.plain_tracking = true;
    EXPECT_FALSE(made(scene)) << "the reference";
    scene = good;
    scene.description.film = testing::spectrometer(600, 610, 1);
    EXPECT_FALSE(made(scene)) << "not seen by the film";
    scene = good;
    scene.media.push_back(good.media[0]);
    EXPECT_FALSE(made(scene)) << "two grids";
    scene = good;
    std::get<SheetLight>(scene.lights[0].shape).profile = BeamProfile::Gaussian;
    EXPECT_FALSE(made(scene)) << "light that is brighter here than there";
}

// Lines of light for all of a wide plate, or for its two corners.
TEST(LightShadows, AreNotMadeOfAnAlmostEmptyBox) {
    for (const bool full : {true, false}) {
        const auto value = [&](Voxel v) { return full || v.x + v.y == 0 || v.x + v.y == 2198 ? 1.0 : 0.0; };
        Scene scene = lit_specimen(kScattering);
        scene.media = {testing::host(SparseGrid::from_function({0, 0, 0}, {1100, 1100, 2}, {}, value), 1, 0.01)};
        scene.lights[0].shape = testing::slanting_light({550, 550, 1}, 6000);
        EXPECT_EQ(LightShadows(scene, Illumination(scene), kManyPaths).empty(), !full);
    }
}

}  // namespace
}  // namespace fluovox
