// The same seed gives the same film, to the last bit, whoever does the work; and all estimators mean the same film.

#include "path_kit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::host;

// Everything at once: grids, two dyes, cascades, coloured scattering, a laser, a lamp, a filter, an aperture.
Scene everything() {
    Affine map;
    map.rows = {Vec3{2, 0.5, 0}, Vec3{-0.5, 2, 0}, Vec3{0, 0.1, 2}};
    const auto noise = [](Voxel v) { return 2.0 + ((v.x * 7 + v.y * 3 + v.z) & 3); };
    Scene scene;
    scene.dyes = {testing::flat_dye(0.002, 440, 510, 500, 600, 0.7), testing::flat_dye(0.003, 500, 560, 550, 640, 0.9)};
    scene.dyes[0].name = "green";
    scene.dyes[1].name = "red";
    scene.media = {dye_in(SparseGrid::from_function({-10, -12, -9}, {12, 12, 12}, map, noise), 0),
                   dye_in(SphereRegion{{10, 0, 0}, 20}, 1, 4),
                   host(BoxRegion{{-40, -40, -40}, {40, 40, 40}}, 0, 0.001, 0.8),
                   host(SparseGrid::from_function({-9, -9, -9}, {9, 9, 9}, map, noise), 0.002, 0.0005, 0.2)};
    scene.media[2].scattering = PowerLaw{500, 0.02, -1.6};
    SheetLight sheet;
    sheet.position = sheet.waist = {-80, 0, 0};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 60;
    sheet.thickness_um = 10;
    RectangleLight lamp;
    lamp.center = {0, 100, 0};
    lamp.normal = {0, -1, 0};
    lamp.up = {0, 0, 1};
    lamp.width_um = lamp.height_um = 40;
    scene.lights = {testing::laser(sheet, 488, 1e-3), testing::laser(lamp, 0, 1e-3)};
    scene.lights[1].spectrum.lines.clear();
    scene.lights[1].spectrum.energy_per_nm = Spectrum::box(430, 620, 1.0 / 190);
    Camera& camera = scene.description.camera;
    camera = testing::one_pixel({0, 0, 150}, {0, 0, 0}, {0, 1, 0}, 60, 0.2);
    camera.width = 9;
    camera.height = 7;
    scene.description.film = testing::spectrometer(480, 640, 8);
    scene.description.film.per_dye = true;
    scene.description.render.samples = 24;
    scene.description.render.fluorescence_orders = 2;
    scene.description.render.filter = FilterDescription{false, {{570, 580}}};
    return scene;
}

struct Result {
    std::vector<double> numbers;
    std::int64_t violations = 0, bad = 0;
};

Result film_with(const Scene& scene, int threads) {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] {
        NoProgress quiet;
        const RenderResult result = render(scene, quiet);
        Result out;
        for (int layer = 0; layer < static_cast<int>(result.film.layers().size()); ++layer) {
            for (int pixel = 0; pixel < result.film.pixels(); ++pixel) {
                for (int c = 0; c < result.film.channels(); ++c) {
                    out.numbers.push_back(result.film.mean(layer, pixel, c));
                    out.numbers.push_back(result.film.variance_of_mean(layer, pixel, c));
                }
            }
        }
        out.numbers.push_back(static_cast<double>(result.counts.real_collisions));
        out.numbers.push_back(static_cast<double>(result.counts.null_collisions));
        out.numbers.push_back(static_cast<double>(result.counts.grid_lookups));
        out.violations = result.counts.bound_violations;
        out.bad = result.film.nan_count();
        return out;
    });
}

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(Repeatable, TheSameSeedGivesTheSameBytesForAnyNumberOfThreads) {
    Scene scene = everything();
    const Result one = film_with(scene, 1);
    double lit = 0;
    for (const double number : one.numbers)
        lit += number;
    EXPECT_GT(lit, 0);
    EXPECT_EQ(one.violations, 0);
    EXPECT_EQ(one.bad, 0);
    EXPECT_TRUE(same_bytes(one.numbers, film_with(scene, 1).numbers));
    EXPECT_TRUE(same_bytes(one.numbers, film_with(scene, 2).numbers));
    EXPECT_TRUE(same_bytes(one.numbers, film_with(scene, 4).numbers));
    scene.description.render.seed = 2;
    EXPECT_FALSE(same_bytes(one.numbers, film_with(scene, 2).numbers));
}

// Means over the picture, for each layer and channel, of many seeds.
std::vector<testing::RunningMean> means(Scene scene, const char* estimator, int samples) {
    scene.description.render.estimator = estimator;
    scene.description.render.samples = samples;
    std::vector<testing::RunningMean> all;
    NoProgress quiet;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        scene.description.render.seed = seed;
        const Film film = render(scene, quiet).film;
        const auto layers = static_cast<int>(film.layers().size());
        all.resize(film.values_per_sample());
        auto value = all.begin();
        for (int layer = 0; layer < layers; ++layer) {
            for (int c = 0; c < film.channels(); ++c) {
                double sum = 0;
                for (int pixel = 0; pixel < film.pixels(); ++pixel)
                    sum += film.mean(layer, pixel, c);
                (value++)->add(sum);
            }
        }
    }
    return all;
}

TEST(Estimators, FromTheCameraAndFromTheLightsAgreeOnEverythingAtOnce) {
    Scene scene = everything();
    scene.media.push_back(host(BoxRegion{{-15, -40, -40}, {-5, 40, 40}}, 0.01, 0.02));  // replaces the tissue there
    scene.media[2].cut_by = {4};
    const auto path = means(scene, "path", 120);
    const auto light = means(scene, "light", 400);
    ASSERT_EQ(path.size(), light.size());
    int compared = 0;
    int twins = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        const double error = std::hypot(path[i].standard_error(), light[i].standard_error());
        // 24 seeds: the spread itself is uncertain, six standard errors of it are the five of a known one.
        EXPECT_LE(std::abs(path[i].mean - light[i].mean), 6 * error) << "value " << i;
        if (!(path[i].mean > 0)) continue;
        ++compared;
        if (std::abs(1.25 * path[i].mean - light[i].mean) > 6 * error) ++twins;
    }
    EXPECT_GE(compared, 30);
    EXPECT_GT(twins, compared / 2);
}

}  // namespace
}  // namespace fluovox
