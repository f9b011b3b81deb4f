#include "fluovox/core/rng.h"
#include "fluovox/voxelize/mesh_file.h"
#include "fluovox/voxelize/voxelize.h"
#include "fluovox/voxelize/winding_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

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

// It leaves the test that it stands in, as no function can.
#define FILL_OR_SKIP(filled, ...) /* NOLINT(*-macro-usage) */ \
    const auto filled = fill(__VA_ARGS__);                    \
    if (!(filled)) GTEST_SKIP() << "no specimen in " << kMeshes

class ClosedSpecimen : public ::testing::TestWithParam<const char*> {};

TEST_P(ClosedSpecimen, HoldsItsSignedVolumeAtEveryResolution) {
    constexpr std::array<std::pair<int, double>, 3> rows = {{{64, 0.005}, {256, 0.001}, {1024, 0.0005}}};
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

// The neurite without the caps where it was cut out of its volume, against its closed twin.
TEST(Specimen, ACutNeuriteKeepsItsVolume) {
    for (const int resolution : {256, 1024}) {
        FILL_OR_SKIP(filled, "pinky_seg_28673074_open.ply", resolution);
        EXPECT_EQ(filled->mesh.boundary_edges, 2570U);
        EXPECT_NEAR(filled->voxels.volume_um3 / 1.8756057e10, 1, 0.015) << resolution;
    }
}

TEST(Specimen, AThinAxonHoldsItsWindingNumberVolumeAtHighResolution) {
    FILL_OR_SKIP(filled, "fly_da1pn_722817260.ply", 256);
    EXPECT_EQ(filled->mesh.boundary_edges, 20U);
    EXPECT_EQ(filled->mesh.nonmanifold_edges, 672U);
    FILL_OR_SKIP(fine, "fly_da1pn_722817260.ply", 2048, InsideRule::Winding);
    EXPECT_NEAR(filled->voxels.volume_um3 / fine->voxels.volume_um3, 1, 0.03);
}

// Open sheets with a seam where they disagree about outside: there is no true volume, only that of the winding number,
// which is summed here triangle by triangle, without any caps or hierarchy.
TEST(Specimen, OpenSheetsHoldTheirWindingNumberVolume) {
    FILL_OR_SKIP(filled, "rat_nmj.obj", 40);
    EXPECT_EQ(filled->mesh.misoriented_edges, 1381U);
    EXPECT_EQ(filled->mesh.boundary_edges, 621U);
    EXPECT_EQ(filled->mesh.uneven_holes, 1U);
    SolidMesh solid = make_solid(load_mesh(kMeshes / "rat_nmj.obj").mesh);
    solid.mesh.triangles.resize(solid.first_cap);
    const Bounds bounds = mesh_bounds(solid.mesh);
    Rng random(11, 0, 0);
    constexpr int kPoints = 1500;
    int inside = 0;
    for (int i = 0; i < kPoints; ++i) {
        Vec3 point;
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = bounds.min[axis] + random.uniform() * bounds.size()[axis];
        double angle = 0;
        for (const auto& t : solid.mesh.triangles)
            angle +=
                solid_angle({solid.mesh.vertices[t[0]], solid.mesh.vertices[t[1]], solid.mesh.vertices[t[2]]}, point);
        inside += angle >= 2 * std::numbers::pi ? 1 : 0;
    }
    const double share = static_cast<double>(inside) / kPoints;
    const double box = bounds.size().x * bounds.size().y * bounds.size().z;
    const double sigma = box * std::sqrt(share * (1 - share) / kPoints);
    EXPECT_NEAR(filled->voxels.volume_um3, box * share, 5 * sigma);
}

}  // namespace
}  // namespace fluovox
