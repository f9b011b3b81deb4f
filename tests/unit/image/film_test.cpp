#include "fluovox/image/film.h"

#include "statistics.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

namespace fluovox {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Film, LayersFollowTheDyes) {
    EXPECT_EQ(film_layers({}, true), (std::vector<std::string>{"total"}));
    EXPECT_EQ(film_layers({"EGFP"}, false), (std::vector<std::string>{"total", "elastic", "fluorescence"}));
    EXPECT_EQ(film_layers({"EGFP", "DAPI"}, true),
              (std::vector<std::string>{"total", "elastic", "fluorescence", "EGFP", "DAPI"}));
}

TEST(Film, MeanAndVarianceEqualTheDirectFormulas) {
    Film film(2, 3, {"total", "elastic"}, 2);
    std::array<testing::RunningMean, 4> expected;
    for (int i = 0; i < 100; ++i) {
        std::array<double, 4> sample{};
        for (std::size_t k = 0; k < 4; ++k) {
            sample[k] = std::exp(std::sin(static_cast<double>(i * (static_cast<int>(k) + 1))));
            expected[k].add(sample[k]);
        }
        EXPECT_TRUE(film.add(4, sample));
    }
    for (int layer = 0; layer < 2; ++layer) {
        for (int channel = 0; channel < 2; ++channel) {
            const auto& direct = expected.at(static_cast<std::size_t>(layer) * 2 + static_cast<std::size_t>(channel));
            EXPECT_NEAR(film.mean(layer, 4, channel), direct.mean, 1e-14);
            const double variance = direct.standard_error() * direct.standard_error();
            EXPECT_NEAR(film.variance_of_mean(layer, 4, channel) / variance, 1, 1e-12);
            EXPECT_EQ(film.mean(layer, 3, channel), 0);
        }
    }
    EXPECT_EQ(film.count(4), 100);
    EXPECT_EQ(film.count(3), 0);
}

TEST(Film, ChannelsOfASampleAreNotIndependent) {
    Film film(1, 1, {"total", "other"}, 2);
    testing::RunningMean together;
    for (int i = 0; i < 50; ++i) {
        const double x = i % 7;
        film.add(0, std::array{x, -x, x, 2 * x});
        together.add(3 * x);
    }
    EXPECT_EQ(film.mean_of_all(0, 0), 0);
    EXPECT_EQ(film.variance_of_mean_of_all(0, 0), 0);
    EXPECT_NEAR(film.mean_of_all(1, 0), together.mean, 1e-12);
    const double error = together.standard_error();
    EXPECT_NEAR(film.variance_of_mean_of_all(1, 0) / (error * error), 1, 1e-12);
}

TEST(Film, OneSampleHasNoVariance) {
    Film film(1, 1, {"total"}, 1);
    film.add(0, std::array{3.0});
    EXPECT_EQ(film.mean(0, 0, 0), 3);
    EXPECT_EQ(film.variance_of_mean(0, 0, 0), 0);
}

TEST(Film, ConstantSamplesHaveNoNegativeVariance) {
    Film film(1, 1, {"total"}, 1);
    for (int i = 0; i < 1000; ++i)
        film.add(0, std::array{0.1});
    EXPECT_GE(film.variance_of_mean(0, 0, 0), 0);
    EXPECT_LT(film.variance_of_mean(0, 0, 0), 1e-16);
}

TEST(Film, ABadSampleIsCountedAndZeroInEveryValue) {
    Film film(1, 1, {"total"}, 2);
    EXPECT_TRUE(film.add(0, std::array{2.0, 4.0}));
    EXPECT_FALSE(film.add(0, std::array{1.0, kNaN}));
    EXPECT_FALSE(film.add(0, std::array{-std::numeric_limits<double>::infinity(), 1.0}));
    EXPECT_EQ(film.nan_count(), 2);
    EXPECT_EQ(film.count(0), 3);
    EXPECT_DOUBLE_EQ(film.mean(0, 0, 0), 2.0 / 3);
    EXPECT_DOUBLE_EQ(film.mean(0, 0, 1), 4.0 / 3);
}

TEST(Film, MergingTwoHalvesGivesTheWhole) {
    Film whole(2, 1, {"total"}, 1);
    Film first = whole;
    Film second = whole;
    for (int i = 0; i < 64; ++i) {
        const std::array sample = {static_cast<double>(i * i % 17)};
        whole.add(1, sample);
        (i < 40 ? first : second).add(1, sample);
    }
    second.add(0, std::array{kNaN});
    second.add_bound_violations(3);
    first.merge(second);
    EXPECT_EQ(first.count(1), 64);
    EXPECT_EQ(first.mean(0, 1, 0), whole.mean(0, 1, 0));
    EXPECT_EQ(first.variance_of_mean(0, 1, 0), whole.variance_of_mean(0, 1, 0));
    EXPECT_EQ(first.nan_count(), 1);
    EXPECT_EQ(first.bound_violations(), 3);
    EXPECT_THROW(first.merge(Film(2, 1, {"total"}, 2)), std::invalid_argument);
}

