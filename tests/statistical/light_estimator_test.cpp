// Photons from the lights and paths from the camera give the same images.

#include "fluovox/transport/render.h"
#include "fluovox/volume/sparse_grid_builder.h"

#include "scene_kit.h"
#include "statistics.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <utility>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::flat_dye;
using testing::host;
using testing::laser;

Scene lit_box(Light light, double numerical_aperture) {
    const BoxRegion box{{0, 0, 0}, {100, 100, 100}};
    Scene scene;
    scene.media = {host(box, 0.02, 0.002, 0.6), dye_in(SphereRegion{{50, 50, 50}, 40}, 0, 1)};
    scene.dyes = {flat_dye(0.01, 400, 530, 510, 610, 0.8)};
    scene.lights = {std::move(light)};
    SceneDescription& description = scene.description;
    description.camera = testing::one_pixel({50, 50, 200}, {50, 50, 60}, {0, 1, 0}, 90, numerical_aperture);
    description.camera.width = description.camera.height = 6;
    description.film = testing::spectrometer(470, 630, 4);
    description.render.seed = 3;
    return scene;
}

Light thick_sheet() {
    SheetLight sheet;
    sheet.position = sheet.waist = {-10, 50, 50};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 80;
    sheet.thickness_um = 40;
    return laser(sheet, 488, 1e-3);
}

Light lamp() {
    RectangleLight lamp;
    lamp.center = {50, 50, -20};
    lamp.normal = {0, 0, 1};
    lamp.up = {0, 1, 0};
    lamp.width_um = lamp.height_um = 60;
    return laser(lamp, 488, 1e-3);
}

Film image(Scene scene, const char* estimator, int samples) {
    scene.description.render.estimator = estimator;
    scene.description.render.samples = samples;
    NoProgress progress;
    return render(scene, progress).film;
}

/// Chi-squared of the difference of two images over every pixel, channel and layer that both know well, in standard
/// deviations of it; `factor` multiplies the first.
double disagreement(const Film& a, const Film& b, double factor = 1) {
    double squares = 0;
    int count = 0;
    for (int layer = 1; layer < static_cast<int>(a.layers().size()); ++layer) {
        for (int pixel = 0; pixel < a.pixels(); ++pixel) {
            for (int channel = 0; channel < a.channels(); ++channel) {
                const double mean = a.mean(layer, pixel, channel);
                const double variance =
                    a.variance_of_mean(layer, pixel, channel) + b.variance_of_mean(layer, pixel, channel);
                if (!(mean > 0) || variance > 0.01 * mean * mean) continue;
                const double difference = factor * mean - b.mean(layer, pixel, channel);
                squares += difference * difference / variance;
                ++count;
            }
        }
    }
    EXPECT_GT(count, 50);
    return (squares - count) / std::sqrt(2.0 * count);
}

struct View {
    const char* name;
    Light light;
    double numerical_aperture;
    Camera::Kind kind;
};

std::vector<View> views() {
    return {{"sheet, sharp", thick_sheet(), 0, Camera::Kind::Telecentric},
            {"sheet, aperture", thick_sheet(), 0.4, Camera::Kind::Telecentric},
            {"lamp in view", lamp(), 0.2, Camera::Kind::Telecentric},
            {"perspective", thick_sheet(), 0.1, Camera::Kind::Perspective}};
}

TEST(LightEstimator, AgreesWithPathsFromTheCameraInEveryPixel) {
    for (const View& view : views()) {
        SCOPED_TRACE(view.name);
        Scene scene = lit_box(view.light, view.numerical_aperture);
        scene.description.camera.kind = view.kind;
        scene.description.camera.fov_rad = 0.6;
        const Film light = image(scene, "light", 6000);
        const Film path = image(scene, "path", 1500);
        EXPECT_LT(std::abs(disagreement(light, path)), 5);
        EXPECT_GT(std::abs(disagreement(light, path, 1.1)), 5) << "an image 10 % too bright is found out";
    }
}

