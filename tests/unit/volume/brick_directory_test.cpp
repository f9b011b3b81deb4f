#include "fluovox/volume/brick_directory.h"

#include "fluovox/core/rng.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

TEST(BrickDirectory, FindsTheNextAndTheLastFilledPlaceOfEveryRun) {
    Rng rng(1, 0, 0);
    for (const double share : {0.0, 0.02, 0.3, 1.0}) {
        constexpr std::size_t kPlaces = 61;
        std::vector<std::uint8_t> levels(kPlaces);
        std::vector<std::int32_t> bricks(kPlaces, -1);
        for (std::size_t i = 0; i < kPlaces; ++i) {
            if (rng.uniform() >= share) continue;
            levels[i] = static_cast<std::uint8_t>(1 + rng.bits() % 255);
            bricks[i] = static_cast<std::int32_t>(i);
        }
        BrickDirectory directory;
        ASSERT_TRUE(directory.fill(bricks, levels));
        for (std::size_t begin = 0; begin <= kPlaces; ++begin) {
            for (std::size_t end = begin; end <= kPlaces; ++end) {
                std::size_t next = begin;
                while (next < end && levels[next] == 0)
                    ++next;
                std::size_t last = end;
                while (last > begin && levels[last - 1] == 0)
                    --last;
                ASSERT_EQ(directory.next_filled(begin, end), next) << begin << " to " << end;
                ASSERT_EQ(directory.last_filled(begin, end), last) << begin << " to " << end;
            }
        }
    }
}

TEST(BrickDirectory, RefusesBricksThatLieTooFarApart) {
    BrickDirectory directory;
    EXPECT_TRUE(directory.fill({0, 0xfffe}, {1, 1}));
    EXPECT_EQ(directory.brick(1), 0xfffeU);
    EXPECT_FALSE(directory.fill({0, 0xffff}, {1, 1}));
    EXPECT_TRUE(directory.empty());
}

}  // namespace
}  // namespace fluovox
