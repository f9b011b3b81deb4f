#include "fluovox/core/circle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

TEST(OnCircle, IsCosineAndSineOfTheTurn) {
    double worst = 0;
    for (int i = 0; i <= 100'000; ++i) {
        const double turns = i * 1e-5;
        const double angle = 2 * std::numbers::pi * turns;
        const CirclePoint point = on_circle(turns);
        worst = std::max({worst, std::abs(point.cos - std::cos(angle)), std::abs(point.sin - std::sin(angle))});
    }
    EXPECT_LT(worst, 2e-15);
    EXPECT_GT(worst, 0);
}

TEST(OnCircle, IsAsFarFromTheMiddleEverywhere) {
    for (const double turns : {0.0, 0.1, 0.25, 0.499, 0.5, 0.75, 0.9999999}) {
        const CirclePoint point = on_circle(turns);
        EXPECT_NEAR(point.cos * point.cos + point.sin * point.sin, 1, 4e-15) << turns;
    }
}

}  // namespace
}  // namespace fluovox
