// Russian roulette by what paths may still find: no expectation changes, and it is put where it pays.

#include "fluovox/transport/weight_window.h"

#include "fluovox/transport/path_prepass.h"

#include "lit_specimen.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace fluovox {
namespace {

using testing::apart;
using testing::kManyPaths;
using testing::lit_specimen;
using testing::look_at;
using testing::Seen;

constexpr double kDense = 2;

PathPrepass prepass_of(const Scene& scene, std::int64_t paths = kManyPaths) {
    return {scene, Illumination(scene), paths};
}

bool has_window(const Scene& scene, std::int64_t paths = kManyPaths) {
    const PathPrepass prepass = prepass_of(scene, paths);
    LinePlan plan;
    prepass.add_to(plan, 0);
    return plan.window != nullptr;
}

// With guesses in each case.
Seen look_through(const WeightWindow* window, const Scene& scene, std::uint64_t seed) {
    const PathPrepass prepass = prepass_of(scene);
    const auto change = [&](LinePlan& plan) {
        prepass.add_to(plan, 0);
        plan.window = window;
    };
    return look_at(scene, change, seed, 300000);
}

Scene brighter(Scene scene) {
    for (Light& light : scene.lights)
        light.power_W *= 1.06;
    return scene;
}

TEST(WeightWindow, ChangesNoExpectationAndSavesTime) {
    const Scene scene = lit_specimen(kDense);
    const PathPrepass prepass = prepass_of(scene);
    const Seen seen = look_at(
        scene, [&](LinePlan& plan) { prepass.add_to(plan, 0); }, 1, 300000);
    const Seen followed = look_through(nullptr, scene, 2);
    EXPECT_LT(std::abs(apart(seen, followed)), 5);
    EXPECT_GT(std::abs(apart(seen, look_through(nullptr, brighter(scene), 2))), 5);
    EXPECT_EQ(seen.counts.bound_violations, 0);
    const auto scatterings = [](const Seen& of) { return static_cast<double>(of.counts.real_collisions); };
    const auto noise = [](const Seen& of) { return of.radiance.standard_error() * of.radiance.standard_error(); };
    EXPECT_LT(scatterings(seen), 0.7 * scatterings(followed));
    EXPECT_LT(noise(seen) * scatterings(seen), 0.95 * noise(followed) * scatterings(followed));
}

// A second light from elsewhere, a medium around the specimen, and few scatterings.
TEST(WeightWindow, ChangesNoExpectationWhereThereIsMore) {
    Scene two_lights = lit_specimen(kDense);
    two_lights.lights.push_back(testing::laser(testing::slanting_light({32, 32, 32}, 400, {-0.6, 0, -0.8}), 488, 3));
    struct Case {
        Scene scene;
        int scatterings = PathTask::kNoLimit;
    };
    for (const auto& [scene, scatterings] :
         {Case{two_lights}, Case{lit_specimen(kDense, 0.005)}, Case{lit_specimen(kDense), 12}}) {
        ASSERT_TRUE(has_window(scene));
        const PathPrepass prepass = prepass_of(scene);
        const auto both = [&](LinePlan& plan) { prepass.add_to(plan, 0); };
        const auto guesses = [&](LinePlan& plan) {
            prepass.add_to(plan, 0);
            plan.window = nullptr;
        };
        const Seen seen = look_at(scene, both, 5, 200000, scatterings);
        EXPECT_LT(std::abs(apart(seen, look_at(scene, guesses, 6, 200000, scatterings))), 5);
        EXPECT_GT(std::abs(apart(seen, look_at(brighter(scene), guesses, 6, 200000, scatterings))), 5);
    }
}

// One that ends paths at random.
// A window goes by what the first light of a plan leaves at a vertex.
TEST(LinePlan, HasTheBrightestOfTheLightsThatShineOnAllFirst) {
    const auto first_of = [](double first_W, double second_W, double width_um) {
        Scene scene = lit_specimen(kDense);
        scene.lights[0].power_W = first_W;
        scene.lights.push_back(
            testing::laser(testing::slanting_light({32, 32, 32}, width_um, {-0.6, 0, -0.8}), 488, second_W));
        return testing::LinePaths(scene).plan().lights[0].index;
    };
    EXPECT_EQ(first_of(1, 3, 400), 1);
    EXPECT_EQ(first_of(3, 1, 400), 0);
    EXPECT_EQ(first_of(1, 3, 20), 0);  // shines on a part only
}

TEST(WeightWindow, NeedNotBeGood) {
    const Scene scene = lit_specimen(kDense);
    Rng rng(1, 2, 3);
    WeightWindow::Bounds bounds{};
    for (float& bound : bounds)
        bound = static_cast<float>(0.1 + rng.uniform() * (WeightWindow::kMost - 0.1));
    const WeightWindow window(bounds);
    const Seen seen = look_through(&window, scene, 3);
    EXPECT_LT(std::abs(apart(seen, look_through(nullptr, scene, 4))), 5);
    EXPECT_GT(std::abs(apart(seen, look_through(nullptr, brighter(scene), 4))), 5);
}

TEST(WeightWindow, IsThereOnlyWhereItPays) {
    EXPECT_TRUE(has_window(lit_specimen(kDense)));
    EXPECT_FALSE(has_window(lit_specimen(kDense), 60000)) << "few paths";
    EXPECT_FALSE(has_window(lit_specimen(0.05))) << "hardly any path would end";
    Scene scene = lit_specimen(kDense);
    scene.media[0].phase = HenyeyGreenstein{0.9};
    EXPECT_FALSE(has_window(scene)) << "light is scattered sharply";
    scene = lit_specimen(kDense);
    scene.description.camera.field_um = 2000;
    EXPECT_FALSE(has_window(scene)) << "hardly any path meets it";
    scene = lit_specimen(kDense);
    scene.lights.push_back(scene.lights[0]);
    std::get<SheetLight>(scene.lights[1].shape).width_um = 4;
    EXPECT_FALSE(has_window(scene)) << "a light that levels do not tell of";
}

// What is found is put down to the scattering where it was found, wherever paths end.
TEST(PathRecord, TellsWhatWasFoundWhere) {
    const Scene scene = lit_specimen(0.5, 0.005);
    const PathPrepass prepass = prepass_of(scene);
    testing::LinePaths paths(scene);
    prepass.add_to(paths.plan(), 0);
    paths.plan().window = nullptr;  // paths are worth what absorption leaves
    PathRecord record;
    int scattered = 0;
    for (int n = 0; n < 2000; ++n) {
        const std::int64_t before = paths.counts().real_collisions;
        record.clear();
        const double light = paths.record(1, n, record);
        const auto scatterings = static_cast<int>(paths.counts().real_collisions - before);
        EXPECT_EQ(record.flights(), scatterings + (record.has_left() ? 1 : 0));
        EXPECT_EQ(light, paths.radiance(1, n)) << "the same path";
        if (record.scatterings().empty()) continue;
        const PathRecord::Scattering& last = record.scatterings().back();
        EXPECT_EQ(last.flights, scatterings);
        EXPECT_LT(last.worth, std::pow(0.5 / 0.51, 2) + 1e-12) << "scattered twice at least";
        EXPECT_DOUBLE_EQ(last.found, light) << "nothing is found after the last one";
        scattered += record.scatterings().size() > 3 ? 1 : 0;
    }
    EXPECT_GT(scattered, 100);
}

// One path whose light comes in these parts: before its second scattering, just there, and after it.
struct Parts {
    std::uint8_t level = 0;
    double worth = 1, before = 0, own = 0, later = 0;
    int flights = 0;  // after it
};

void add(WeightWindow::Survey& survey, const Parts& parts) {
    PathRecord path;
    path.fly();
    path.scatter(1, 0);  // tells nothing, as no level is known yet
    path.fly();
    path.see_level(parts.level);
    path.scatter(parts.worth, parts.before);
    path.add_own(parts.own);
    for (int i = 0; i < parts.flights; ++i)
        path.fly();
    survey.add(path, parts.before + parts.own + parts.later);
}

TEST(WeightWindow, IsPutWhereItsFormulaSays) {
    WeightWindow::Survey survey;
    for (int n = 0; n < 100000; ++n) {
        add(survey, {10, 0.5, 7, 3, 1, 6});
        add(survey, {200, 1, 2, 3, 8, 4});
        survey.add_pair(11, 15);
    }
    const std::optional<WeightWindow> window = survey.window();
    ASSERT_TRUE(window);
    const double variance = 8;
    const double time = 7;  // flights of all paths, on average
    const auto expected = [&](double later, double flights) {
        return std::sqrt(variance / time * flights) / later / 0.8;
    };
    EXPECT_NEAR(window->lower_bound(10), expected(2, 6), 0.01);
    EXPECT_NEAR(window->lower_bound(15), expected(2, 6), 0.01) << "in the same bin";
    EXPECT_NEAR(window->lower_bound(200), expected(8, 4), 0.01);
}

TEST(WeightWindow, EndsNoPathThatWouldBeWorthFour) {
    WeightWindow::Survey survey;
    for (int n = 0; n < 1000; ++n) {
        add(survey, {0, 1, 0, 0, 1e-6, 10});
        add(survey, {255, 1, 0, 0, 1, 10});
        survey.add_pair(0, 1);
    }
    const std::optional<WeightWindow> window = survey.window();
    ASSERT_TRUE(window);
    EXPECT_GT(window->lower_bound(0), 0.9 * WeightWindow::kMost);
    EXPECT_LE(window->lower_bound(0), WeightWindow::kMost);
}

TEST(WeightWindow, IsNotMadeOfPathsThatTellNothing) {
    WeightWindow::Survey survey;
    EXPECT_FALSE(survey.window());
    for (int n = 0; n < 100; ++n) {
        add(survey, {10, 1, 0, 0, 1e-3, 30});
        survey.add_pair(0, 1);
    }
    EXPECT_FALSE(survey.window()) << "few of them";
    for (int n = 0; n < 1000; ++n)
        add(survey, {10, 1, 0, 0, 1e-3, 30});
    EXPECT_TRUE(survey.window());
    WeightWindow::Survey dark;
    for (int n = 0; n < 1000; ++n) {
        add(dark, {10, 1, 0, 0, 0, 3});
        dark.add_pair(0, 0);
    }
    EXPECT_FALSE(dark.window()) << "without light";
}

}  // namespace
}  // namespace fluovox
