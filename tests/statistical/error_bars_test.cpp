// The standard errors that come with every number are those by which it scatters from seed to seed.

#include "fluovox/transport/fluence.h"
#include "fluovox/transport/render.h"

#include "scene_kit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::flat_dye;
using testing::host;

/// Numbers of one run, each with its standard error.
using Numbers = std::vector<Estimate>;

/// Of numbers over runs with seeds of their own: the variance between runs over the variance that they tell, all
/// numbers together. One where the error bars are right, whether the numbers of a run are independent or not; its own
/// standard error is that of a ratio of means over runs.
class Honesty {
public:
    explicit Honesty(const std::vector<Numbers>& runs) : apart_(runs.size()), told_(runs.size()) {
        for (std::size_t number = 0; number < runs[0].size(); ++number)
            add(runs, number);
        const double apart = std::accumulate(apart_.begin(), apart_.end(), 0.0);
        const double told = std::accumulate(told_.begin(), told_.end(), 0.0);
        ratio_ = apart / told;
        double squares = 0;
        for (std::size_t i = 0; i < runs.size(); ++i)
            squares += std::pow(apart_[i] - ratio_ * told_[i], 2);
        const auto n = static_cast<double>(runs.size());
        standard_error_ = std::sqrt(squares * n / (n - 1)) / told;
    }
    /// Standard errors that the ratio is from one, were every error bar `factor` times as long.
    double z(double factor = 1) const { return (ratio_ - factor * factor) / standard_error_; }
    std::string text() const {
        return fmt::format("variance over told variance: {:.4f} +- {:.4f}", ratio_, standard_error_);
    }

private:
    void add(const std::vector<Numbers>& runs, std::size_t number) {
        const auto n = static_cast<double>(runs.size());
        double mean = 0;
        double told = 0;
        for (const Numbers& run : runs) {
            mean += run[number].value / n;
            told += std::pow(run[number].standard_error, 2) / n;
        }
        if (!(told > 0)) return;
        for (std::size_t i = 0; i < runs.size(); ++i) {
            apart_[i] += std::pow(runs[i][number].value - mean, 2) / told * n / (n - 1);
            told_[i] += std::pow(runs[i][number].standard_error, 2) / told;
        }
    }

    std::vector<double> apart_, told_;  // of each run
    double ratio_ = 0, standard_error_ = 0;
};

void expect_right(const std::vector<Numbers>& runs) {
    const Honesty bars(runs);
    SCOPED_TRACE(bars.text());
    EXPECT_LT(std::abs(bars.z()), 5);
    EXPECT_LT(bars.z(1.1), -5) << "error bars 10 % too long are found out";
    EXPECT_GT(bars.z(0.9), 5) << "error bars 10 % too short are found out";
}

/// A milky cube with a ball of dye under a sheet of light, seen in few pixels and two bins.
Scene milky_cube(const char* estimator) {
    SheetLight sheet;
    sheet.position = sheet.waist = {-10, 50, 50};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 80;
    sheet.thickness_um = 40;
    Scene scene;
    scene.media = {host(BoxRegion{{0, 0, 0}, {100, 100, 100}}, 0.02, 0.002, 0.6),
                   dye_in(SphereRegion{{50, 50, 50}, 40}, 0, 1)};
    scene.dyes = {flat_dye(0.01, 400, 530, 510, 610, 0.8)};
    scene.lights = {testing::laser(sheet, 488, 1e-3)};
    SceneDescription& description = scene.description;
    description.camera = testing::one_pixel({50, 50, 200}, {50, 50, 60}, {0, 1, 0}, 90, 0.2);
    description.camera.width = description.camera.height = 3;
    description.film = testing::spectrometer(470, 630, 2);
    description.render.estimator = estimator;
    description.render.samples = 16;
    description.render.photons = 400;  // of the cache
    description.render.cache_voxel_um = 10;
    return scene;
}

