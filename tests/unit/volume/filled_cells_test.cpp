#include "fluovox/volume/filled_cells.h"

#include "fluovox/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {
namespace {

// Voxels of 2^3 bricks, of which some are set.
class Voxels {
public:
    static constexpr std::size_t kAlong = 16;

    Voxels(double share, std::uint64_t seed) : set_(kAlong * kAlong * kAlong) {
        Rng rng(seed, 0, 0);
        std::generate(set_.begin(), set_.end(), [&] { return rng.uniform() < share; });
    }

    bool at(std::size_t x, std::size_t y, std::size_t z) const { return set_[(x * kAlong + y) * kAlong + z]; }

    BrickVoxels brick(std::size_t axes) const {
        BrickVoxels voxels;
        for (std::size_t block = 0; block < 8; ++block) {
            std::uint64_t mask = 0;
            for (std::size_t i = 0; i < 64; ++i) {
                const std::size_t x = 8 * (axes >> 2U) + 4 * (block >> 2U) + (i >> 4U);
                const std::size_t y = 8 * (axes >> 1U & 1U) + 4 * (block >> 1U & 1U) + (i >> 2U & 3U);
                const std::size_t z = 8 * (axes & 1U) + 4 * (block & 1U) + (i & 3U);
                mask |= at(x, y, z) ? std::uint64_t{1} << i : 0;
            }
            voxels.set_block(static_cast<unsigned>(block), mask);
        }
        return voxels;
    }

    // Voxel by voxel: a cell reaches over so many of them.
    std::uint64_t cells(std::size_t reach) const {
        std::uint64_t filled = 0;
        for (std::size_t cell = 0; cell < 64; ++cell) {
            for (std::size_t i = 0; i < reach * reach * reach; ++i) {
                const std::size_t x = 2 * (cell >> 4U) + i / reach / reach;
                const std::size_t y = 2 * (cell >> 2U & 3U) + i / reach % reach;
                const std::size_t z = 2 * (cell & 3U) + i % reach;
                filled |= at(x, y, z) ? std::uint64_t{1} << cell : 0;
            }
        }
        return filled;
    }

private:
    std::vector<bool> set_;
};

std::uint64_t cells_of_first(const Voxels& voxels) {
    std::array<BrickVoxels, 8> bricks;
    std::array<const BrickVoxels*, 8> at{};
    for (std::size_t axes = 0; axes < 8; ++axes) {
        bricks[axes] = voxels.brick(axes);
        at[axes] = &bricks[axes];
    }
    return filled_cells(at);
}

TEST(FilledCells, AreThoseThatASetVoxelIsSeenFrom) {
    int others = 0;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const Voxels voxels(seed % 2 == 0 ? 0.01 : 0.05, seed);
        ASSERT_EQ(cells_of_first(voxels), voxels.cells(3)) << "seed " << seed;
        others += voxels.cells(2) != voxels.cells(3) ? 1 : 0;
    }
    EXPECT_GT(others, 400);  // a cell that reached less far would be seen
}

TEST(FilledCells, AreAllOrNone) {
    EXPECT_EQ(cells_of_first(Voxels(0, 1)), 0U);
    EXPECT_EQ(cells_of_first(Voxels(1, 1)), ~std::uint64_t{0});
}

}  // namespace
}  // namespace fluovox
