#include "fluovox/volume/fixed_point.h"

#include "fluovox/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

namespace fluovox {
namespace {

TEST(FixedPoint, InABrickItRoundsToTheSameVoxelAsInSpace) {
    Rng rng(1, 2, 3);
    for (int i = 0; i < 100000; ++i) {
        const Vec3 bricks{100 * rng.uniform(), 100 * rng.uniform(), 100 * rng.uniform()};
        const Voxel first{static_cast<int>(bricks.x), static_cast<int>(bricks.y), static_cast<int>(bricks.z)};
        const std::uint64_t bits = rng.bits();
        const Voxel in_brick = FixedPoint::from_brick(bricks, first).rounded(bits);
        const Voxel in_space = FixedPoint(8.0 * bricks).rounded(bits);
        ASSERT_EQ(8 * first.x + in_brick.x, in_space.x);
        ASSERT_EQ(8 * first.y + in_brick.y, in_space.y);
        ASSERT_EQ(8 * first.z + in_brick.z, in_space.z);
    }
}

TEST(FixedPoint, CellsOfABrickAreQuartersOfIt) {
    const auto cell = [](double x, double y, double z) {
        return FixedPoint::from_brick({5 + x, 7 + y, 9 + z}, {5, 7, 9}).cell();
    };
    const double below = 0.25 - 1e-6;
    EXPECT_EQ(cell(below, below, below), 0U);
    EXPECT_EQ(cell(0.25, below, below), 16U);
    EXPECT_EQ(cell(below, 0.25, below), 4U);
    EXPECT_EQ(cell(below, below, 0.25), 1U);
    EXPECT_EQ(cell(0.5, 0.75, 0.3), 2 * 16U + 3 * 4U + 1);
    EXPECT_EQ(cell(0.999999, 0.999999, 0.999999), 63U);
    // Rounding may put the ends of a stretch just outside of the brick that it is in.
    EXPECT_EQ(cell(-1e-6, -1e-6, -1e-6), 0U);
    EXPECT_EQ(cell(1, 1, 1), 63U);
    EXPECT_EQ(cell(-1e-6, 1, 0.3), 3 * 4U + 1);
}

TEST(FixedPoint, PlacesFarAwayAreTheFarthestVoxels) {
    constexpr int kFarthest = 2147483646;
    for (const std::uint64_t bits : {std::uint64_t{0}, ~std::uint64_t{0}}) {
        const Voxel voxel = FixedPoint(Vec3{1e20, -1e20, 3}).rounded(bits);
        EXPECT_EQ(voxel.x, kFarthest);
        EXPECT_EQ(voxel.y, -kFarthest);
        EXPECT_EQ(voxel.z, 3);
    }
    EXPECT_EQ(FixedPoint(Vec3{2e9, -2e9, 0}).rounded(0).x, 2000000000);
    EXPECT_EQ(FixedPoint(Vec3{2e9, -2e9, 0}).rounded(0).y, -2000000000);
}

TEST(FixedPoint, RoundingKeepsThePlaceOnAverage) {
    const Vec3 bricks{3.3141, 2.2718, 1.1414};
    const FixedPoint place = FixedPoint::from_brick(bricks, {3, 2, 1});
    Rng rng(4, 5, 6);
    constexpr int kDraws = 1000000;
    Vec3 sum;
    for (int i = 0; i < kDraws; ++i) {
        const Voxel voxel = place.rounded(rng.bits());
        sum = sum + Vec3{1.0 * voxel.x, 1.0 * voxel.y, 1.0 * voxel.z};
    }
    const Vec3 mean = (1.0 / kDraws) * sum;
    const double allowed = 5 * 0.5 / std::sqrt(1.0 * kDraws);  // a coin's standard deviation is at most one half
    EXPECT_NEAR(mean.x, 8 * 0.3141, allowed);
    EXPECT_NEAR(mean.y, 8 * 0.2718, allowed);
    EXPECT_NEAR(mean.z, 8 * 0.1414, allowed);
    EXPECT_GT(std::abs(mean.x - 8 * 0.3141 * 1.01), allowed);  // one part in a hundred would be seen
}

}  // namespace
}  // namespace fluovox