TEST(LightEstimator, SameSeedGivesTheSameFilmForAnyNumberOfThreads) {
    const auto with_threads = [](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return image(lit_box(thick_sheet(), 0.3), "light", 200);
    };
    const Film one = with_threads(1);
    const Film three = with_threads(3);
    for (int pixel = 0; pixel < one.pixels(); ++pixel) {
        EXPECT_EQ(one.mean(0, pixel, 1), three.mean(0, pixel, 1));
        EXPECT_EQ(one.variance_of_mean(0, pixel, 1), three.variance_of_mean(0, pixel, 1));
    }
}

TEST(LightEstimator, ShowsCollimatedLightThatShinesIntoTheCamera) {
    Scene scene = lit_box(thick_sheet(), 0.2);
    scene.media.clear();
    scene.dyes.clear();
    BeamLight beam;
    beam.position = beam.waist = {50, 50, -10};
    beam.direction = {0, 0, 1};
    beam.radius_um = 5;
    beam.profile = BeamProfile::Box;
    scene.lights = {laser(beam, 488, 1e-3)};
    const Film film = image(scene, "light", 100);
    double sum = 0;
    for (int pixel = 0; pixel < film.pixels(); ++pixel)
        sum += film.mean(0, pixel, 0);
    // Value x bin width x pi NA^2 x object pixel area is the power collected.
    const double collected = sum * 40 * 3.14159265358979 * 0.04 * 15e-6 * 15e-6;
    EXPECT_NEAR(collected, 1e-3, 1e-9);
}

// Out of focus a photon reaches many pixels.
TEST(LightEstimator, KnowsTheErrorOfItsWholeImage) {
    constexpr int kRuns = 150;
    for (const char* estimator : {"light", "cached"}) {
        testing::RunningMean mean;
        double claimed = 0;
        double apart = 0;
        for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
            Scene scene = lit_box(thick_sheet(), 0.5);
            scene.description.camera.focus_um = 20;
            scene.description.camera.width = scene.description.camera.height = 16;
            scene.description.render.photons = 320;
            scene.description.render.cache_voxel_um = 20;
            scene.description.render.seed = seed;
            const Film film = image(std::move(scene), estimator, 4);
            const int layer = film.layer(kFluorescenceLayer);
            double sum = 0;
            for (int pixel = 0; pixel < film.pixels(); ++pixel) {
                sum += film.mean_of_all(layer, pixel) / film.pixels();
                apart += film.variance_of_mean_of_all(layer, pixel) / film.pixels() / film.pixels() / kRuns;
            }
            mean.add(sum);
            claimed += film.variance_of_region_mean(layer, film.regions().whole(), film.channels()) / kRuns;
        }
        const double true_variance = mean.standard_error() * mean.standard_error() * kRuns;
        const double five_sigma = 5 * std::sqrt(2.0 / (kRuns - 1));
        EXPECT_NEAR(true_variance / claimed, 1, five_sigma) << estimator;
        EXPECT_GT(true_variance / apart, 1 + five_sigma) << estimator << ": the twin, as if pixels were independent";
    }
}

TEST(LightEstimator, ADyeInTheBackgroundOfAGridIsLikeOneEverywhere) {
    Scene scene = lit_box(lamp(), 0.2);
    scene.media = {dye_in(SparseGridBuilder(2).finish({}, 0), 0)};
    const Film in_grid = image(scene, "light", 20000);
    scene.media = {dye_in(Everywhere{}, 0, 2)};
    EXPECT_LT(std::abs(disagreement(in_grid, image(scene, "light", 20000))), 5);
    EXPECT_GT(std::abs(disagreement(in_grid, image(scene, "light", 20000), 1.05)), 5) << "the twin";
    // However thin: photons need not stop at every voxel of a way without end.
    scene.media = {dye_in(SparseGridBuilder(1e-12F).finish({}, 0), 0)};
    EXPECT_EQ(image(scene, "light", 1).nan_count(), 0);
}

TEST(LightEstimator, NamesFluenceWhereASurfaceRefracts) {
    Scene scene = lit_box(thick_sheet(), 0.3);
    scene.description.media.resize(2);
    scene.description.media[0].refractive_index = 1.33;
    EXPECT_THROW(image(scene, "light", 1), SceneError);
    EXPECT_THROW(image(scene, "path", 1), SceneError);
}

}  // namespace
}  // namespace fluovox