TEST(Film, SumsMadeElsewhereEqualSamples) {
    Film one_by_one(1, 1, {"total"}, 1);
    Film at_once = one_by_one;
    for (const double x : {1.0, 0.0, 5.0})
        one_by_one.add(0, std::array{x});
    const std::array sums = {6.0};
    const std::array squares = {26.0};
    EXPECT_TRUE(at_once.add_sums(0, {sums, squares, squares, 3}));
    EXPECT_EQ(at_once.mean(0, 0, 0), one_by_one.mean(0, 0, 0));
    EXPECT_EQ(at_once.variance_of_mean(0, 0, 0), one_by_one.variance_of_mean(0, 0, 0));
    EXPECT_EQ(at_once.variance_of_mean_of_all(0, 0), one_by_one.variance_of_mean_of_all(0, 0));
    const std::array bad = {kNaN};
    EXPECT_FALSE(at_once.add_sums(0, {bad, squares, squares, 1}));
    EXPECT_EQ(at_once.nan_count(), 1);
}

/// 10 x 9 pixels: tiles of 8 x 8, 2 x 8, 8 x 1 and 2 x 1.
Film shared_film(int samples, std::uint64_t seed, std::vector<testing::RunningMean>& tile,
                 testing::RunningMean& whole_of_all) {
    Film film(10, 9, {"total", "elastic"}, 2);
    std::mt19937_64 random(seed);
    std::vector<double> values(static_cast<std::size_t>(film.pixels()) * film.values_per_sample());
    for (int sample = 0; sample < samples; ++sample) {
        const double common = std::exponential_distribution<double>(1)(random);
        for (double& value : values)
            value = common + std::exponential_distribution<double>(1)(random);
        film.add_shared(values);
        std::vector<double> sums(film.regions().tiles());
        double all = 0;
        for (std::size_t pixel = 0; pixel < 90; ++pixel) {
            sums[film.regions().tile_of(pixel)] += values[4 * pixel + 3];  // second layer, second channel
            all += values[4 * pixel] + values[4 * pixel + 1];              // first layer
        }
        for (std::size_t i = 0; i < sums.size(); ++i)
            tile[i].add(sums[i] / film.regions().box(i).pixels());
        whole_of_all.add(all / 90);
    }
    return film;
}

TEST(Film, RegionsOfSharedSamplesHaveTheirOwnVariance) {
    std::vector<testing::RunningMean> tile(4);
    testing::RunningMean all;
    Film film = shared_film(50, 1, tile, all);
    film.merge(shared_film(30, 2, tile, all));
    ASSERT_TRUE(film.shares_samples());
    ASSERT_EQ(film.regions().count(), 5U);
    EXPECT_EQ(film.regions().box(3).pixels(), 2);
    for (std::size_t i = 0; i < tile.size(); ++i) {
        const double error = tile[i].standard_error();
        EXPECT_NEAR(film.variance_of_region_mean(1, i, 1) / (error * error), 1, 1e-9) << i;
    }
    const double error = all.standard_error();
    EXPECT_NEAR(film.variance_of_region_mean(0, film.regions().whole(), 2) / (error * error), 1, 1e-9);
}

TEST(Film, RegionsOfIndependentSamplesFollowFromTheirPixels) {
    Film film(2, 1, {"total"}, 1);
    for (const double x : {1.0, 2.0, 4.0}) {
        film.add(0, std::array{x});
        film.add(1, std::array{3 * x});
    }
    EXPECT_FALSE(film.shares_samples());
    EXPECT_NEAR(film.variance_of_region_mean(0, film.regions().whole(), 0), 10 * film.variance_of_mean(0, 0, 0) / 4,
                1e-12);
}

TEST(Film, CountersTakeManyThreads) {
    Film film(4, 1, {"total"}, 1);
    std::vector<std::thread> threads;
    for (int pixel = 0; pixel < 4; ++pixel) {
        threads.emplace_back([&film, pixel] {
            for (int i = 0; i < 10000; ++i) {
                film.add(pixel, std::array{kNaN});
                film.add_bound_violations(1);
            }
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(film.nan_count(), 40000);
    EXPECT_EQ(film.bound_violations(), 40000);
}

TEST(Film, RefusesAnImpossibleShape) {
    EXPECT_THROW(Film(0, 1, {"total"}, 1), std::invalid_argument);
    EXPECT_THROW(Film(1, 1, {"total", "total"}, 1), std::invalid_argument);
    EXPECT_THROW(Film(1, 1, {}, 1), std::invalid_argument);
}

TEST(Film, TellsItsMemoryBeforeItIsMade) {
    FilmSpec spec;
    spec.channels.resize(28);
    EXPECT_EQ(film_bytes(spec, 256, 256, 3), 256.0 * 256 * (3 * (28 * 16 + 8) + 8));
    EXPECT_GT(film_bytes(spec, 2000000000, 2000000000, 3), 1e20);
}

}  // namespace
}  // namespace fluovox
