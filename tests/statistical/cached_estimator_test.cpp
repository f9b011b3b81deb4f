// Excitation kept by voxel gives the image that the unbiased estimators give.

#include "fluovox/transport/excitation_cache.h"
#include "fluovox/transport/fluence.h"
#include "fluovox/transport/photon_source.h"
#include "fluovox/transport/photon_space.h"
#include "fluovox/transport/render.h"

#include "scene_kit.h"
#include "statistics.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::flat_dye;
using testing::host;
using testing::laser;
using testing::RunningMean;

constexpr int kFluorescence = 2;

Light sheet_of(double thickness_um) {
    SheetLight sheet;
    sheet.position = sheet.waist = {-10, 50, 50};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 80;
    sheet.thickness_um = thickness_um;
    return laser(sheet, 488, 1e-3);
}

/// Concentrations that change from voxel to voxel, 2 um apart, in a ball.
SparseGrid blobs() {
    Affine world_from_index;
    for (int axis = 0; axis < 3; ++axis)
        world_from_index.rows[static_cast<std::size_t>(axis)] =
            2.0 * world_from_index.rows[static_cast<std::size_t>(axis)];
    return SparseGrid::from_function({5, 5, 5}, {45, 45, 45}, world_from_index, [](Voxel v) {
        const double distance = std::hypot(v.x - 25, v.y - 25, v.z - 25);
        return distance < 18 ? 1 + 0.9 * std::sin(v.x) * std::cos(2 * v.y) : 0.0;
    });
}

Scene in_tissue(SceneMedium dye, Light light) {
    Scene scene;
    scene.media = {host(BoxRegion{{0, 0, 0}, {100, 100, 100}}, 0.04, 0.001, 0.8), std::move(dye)};
    scene.dyes = {flat_dye(0.01, 400, 500, 520, 600, 0.8)};
    scene.lights = {std::move(light)};
    SceneDescription& description = scene.description;
    description.camera = testing::one_pixel({50, 50, 200}, {50, 50, 60}, {0, 1, 0}, 90, 0.2);
    description.camera.width = description.camera.height = 4;
    description.film = testing::spectrometer(510, 610, 2);
    description.render.photons = 20000;
    return scene;
}

Film image(Scene scene, const char* estimator, int samples, std::uint64_t seed = 1) {
    scene.description.render.estimator = estimator;
    scene.description.render.samples = samples;
    scene.description.render.seed = seed;
    NoProgress progress;
    return render(scene, progress).film;
}

double total(const Film& film) {
    double sum = 0;
    for (int pixel = 0; pixel < film.pixels(); ++pixel)
        sum += film.mean_of_all(kFluorescence, pixel);
    return sum;
}

/// Totals of two estimators, from renders with seeds of their own: whatever the pixels of one render share is in the
/// spread.
struct Totals {
    RunningMean cached, other;

    Totals(const Scene& scene, const char* estimator, int samples) {
        for (std::uint64_t seed = 1; seed <= 8; ++seed) {
            cached.add(total(image(scene, "cached", 600, seed)));
            other.add(total(image(scene, estimator, samples, 100 + seed)));
        }
        EXPECT_LT(standard_error(1), 0.04 * other.mean) << "too noisy to tell anything";
    }
    double standard_error(double factor) const {
        return std::hypot(factor * cached.standard_error(), other.standard_error());
    }
    /// Standard errors that the cached one, made wrong by `factor`, is above the other.
    double z(double factor = 1) const { return (factor * cached.mean - other.mean) / standard_error(factor); }
};

double z_of_totals(const Scene& scene, const char* estimator, int samples) {
    return Totals(scene, estimator, samples).z();
}

TEST(CachedEstimator, HasTheTotalsOfTheEstimatorsWithoutACache) {
    const Scene on_grid = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    EXPECT_LT(std::abs(z_of_totals(on_grid, "path", 500)), 5);
    const Totals by_light(on_grid, "light", 1000);
    EXPECT_LT(std::abs(by_light.z()), 5);
    EXPECT_GT(by_light.z(1.08), 5) << "8 % too much is found out";

    const Scene in_ball = in_tissue(dye_in(SphereRegion{{50, 50, 50}, 40}, 0, 1), sheet_of(20));
    EXPECT_LT(std::abs(z_of_totals(in_ball, "light", 1000)), 5);
}

/// Standard errors between two films in the pixel where they differ most, the first one made wrong by `factor`.
double worst_pixel(const Film& film, const Film& other, double factor) {
    double worst = 0;
    for (int pixel = 0; pixel < film.pixels(); ++pixel) {
        const double apart = factor * film.mean_of_all(kFluorescence, pixel) - other.mean_of_all(kFluorescence, pixel);
        const double variance = factor * factor * film.variance_of_mean_of_all(kFluorescence, pixel) +
                                other.variance_of_mean_of_all(kFluorescence, pixel);
        worst = std::max(worst, std::abs(apart) / std::sqrt(variance));
    }
    return worst;
}

