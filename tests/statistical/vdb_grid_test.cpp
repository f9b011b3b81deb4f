// A grid read for rendering is the field that OpenVDB itself interpolates.

#include "fluovox/core/rng.h"
#include "fluovox/volume/sparse_grid.h"
#include "fluovox/volume/vdb_internal.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

class VdbGrid : public ::testing::Test {
protected:
    void SetUp() override {
        initialize_openvdb();
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::temp_directory_path() / ("fluovox_" + std::string(test->name()) + std::to_string(getpid()));
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    // Leaves of noise, tiles of 8^3, 128^3, inactive values, all around the origin.
    static openvdb::FloatGrid::Ptr noise(float background) {
        auto grid = new_grid<openvdb::FloatGrid>(background);
        grid->setName("dye");
        auto accessor = grid->getAccessor();
        Rng rng(41, 0, 0);
        const auto whole = [&](int size) { return static_cast<int>(std::floor((rng.uniform() - 0.5) * size)); };
        for (int n = 0; n < 20000; ++n)
            accessor.setValue({whole(60), whole(60), whole(60)}, static_cast<float>(rng.uniform()));
        for (int n = 0; n < 200; ++n)
            accessor.setValueOff({whole(60), whole(60), whole(60)}, static_cast<float>(rng.uniform()));
        grid->fill(openvdb::CoordBBox({-40, -40, 40}, {-9, -17, 71}), 0.7F);   // tiles of 8^3 and voxels
        grid->fill(openvdb::CoordBBox({128, -128, 0}, {255, -1, 127}), 0.4F);  // one tile of 128^3
        grid->fill(openvdb::CoordBBox({-64, 0, -128}, {-1, 63, -65}), 0.0F);   // tiles below the background
        return grid;
    }

    static void set_affine(openvdb::FloatGrid& grid) {
        const openvdb::math::Mat4d map(0.4, 0.1, -0.2, 0.0, -0.15, 0.5, 0.05, 0.0, 0.1, 0.2, 0.6, 0.0, 12.0, -7.0, 3.0,
                                       1.0);
        grid.setTransform(openvdb::math::Transform::createLinearTransform(map));
    }

    SparseGrid saved_and_loaded(const openvdb::FloatGrid::Ptr& grid, GridScale scale = {}) {
        const fs::path file = folder_ / "grid.vdb";
        openvdb::io::File(file.string()).write({grid});
        return SparseGrid::load(file, "dye", [&](const GridMetadata&) { return scale; });
    }

    // Largest difference to OpenVDB's own trilinear sampler over points of the index space.
    static double difference(const SparseGrid& ours, const openvdb::FloatGrid& theirs, GridScale scale,
                             double shift = 0) {
        Rng rng(42, 0, 0);
        const auto accessor = theirs.getConstAccessor();
        double most = 0;
        for (int n = 0; n < 40000; ++n) {
            const double size = n % 2 == 0 ? 80 : 400;
            const openvdb::Vec3d index(size * (rng.uniform() - 0.5), size * (rng.uniform() - 0.5),
                                       size * (rng.uniform() - 0.5));
            float value = 0;
            openvdb::tools::BoxSampler::sample(accessor, index + openvdb::Vec3d(shift), value);
            const openvdb::Vec3d world = theirs.transform().indexToWorld(index);
            const double mine =
                ours.trilinear({scale.length * world.x(), scale.length * world.y(), scale.length * world.z()});
            most = std::max(most, std::abs(mine - scale.value * static_cast<double>(value)));
        }
        return most;
    }

private:
    fs::path folder_;
};

TEST_F(VdbGrid, IsTheFieldThatOpenVdbInterpolates) {
    const auto grid = noise(0);
    set_affine(*grid);
    const SparseGrid loaded = saved_and_loaded(grid);
    EXPECT_LT(difference(loaded, *grid, {}), 1e-4);
    EXPECT_GT(difference(loaded, *grid, {}, 0.5), 0.1);  // half a voxel off would show
    EXPECT_EQ(loaded.active_voxels(), grid->baseTree().activeVoxelCount());
}

TEST_F(VdbGrid, KeepsABackgroundAndTilesBelowIt) {
    const auto grid = noise(0.3F);
    set_affine(*grid);
    const SparseGrid loaded = saved_and_loaded(grid);
    EXPECT_DOUBLE_EQ(loaded.background(), static_cast<double>(0.3F));
    EXPECT_LT(difference(loaded, *grid, {}), 1e-4);
    EXPECT_GT(difference(loaded, *grid, {}, 0.1), 0.01);
}

TEST_F(VdbGrid, AppliesTheUnitsOfValuesAndLengths) {
    const auto grid = noise(0.3F);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    const SparseGrid loaded = saved_and_loaded(grid, {1000, 0.001});
    EXPECT_LT(difference(loaded, *grid, {1000, 0.001}), 0.1);
    EXPECT_NEAR(loaded.max(), 1000, 1);
}

// More leaves than are packed at once. Every fifth is constant: of three values, and farther along of more values than
// are kept as such.
TEST_F(VdbGrid, HasTheVoxelsOfTensOfThousandsOfLeaves) {
    constexpr int kLeavesAlong = 33;
    const auto value_of = [](int i) {
        const bool is_constant = i % 5 == 0;
        const int kinds = i < kLeavesAlong * kLeavesAlong * 16 ? 3 : 400;
        return is_constant ? static_cast<float>(1 + i / 5 % kinds) : 0.5F + 0.001F * static_cast<float>(i % 997);
    };
    const auto voxel_of = [](int i) {
        const int at = 37 * i % 512;
        return Voxel{8 * (i / (kLeavesAlong * kLeavesAlong)) + at / 64,
                     8 * (i / kLeavesAlong % kLeavesAlong) + at / 8 % 8, 8 * (i % kLeavesAlong) + at % 8};
    };
    constexpr int kLeaves = kLeavesAlong * kLeavesAlong * kLeavesAlong;
    const auto grid = new_grid<openvdb::FloatGrid>(0.0F);
    grid->setName("dye");
    auto accessor = grid->getAccessor();
    for (int i = 0; i < kLeaves; ++i) {
        const Voxel at = voxel_of(i);
        if (i % 5 == 0) {
            accessor.touchLeaf({at.x, at.y, at.z})->fill(value_of(i), true);
        } else {
            accessor.setValue({at.x, at.y, at.z}, value_of(i));
        }
    }
    const SparseGrid loaded = saved_and_loaded(grid);
    EXPECT_EQ(loaded.active_voxels(), grid->baseTree().activeVoxelCount());
    int wrong = 0;
    for (int i = 0; i < kLeaves; ++i) {
        const Voxel at = voxel_of(i);
        const Voxel beside{at.x ^ 1, at.y, at.z};
        wrong += loaded.value(at) == value_of(i) ? 0 : 1;
        wrong += loaded.value(beside) == (i % 5 == 0 ? value_of(i) : 0) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0);
}

TEST_F(VdbGrid, ReadsValuesOfHalfPrecision) {
    const auto grid = noise(0);
    grid->setSaveFloatAsHalf(true);
    set_affine(*grid);
    const SparseGrid loaded = saved_and_loaded(grid);
    EXPECT_LT(difference(loaded, *grid, {}), 1e-3);
    EXPECT_GT(difference(loaded, *grid, {}), 0);
}

TEST_F(VdbGrid, BoundsHoldAllThatIsNotBackground) {
    const auto grid = noise(0);
    set_affine(*grid);
    const SparseGrid loaded = saved_and_loaded(grid);
    Rng rng(43, 0, 0);
    for (int n = 0; n < 50000; ++n) {
        const Vec3 p{200 * (rng.uniform() - 0.4), 200 * (rng.uniform() - 0.5), 150 * (rng.uniform() - 0.5)};
        if (loaded.trilinear(p) > 0) {
            EXPECT_TRUE(loaded.bounds().contains(p));
        }
    }
}

}  // namespace
}  // namespace fluovox
