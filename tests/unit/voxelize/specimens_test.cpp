#include "fluovox/voxelize/mesh_file.h"
#include "fluovox/voxelize/voxelize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

// Meshes of real neurons, damaged as they come. They lie beside the project; without them these tests are skipped.
namespace fluovox {
namespace {

const std::filesystem::path kMeshes = std::filesystem::path(FLUOVOX_SHARED_DIR) / "specimens/mesh";

struct Filled {
    MeshReport mesh;
    VoxelizeReport voxels;
};

std::optional<Filled> fill(const std::string& name, int resolution, InsideRule inside = InsideRule::Auto) {
    if (!std::filesystem::exists(kMeshes / name)) return {};
    const Mesh mesh = load_mesh(kMeshes / name).mesh;
    const Vec3 size = mesh_bounds(mesh).size();
    const std::vector<SolidMesh> solids = {make_solid(mesh)};
    VoxelizeSettings settings;
    settings.voxel_size_um = std::max({size.x, size.y, size.z}) / resolution;
    settings.inside = inside;
    NoProgress progress;
    return Filled{solids[0].report, voxelize(solids, settings, progress).report};
}

#define FILL_OR_SKIP(filled, ...)          \
    const auto filled = fill(__VA_ARGS__); \
    if (!(filled)) GTEST_SKIP() << "no specimen in " << kMeshes

class ClosedSpecimen : public ::testing::TestWithParam<const char*> {};

TEST_P(ClosedSpecimen, HoldsItsSignedVolumeAtEveryResolution) {
    const std::pair<int, double> rows[] = {{64, 0.005}, {256, 0.001}, {1024, 0.0005}};
    for (const auto& [resolution, tolerance] : rows) {
        FILL_OR_SKIP(filled, GetParam(), resolution);
        EXPECT_TRUE(filled->mesh.watertight());
        EXPECT_NEAR(filled->voxels.volume_um3 / filled->mesh.volume_um3, 1, tolerance) << resolution;
    }
}

INSTANTIATE_TEST_SUITE_P(Meshes, ClosedSpecimen,
                         ::testing::Values("nucleus_nmv_4_hq.obj", "spine_nmv_5_hq.obj",
                                           "pinky_seg_28673074_closed.ply"));

TEST(Specimen, UnweldedFragmentsAreClosedOnceWelded) {
    FILL_OR_SKIP(filled, "pinky_28336523.ply", 256);
    EXPECT_EQ(filled->mesh.welded_vertices, 2422U);
    EXPECT_TRUE(filled->mesh.watertight());
    EXPECT_NEAR(filled->voxels.volume_um3 / 8.3119988e10, 1, 0.001);
}

TEST(Specimen, CoordinatesNearAMillionGiveTheRightAmount) {
    FILL_OR_SKIP(filled, "microns_864691134884740346_spines.obj", 256);
    EXPECT_NEAR(filled->voxels.volume_um3 / 5.1428593e11, 1, 0.001);
}

TEST(Specimen, TheBunnyWithFiveHolesHoldsItsWindingNumberVolume) {
    FILL_OR_SKIP(filled, "stanford_bunny.obj", 256);
    EXPECT_EQ(filled->mesh.boundary_edges, 223U);
    EXPECT_EQ(filled->mesh.holes, 5U);
    FILL_OR_SKIP(winding, "stanford_bunny.obj", 256, InsideRule::Winding);
    EXPECT_NEAR(filled->voxels.volume_um3 / winding->voxels.volume_um3, 1, 0.01);
}

}  // namespace
}  // namespace fluovox