TEST(CachedEstimator, HasThePixelsOfTheEstimatorWithoutACache) {
    const Scene scene = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    const Film cached = image(scene, "cached", 4000, 1);
    const Film light = image(scene, "light", 30000, 2);
    EXPECT_LT(worst_pixel(cached, light, 1), 5);
    EXPECT_GT(worst_pixel(cached, light, 1.2), 5) << "20 % too much is found out";
}

TEST(CachedEstimator, HasTheTotalOfPlainPathsThatScoreAtCollisions) {
    Scene scene = in_tissue(dye_in(SphereRegion{{50, 50, 50}, 40}, 0, 1), sheet_of(20));
    const Totals plain(scene, "collision", 8000);
    EXPECT_LT(std::abs(plain.z()), 5);
    EXPECT_GT(plain.z(1.2), 5) << "20 % too much is found out";
    scene.media[1].region = SphereRegion{{50, 50, 50}, 60};
    EXPECT_THROW(image(scene, "collision", 1), SceneError) << "some dye is beside the tissue";
}

/// Of the photons of a pencil of light, how many the dye of a grid absorbs, by the cache.
RunningMean cached_absorption(Scene scene, int renders, std::int64_t photons) {
    RunningMean absorbed;
    for (int render = 1; render <= renders; ++render) {
        scene.description.render.seed = static_cast<std::uint64_t>(render);
        ExcitationCache cache(scene);
        NoProgress progress;
        cache.fill(photons, 0, progress);
        double sum = 0;
        for (std::size_t brick = 0; brick < cache.lattice(1).bricks.size(); ++brick) {
            for (int in_brick = 0; in_brick < 512; ++in_brick)
                sum += cache.absorbed_per_s(1, brick, in_brick);
        }
        absorbed.add(sum / PhotonSource(scene, PhotonSpace(scene)).photons_per_s());
    }
    return absorbed;
}

// Light that fades within a voxel of dye that is not even.
TEST(CachedEstimator, KeepsAsManyPhotonsAsAreAbsorbed) {
    Affine world_from_index;
    for (Vec3& row : world_from_index.rows)
        row = 10.0 * row;
    SparseGrid dye = SparseGrid::from_function({3, 3, 3}, {8, 8, 8}, world_from_index,
                                               [](Voxel v) { return (v.x + v.y + v.z) % 2 == 0 ? 3.0 : 0.5; });
    BeamLight pencil;
    pencil.position = pencil.waist = {-10, 50, 50};
    pencil.direction = {1, 0, 0};
    Scene scene = in_tissue(dye_in(std::move(dye), 0), laser(pencil, 488, 1e-3));
    scene.media[0].scattering = 0.1;
    const RunningMean cached = cached_absorption(scene, 20, 20000);
    FluenceSettings settings;
    settings.photons = 400000;
    NoProgress progress;
    const Estimate absorbed = trace_fluence(scene, settings, progress).share.excitation.absorbed[1];
    const double error = std::hypot(cached.standard_error(), absorbed.standard_error);
    EXPECT_LT(std::abs(cached.mean - absorbed.value), 5 * error);
    EXPECT_GT(1.02 * cached.mean - absorbed.value, 5 * error) << "2 % too much is found out";
}

TEST(CachedEstimator, KeepsTheGlowOfOtherDyes) {
    Scene scene = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    scene.dyes.push_back(flat_dye(0.02, 515, 605, 650, 700, 0.5));
    scene.media.push_back(dye_in(BoxRegion{{0, 0, 0}, {100, 100, 60}}, 1, 1));
    scene.description.film = testing::spectrometer(640, 710, 2);  // sees the second dye only
    scene.description.render.fluorescence_orders = 2;
    EXPECT_LT(std::abs(z_of_totals(scene, "light", 2000)), 5);
    scene.description.render.fluorescence_orders = 1;
    EXPECT_EQ(total(image(scene, "cached", 4)), 0) << "one conversion does not get there";
}

TEST(CachedEstimator, CachesTheLightThatNoPathFinds) {
    const SceneMedium dye = dye_in(blobs(), 0);
    BeamLight pencil;
    pencil.position = pencil.waist = {-10, 51, 50};
    pencil.direction = {1, 0, 0};
    EXPECT_LT(std::abs(z_of_totals(in_tissue(dye, laser(pencil, 488, 1e-3)), "light", 1000)), 5);

    Light surround = laser(UniformLight{1e3}, 488, 0);
    EXPECT_LT(std::abs(z_of_totals(in_tissue(dye, surround), "path", 500)), 5);
}

