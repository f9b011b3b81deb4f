#include "fluovox/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>

namespace fluovox {
namespace {

constexpr int kDraws = 4'000'000;

// Chi-squared of how many of the numbers fall into each of 100 intervals that should be met equally often, in standard
// deviations from its mean.
double unevenness(double rate, const std::function<double()>& draw) {
    constexpr std::size_t kIntervals = 100;
    std::array<int, kIntervals> counts{};
    for (int i = 0; i < kDraws; ++i) {
        const double share = -std::expm1(-rate * draw());
        ++counts.at(std::min(static_cast<std::size_t>(share * kIntervals), kIntervals - 1));
    }
    constexpr double kExpected = static_cast<double>(kDraws) / kIntervals;
    double chi_squared = 0;
    for (const int count : counts)
        chi_squared += (count - kExpected) * (count - kExpected) / kExpected;
    return (chi_squared - (kIntervals - 1)) / std::sqrt(2.0 * (kIntervals - 1));
}

TEST(Rng, ExponentialNumbersFollowTheirLaw) {
    Rng rng(1, 2, 3);
    const auto draw = [&] { return rng.exponential(); };
    EXPECT_LT(std::abs(unevenness(1, draw)), 5);
    EXPECT_GT(std::abs(unevenness(1.01, draw)), 5) << "a rate off by 1 % is found out";
}

// The last of 100 equal shares begins at 4.6; the tail that is drawn in a second step begins at 7.7.
TEST(Rng, TheTailOfExponentialNumbersIsExponentialToo) {
    Rng rng(4, 5, 6);
    constexpr double kFrom = 7.5;
    int beyond = 0;
    double sum = 0;
    double squares = 0;
    for (int i = 0; i < 16 * kDraws; ++i) {
        const double over = rng.exponential() - kFrom;
        if (over < 0) continue;
        ++beyond;
        sum += over;
        squares += over * over;
    }
    const double expected = 16.0 * kDraws * std::exp(-kFrom);
    EXPECT_LT(std::abs(beyond - expected), 5 * std::sqrt(expected));
    EXPECT_GT(std::abs(beyond - 1.05 * expected), 5 * std::sqrt(expected)) << "5 % more are found out";
    EXPECT_LT(std::abs(sum / beyond - 1), 5 / std::sqrt(beyond));
    EXPECT_LT(std::abs(squares / beyond - 2), 5 * std::sqrt(20.0 / beyond));
}

}  // namespace
}  // namespace fluovox
