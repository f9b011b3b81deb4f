#include "fluovox/spectral/lanes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fluovox {
namespace {

TEST(Lanes, ExponentialsAreThoseOfTheMathematicsLibrary) {
    double worst = 0;
    for (double depth = -700; depth < 707; depth += 0.1237) {
        Lanes depths(kMaxLanes);
        for (int k = 0; k < kMaxLanes; ++k)
            depths[k] = depth + 0.01 * k;
        const Lanes values = exp_minus(depths);
        for (int k = 0; k < kMaxLanes; ++k)
            worst = std::max(worst, std::abs(values[k] / std::exp(-depths[k]) - 1));
    }
    EXPECT_LT(worst, 4e-16);
    EXPECT_GT(worst, 0);  // they are not the same code
}

TEST(Lanes, NothingGetsThroughWithoutEnd) {
    Lanes depths(3);
    depths[0] = std::numeric_limits<double>::infinity();
    depths[1] = 800;
    depths[2] = 0;
    const Lanes values = exp_minus(depths);
    EXPECT_EQ(values[0], 0);
    EXPECT_EQ(values[1], 0);
    EXPECT_EQ(values[2], 1);
}

}  // namespace
}  // namespace fluovox