TEST(CachedEstimator, ItsErrorBarsTellTheNoiseThatPixelsShare) {
    const Scene scene = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    RunningMean values;
    double told = 0;
    constexpr int kRenders = 90;
    for (std::uint64_t seed = 1; seed <= kRenders; ++seed) {
        Scene few = scene;
        few.description.render.photons = 3200;  // the cache is the noisiest part
        const Film film = image(few, "cached", 320, seed);
        values.add(film.mean_of_all(kFluorescence, 5));
        told += film.variance_of_mean_of_all(kFluorescence, 5) / kRenders;
    }
    // A variance from 90 renders is known to 15 %; one bar that missed the cache's noise would be far off.
    const double spread = kRenders * std::pow(values.standard_error(), 2);
    EXPECT_GT(told / spread, 0.4);
    EXPECT_LT(told / spread, 2.5);
}

TEST(CachedEstimator, SameSeedGivesTheSameFilmForAnyNumberOfThreads) {
    const auto with_threads = [](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return image(in_tissue(dye_in(blobs(), 0), sheet_of(20)), "cached", 8);
    };
    const Film one = with_threads(1);
    const Film three = with_threads(3);
    for (int pixel = 0; pixel < one.pixels(); ++pixel) {
        EXPECT_EQ(one.mean(0, pixel, 1), three.mean(0, pixel, 1));
        EXPECT_EQ(one.variance_of_mean(0, pixel, 1), three.variance_of_mean(0, pixel, 1));
    }
}

/// Relative difference of the total of a cached render to that of another scene and estimator, and its standard error.
std::pair<double, double> difference(const Scene& scene, double factor, const Scene& other, const char* estimator,
                                     int samples = 200) {
    RunningMean first;
    RunningMean second;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        first.add(factor * total(image(scene, "cached", samples, seed)));
        second.add(total(image(other, estimator, samples, 100 + seed)));
    }
    return {first.mean / second.mean - 1, std::hypot(first.standard_error(), second.standard_error()) / second.mean};
}

// Light that comes in at right angles fills a clear plate as if it had no surfaces: what they reflect comes back from
// the other side. The same holds for the way out, but for the square of the index that radiance loses.
TEST(CachedEstimator, APlateOfGlassDimsItsDyeByTheSquareOfItsIndex) {
    constexpr double kIndex = 1.5;
    const BoxRegion plate{{-200, -200, 0}, {200, 200, 20}};
    SheetLight light;
    light.position = light.waist = {0, 0, -10};
    light.direction = {0, 0, 1};
    light.normal = {0, 1, 0};
    light.width_um = light.thickness_um = 300;
    light.profile = BeamProfile::Box;
    Scene clear = in_tissue(dye_in(plate, 0, 1), laser(light, 488, 1e-3));
    clear.media[0] = host(plate, 0, 0);
    clear.dyes[0] = flat_dye(1e-5, 400, 500, 520, 600, 0.8);
    clear.description.camera = testing::one_pixel({0, 0, 200}, {0, 0, 10}, {0, 1, 0}, 100);
    clear.description.render.cache_voxel_um = 20;
    clear.description.render.photons = 100000;
    Scene glass = clear;
    glass.media[0].refractive_index = kIndex;
    const auto [right, error] = difference(glass, kIndex * kIndex, clear, "path");
    EXPECT_LT(error, 0.03);
    EXPECT_LT(std::abs(right), 5 * error);
    const auto [wrong, its_error] = difference(glass, kIndex, clear, "path");
    EXPECT_GT(std::abs(wrong), 5 * its_error) << "losing one power of the index is found out";
}

// Two ways to the camera: with an index next to one the cache is gathered, without one it sends out photons.
TEST(CachedEstimator, GatheringAndSendingOutAgree) {
    const Scene plain = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    Scene nearly = plain;
    nearly.media[0].refractive_index = 1 + 1e-9;
    const auto [apart, error] = difference(nearly, 1, plain, "cached", 300);
    EXPECT_LT(error, 0.02);
    EXPECT_LT(std::abs(apart), 5 * error);
}

TEST(CachedEstimator, RefusesToShowUnconvertedLightThroughARefractingSurface) {
    Scene scene = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    scene.media[0].refractive_index = 1.33;
    EXPECT_EQ(chosen_estimator(scene).name, "cached");
    scene.description.lights.resize(1);
    scene.description.lights[0].light = scene.lights[0];
    EXPECT_GT(total(image(scene, "cached", 1)), 0);
    scene.description.film = testing::spectrometer(480, 500, 1);
    EXPECT_THROW(image(scene, "cached", 1), SceneError);
}

TEST(CachedEstimator, SaysWhatItCannotKeepApart) {
    Scene scene = in_tissue(dye_in(blobs(), 0), sheet_of(20));
    scene.description.render.max_scatterings = 2;
    EXPECT_THROW(image(scene, "cached", 1), SceneError);
    scene.description.render.max_scatterings = 1;
    EXPECT_LT(std::abs(z_of_totals(scene, "path", 500)), 5);
    Scene endless = in_tissue(dye_in(Region{Everywhere{}}, 0, 1), sheet_of(20));
    EXPECT_THROW(image(endless, "cached", 1), SceneError);
}

}  // namespace
}  // namespace fluovox
