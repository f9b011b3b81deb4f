#include "fluovox/volume/brick_directory.h"

#include "fluovox/core/rng.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {
namespace {

// Levels of the places of a box, z fastest; 0 where there is no brick.
struct Box {
    Voxel count;
    std::vector<std::uint8_t> levels;

    template <class Visit>
    void for_each(const Visit& visit) const {
        std::size_t i = 0;
        for (Voxel at; at.x < count.x; ++at.x) {
            for (at.y = 0; at.y < count.y; ++at.y) {
                for (at.z = 0; at.z < count.z; ++at.z)
                    visit(at, levels[i++]);
            }
        }
    }
};

Box random_box(Voxel count, double share, Rng& rng) {
    Box box{count, std::vector<std::uint8_t>(static_cast<std::size_t>(count.x * count.y * count.z))};
    for (std::uint8_t& level : box.levels)
        level = rng.uniform() < share ? static_cast<std::uint8_t>(1 + rng.bits() % 255) : 0;
    return box;
}

BrickDirectory directory_of(const Box& box) {
    BrickDirectory directory(box.count);
    box.for_each([&](Voxel at, std::uint8_t level) {
        if (level != 0) directory.add(at, level);
    });
    directory.finish();
    return directory;
}

// Columns within a word, of just one, and of several.
const std::vector<Voxel> kCounts = {{3, 4, 5}, {2, 3, 64}, {3, 2, 130}};

TEST(BrickDirectory, GivesBackTheLevelAndTheBrickOfEveryPlace) {
    Rng rng(1, 0, 0);
    for (const Voxel count : kCounts) {
        for (const double share : {0.0, 0.02, 0.3, 1.0}) {
            const Box box = random_box(count, share, rng);
            const BrickDirectory directory = directory_of(box);
            std::size_t brick = 0;
            box.for_each([&](Voxel at, std::uint8_t level) {
                const std::size_t place = directory.place(at);
                ASSERT_EQ(directory.has(place), level != 0);
                if (level == 0) return;
                ASSERT_EQ(directory.brick(place), brick);
                ASSERT_EQ(directory.level(brick), level);
                ++brick;
            });
            EXPECT_EQ(directory.size(), brick);
        }
    }
}

TEST(BrickDirectory, ListsThePlacesOfFullBoxesOneByOne) {
    Rng rng(2, 0, 0);
    for (const Voxel count : kCounts) {
        EXPECT_FALSE(directory_of(random_box(count, 0.05, rng)).is_dense());
        const Box box = random_box(count, 0.5, rng);
        const BrickDirectory directory = directory_of(box);
        ASSERT_TRUE(directory.is_dense());
        box.for_each([&](Voxel at, std::uint8_t level) {
            const BrickDirectory::Entry entry = directory.entries()[directory.entry_place(at)];
            ASSERT_EQ(entry.level, level);
            if (level == 0) return;
            ASSERT_EQ(entry.brick, directory.brick(directory.place(at)));
        });
    }
}

TEST(BrickDirectory, OfNoBoxIsEmpty) {
    EXPECT_TRUE(BrickDirectory().empty());
    EXPECT_FALSE(BrickDirectory({1, 1, 1}).empty());
}

}  // namespace
}  // namespace fluovox