/// Every pixel, each bin and all of them added up.
Numbers of_pixels(const Film& film) {
    Numbers numbers;
    for (int layer = 1; layer < static_cast<int>(film.layers().size()); ++layer) {
        for (int pixel = 0; pixel < film.pixels(); ++pixel) {
            for (int channel = 0; channel < film.channels(); ++channel)
                numbers.push_back(
                    {film.mean(layer, pixel, channel), std::sqrt(film.variance_of_mean(layer, pixel, channel))});
            numbers.push_back({film.mean_of_all(layer, pixel), std::sqrt(film.variance_of_mean_of_all(layer, pixel))});
        }
    }
    return numbers;
}

/// The mean of the whole picture in each layer, all bins added up.
Numbers of_whole(const Film& film) {
    Numbers numbers;
    for (int layer = 1; layer < static_cast<int>(film.layers().size()); ++layer) {
        double sum = 0;
        for (int pixel = 0; pixel < film.pixels(); ++pixel)
            sum += film.mean_of_all(layer, pixel);
        const double variance = film.variance_of_region_mean(layer, film.regions().whole(), film.channels());
        numbers.push_back({sum / film.pixels(), std::sqrt(variance)});
    }
    return numbers;
}

void expect_right_bars(const char* estimator, int runs) {
    Scene scene = milky_cube(estimator);
    std::vector<Numbers> pixels;
    std::vector<Numbers> whole;
    for (int run = 1; run <= runs; ++run) {
        scene.description.render.seed = static_cast<std::uint64_t>(run);
        NoProgress progress;
        const Film film = render(scene, progress).film;
        pixels.push_back(of_pixels(film));
        whole.push_back(of_whole(film));
    }
    {
        SCOPED_TRACE("pixels");
        expect_right(pixels);
    }
    SCOPED_TRACE("whole picture");
    expect_right(whole);
}

TEST(ErrorBars, OfPathsAreTheirSpreadOverSeeds) {
    expect_right_bars("path", 1600);
}

TEST(ErrorBars, OfPhotonsFromTheLightsAreTheirSpreadOverSeeds) {
    expect_right_bars("light", 1600);
}

TEST(ErrorBars, OfTheCacheAreTheirSpreadOverSeeds) {
    expect_right_bars("cached", 1600);
}

Numbers of_budget(const FluenceResult& result) {
    Numbers numbers = {result.mean_path_um, result.watts.emission.launched};
    for (const LightBudget& budget : {result.share.excitation, result.share.emission}) {
        numbers.insert(numbers.end(), budget.absorbed.begin(), budget.absorbed.end());
        numbers.insert(numbers.end(), budget.not_specular.begin(), budget.not_specular.end());
    }
    return numbers;
}

/// Photons in all, and batches: at most 2000 of them; of 500 with a relative error that is never reached.
struct Batches {
    std::int64_t photons = 0;
    std::optional<double> relative_error;
    int runs = 0;
};

TEST(ErrorBars, OfFluenceAreItsSpreadOverSeedsHoweverPhotonsAreBatched) {
    const Scene scene = milky_cube("");
    for (const Batches& batches : {Batches{400, {}, 1200}, Batches{4001, {}, 400}, Batches{1300, 1e-9, 800}}) {
        SCOPED_TRACE(batches.photons);
        std::vector<Numbers> runs;
        for (int run = 0; run < batches.runs; ++run) {
            FluenceSettings settings;
            settings.photons = batches.photons;
            settings.relative_error = batches.relative_error;
            settings.seed = static_cast<std::uint64_t>(1000 * batches.photons + run);  // the same photons in no two
            NoProgress progress;
            runs.push_back(of_budget(trace_fluence(scene, settings, progress)));
        }
        expect_right(runs);
    }
}

TEST(ErrorBars, ASmallLastBatchCountsByItsPhotons) {
    const Scene scene = milky_cube("");
    FluenceSettings settings;
    settings.photons = 1001;
    NoProgress progress;
    const Numbers one_by_one = of_budget(trace_fluence(scene, settings, progress));
    settings.relative_error = 1e-9;  // two batches of 500 and one photon
    const Numbers batched = of_budget(trace_fluence(scene, settings, progress));
    for (std::size_t i = 0; i < batched.size(); ++i)
        EXPECT_NEAR(batched[i].value, one_by_one[i].value, 1e-9 * one_by_one[i].value) << i;
}

}  // namespace
}  // namespace fluovox
