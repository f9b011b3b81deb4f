#include "fluovox/transport/voxel_tally.h"

#include "fluovox/core/error.h"
#include "fluovox/core/progress.h"
#include "fluovox/core/rng.h"
#include "fluovox/transport/fluence.h"
#include "fluovox/volume/sparse_grid_builder.h"

#include "scene_kit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using Place = std::array<int, 3>;

bool near_a_value(const SparseGrid& grid, Place at) {
    for (int i = 0; i < 27; ++i) {
        if (grid.value({at[0] + i / 9 - 1, at[1] + i / 3 % 3 - 1, at[2] + i % 3 - 1}) > 0) return true;
    }
    return false;
}

std::set<Place> counted(const VoxelLattice& lattice) {
    std::set<Place> voxels;
    for (std::size_t brick = 0; brick < lattice.bricks.size(); ++brick) {
        const Voxel first = lattice.bricks[brick];
        for (int i = 0; i < 512; ++i) {
            if (lattice.counts(brick, i))
                voxels.insert({first.x + (i >> 6), first.y + (i >> 3 & 7), first.z + (i & 7)});
        }
    }
    return voxels;
}

// Voxels at random in two nodes: many at the edges of their bricks and nodes.
TEST(VoxelLattice, HoldsEachVoxelThatIsNextToAValueAndNoOther) {
    Rng rng(1, 0, 0);
    const SparseGrid grid = SparseGrid::from_function({-20, -9, -33}, {15, 20, 9}, Affine{},
                                                      [&](Voxel) { return rng.uniform() < 0.002 ? 1.0 : 0.0; });
    const std::set<Place> voxels = counted(VoxelLattice::with_values(grid));
    std::size_t missing = 0;
    std::size_t found = 0;
    for (int x = -40; x < 32; ++x) {
        for (int y = -32; y < 32; ++y) {
            for (int z = -56; z < 24; ++z) {
                const bool is_near = near_a_value(grid, {x, y, z});
                missing += is_near && !voxels.contains({x, y, z}) ? 1 : 0;
                found += is_near ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(missing, 0U);
    EXPECT_EQ(voxels.size(), found);
    EXPECT_GT(found, 500U);
}

constexpr int kFar = 8 * 4000;

// Two lone voxels at the ends of the diagonal of a cube of 32000^3.
SparseGrid ends_of_a_diagonal(float background = 0) {
    std::array<float, 512> values{};
    values.fill(background);
    values[0] = 1;
    SparseGridBuilder builder(background);
    builder.add_brick({0, 0, 0}, values.data());
    builder.add_brick({kFar, kFar, kFar}, values.data());
    return std::move(builder).finish(Affine{}, 2);
}

TEST(VoxelLattice, CostsWhatTheGridHoldsHoweverLargeItsBox) {
    const VoxelLattice lattice = VoxelLattice::with_values(ends_of_a_diagonal());
    EXPECT_EQ(lattice.bricks.size(), 16U);
    EXPECT_EQ(counted(lattice).size(), 54U);
}

TEST(Fluence, RefusesTheWholeBoxOfABackgroundBeforeItsBricksAreListed) {
    NoProgress silent;
    Scene scene;
    scene.media = {testing::dye_in(ends_of_a_diagonal(0.1F), 0)};
    scene.dyes = {testing::flat_dye(1e-3, 480, 500, 510, 550, 0.5)};
    scene.lights = {testing::laser(BeamLight{}, 488, 1e-3)};
    FluenceSettings settings;
    settings.grids = true;
    settings.photons = 1;
    try {
        trace_fluence(scene, settings, silent);
        FAIL() << "nothing was refused";
    } catch (const Error& e) {
        EXPECT_NE(std::string(e.what()).find("has a background"), std::string::npos) << e.what();
    }
}

TEST(VoxelTally, FindsBricksThatLieFarApart) {
    VoxelTally tally(VoxelLattice::with_values(ends_of_a_diagonal()), 1, 10);
    Rng rng(1, 0, 0);
    // Along x beside the first voxel, and along the diagonal through both.
    tally.add_flight({{{-100, 1, 1}, {1, 0, 0}}, 1e6, 1, 0}, {{0, 1}}, rng);
    const double along = std::sqrt(3.0);
    tally.add_flight({{{-10, -10, -10}, {1 / along, 1 / along, 1 / along}}, 1e6, 1, 0}, {{0, 1}}, rng);
    EXPECT_NEAR(tally.at({0, 1, 1}, 0), 1, 1e-6);
    EXPECT_NEAR(tally.at({0, 0, 0}, 0), along, 1e-6);
    EXPECT_NEAR(tally.at({kFar, kFar, kFar}, 0), along, 1e-4);
    EXPECT_EQ(tally.at({kFar, kFar + 1, kFar + 1}, 0), 0);
    constexpr int kHalfWay = kFar / 2;
    EXPECT_EQ(tally.at({kHalfWay, kHalfWay, kHalfWay}, 0), 0);
}

TEST(VoxelTally, LeavesOutWhatHappensFartherAwayThanVoxelsHaveNumbers) {
    VoxelTally tally(VoxelLattice::with_values(ends_of_a_diagonal()), 1, 10);
    Rng rng(1, 0, 0);
    for (const double far : {2147483647.5, -2147483649.0, 1e12, -1e300})
        tally.add_point({0, far, 0}, 0, 1, rng);
    for (const float sum : tally.field(0, 1).values)
        EXPECT_EQ(sum, 0);
    EXPECT_EQ(tally.at({1e12, 0, 0}, 0), 0);
}

}  // namespace
}  // namespace fluovox
