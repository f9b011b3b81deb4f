#include "fluovox/transport/absorbed_share.h"

#include <gtest/gtest.h>

#include <cmath>

namespace fluovox {
namespace {

TEST(AbsorbedShare, IsRightToRoundingOnBothSidesOfTheSwitch) {
    for (double depth = 1e-300; depth < 40; depth *= depth < 1e-3 ? 7 : 1.003) {
        const double exact = -std::expm1(-depth);
        EXPECT_NEAR(absorbed_share(depth) / exact, 1, 1e-14) << "depth " << depth;
    }
    EXPECT_EQ(absorbed_share(0), 0);
}

TEST(AbsorbedShare, DepthOfShareGoesBack) {
    for (double depth = 1e-300; depth < 30; depth *= depth < 1e-3 ? 7 : 1.003) {
        const double share = -std::expm1(-depth);
        const double exact = -std::log1p(-share);
        EXPECT_NEAR(depth_of_share(share) / exact, 1, 1e-14) << "depth " << depth;
    }
}

}  // namespace
}  // namespace fluovox
