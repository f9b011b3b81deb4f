#include "fluovox/volume/brick_directory.h"

#include "fluovox/core/rng.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {
namespace {

constexpr std::size_t kPlaces = 60;

// Levels of random places, a share of them filled.
std::vector<std::uint8_t> random_levels(double share, Rng& rng) {
    std::vector<std::uint8_t> levels(kPlaces);
    for (std::uint8_t& level : levels)
        level = rng.uniform() < share ? static_cast<std::uint8_t>(1 + rng.bits() % 255) : 0;
    return levels;
}

// Bricks one after the other, as the nodes of a tree have them.
BrickDirectory directory_of(const std::vector<std::uint8_t>& levels, std::uint32_t first) {
    BrickDirectory directory(levels.size());
    for (std::size_t place = 0; place < levels.size(); ++place) {
        if (levels[place] != 0) {
            EXPECT_TRUE(directory.add(place, first, levels[place]));
            ++first;
        }
    }
    return directory;
}

TEST(BrickDirectory, GivesBackTheLevelAndTheBrickOfEveryPlace) {
    Rng rng(1, 0, 0);
    for (const double share : {0.0, 0.02, 0.3, 1.0}) {
        const std::vector<std::uint8_t> levels = random_levels(share, rng);
        constexpr std::uint32_t kFirst = 4'000'000'000;
        const BrickDirectory directory = directory_of(levels, kFirst);
        std::uint32_t brick = kFirst;
        for (std::size_t place = 0; place < kPlaces; ++place) {
            ASSERT_EQ(directory.level(place), levels[place]);
            ASSERT_EQ(directory.has(place), levels[place] != 0);
            if (levels[place] == 0) continue;
            ASSERT_EQ(directory.brick(place), brick);
            ++brick;
        }
    }
}

TEST(BrickDirectory, FindsTheNextAndTheLastFilledPlaceOfEveryStretch) {
    Rng rng(1, 0, 0);
    for (const double share : {0.0, 0.02, 0.3, 1.0}) {
        const std::vector<std::uint8_t> levels = random_levels(share, rng);
        const BrickDirectory directory = directory_of(levels, 0);
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

TEST(BrickDirectory, RefusesBricksOfARunThatAreNotOneAfterTheOther) {
    BrickDirectory directory(4);
    EXPECT_TRUE(directory.add(0, 7, 1));
    EXPECT_TRUE(directory.add(2, 8, 1));
    EXPECT_FALSE(directory.add(3, 10, 1));
}

TEST(BrickDirectory, RefusesABrickWithoutABound) {
    BrickDirectory directory(4);
    EXPECT_FALSE(directory.add(0, 7, 0));
}

}  // namespace
}  // namespace fluovox
