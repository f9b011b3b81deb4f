#include "fluovox/voxelize/voxelize.h"

#include "fluovox/core/error.h"
#include "fluovox/voxelize/mesh_repair.h"

#include "unit/voxelize/figures.h"
#include "unit/voxelize/shapes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using namespace testing;
using std::numbers::pi;

struct Filled {
    MeshReport mesh;
    VoxelizeReport voxels;
    GridInfo grid;
};

Filled fill(const Mesh& mesh, double voxel_um, InsideRule inside = InsideRule::Auto) {
    const std::vector<SolidMesh> solids = {make_solid(mesh)};
    VoxelizeSettings settings;
    settings.voxel_size_um = voxel_um;
    settings.inside = inside;
    NoProgress progress;
    const VoxelizedGrid result = voxelize(solids, settings, progress);
    return {solids[0].report, result.report, inspect_dye_grid(result.grid)};
}

/// Volume of what the grid holds, by the grid itself.
double grid_volume(const Filled& filled) {
    return filled.grid.total_mol / 1e-21;
}

TEST(Voxelize, ABoxOnTheLatticeFillsItsVoxelsExactly) {
    const Filled filled = fill(box({-3, 2, 5}, {5, 20, 41}), 1);
    EXPECT_EQ(filled.grid.active_voxels, 8U * 18U * 36U);
    EXPECT_EQ(filled.grid.min, 1);
    expect_volume("box on the lattice", grid_volume(filled), 8.0 * 18 * 36, 1e-14);
}

TEST(Voxelize, ABoxBetweenVoxelsHasExactFractions) {
    const Mesh mesh = box({0.25, 0.25, 0.25}, {10.75, 7.5, 3.125});
    const Filled filled = fill(mesh, 1);
    expect_volume("box between voxels", grid_volume(filled), 10.5 * 7.25 * 2.875, 4e-7);
    EXPECT_NEAR(filled.grid.min, 0.125 * 0.5 * 0.75, 1e-6);  // the corner voxel
}

TEST(Voxelize, OverlappingBoxesAreAUnionAndNotASum) {
    const Mesh two = joined(box({0, 0, 0}, {10, 10, 10}), box({4.5, 3.3, 2.2}, {14, 12, 11}));
    const double shared = 5.5 * 6.7 * 7.8;
    const double truth = 1000 + 9.5 * 8.7 * 8.8 - shared;
    const Filled filled = fill(two, 0.5);
    expect_volume("two overlapping boxes", filled.voxels.volume_um3, truth, 0.002);
    EXPECT_NEAR(filled.voxels.capped_um3, truth + shared, 1e-6);
    EXPECT_EQ(filled.grid.max, 1);
}

TEST(Voxelize, TheSameMeshTwiceIsTheMeshOnce) {
    const Mesh one = ball({1, 2, 3}, 5.2);
    const Filled twice = fill(joined(one, moved(one, {1e-3, 0, 0})), 0.5);
    EXPECT_NEAR(twice.voxels.volume_um3 / signed_volume(one), 1, 0.005);
}

TEST(Voxelize, AnInsideOutBoxIsTurned) {
    const Filled filled = fill(inside_out(box({0, 0, 0}, {10, 10, 10})), 1);
    EXPECT_EQ(filled.mesh.flipped_components, 1U);
    expect_volume("box inside out", grid_volume(filled), 1000, 1e-9);
}

TEST(Voxelize, ANestedCavityStaysEmptyAndItsCoreFull) {
    const Mesh shell = joined(box({0, 0, 0}, {12, 12, 12}), inside_out(box({2, 2, 2}, {10, 10, 10})));
    const Mesh mesh = joined(shell, box({4, 4, 4}, {8, 8, 8}));
    const double truth = 12.0 * 12 * 12 - 8.0 * 8 * 8 + 4.0 * 4 * 4;
    const Filled filled = fill(mesh, 1);
    expect_volume("nested cavity with a core", grid_volume(filled), truth, 1e-9);
    EXPECT_EQ(filled.mesh.cavities, 1U);
    expect_volume("the whole nest inside out", grid_volume(fill(inside_out(mesh), 1)), truth, 1e-9);
}

TEST(Voxelize, FlippedTrianglesAreTurnedBack) {
    Mesh mesh = ball({0, 0, 0}, 10);
    const double truth = signed_volume(mesh);
    Rng random(3, 1, 4);
    for (auto& triangle : mesh.triangles)
        if (random.uniform() < 0.1) testing::flip(triangle);
    const Filled filled = fill(mesh, 0.25);
    EXPECT_GT(filled.mesh.misoriented_edges, 1000U);
    expect_volume("ball, 10 % of triangles flipped", grid_volume(filled), truth, 1e-5);
}

TEST(Voxelize, DroppedTrianglesAreCapped) {
    Mesh mesh = ball({0, 0, 0}, 10);
    const double truth = signed_volume(mesh);
    Rng random(3, 1, 5);
    std::erase_if(mesh.triangles, [&](const auto&) { return random.uniform() < 0.02; });
    const std::vector<std::pair<std::string, InsideRule>> rules = {{"auto", InsideRule::Auto},
                                                                   {"stab", InsideRule::Stab},
                                                                   {"winding", InsideRule::Winding},
                                                                   {"flood", InsideRule::Flood}};
    for (const auto& [name, rule] : rules) {
        const Filled filled = fill(mesh, 0.25, rule);
        EXPECT_GT(filled.mesh.holes, 100U);
        expect_volume("ball, 2 % of triangles dropped, " + name, grid_volume(filled), truth, 0.002);
    }
}

TEST(Voxelize, CoordinatesNearAMillionLoseNothing) {
    const Mesh mesh = ball({0, 0, 0}, 3.7);
    const Filled near = fill(mesh, 0.125);
    const Filled far = fill(moved(mesh, {1e6, -1e6, 1e6}), 0.125);
    expect_volume("ball moved by 1e6", grid_volume(far), grid_volume(near), 1e-6);
    EXPECT_EQ(far.grid.active_voxels, near.grid.active_voxels);
}

// The amount of dye in a process thinner than a voxel must not depend on its direction.
TEST(Voxelize, AThinCylinderKeepsItsAmountInAnyDirection) {
    const std::vector<Vec3> directions = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0.01, 0.02}, {3, 5, 7}};
    for (const Vec3& direction : directions) {
        const Vec3 to = 60.0 * normalized(direction);
        const Mesh mesh = cylinder({0.5, 0.5, 0.5}, to + Vec3{0.5, 0.5, 0.5}, 0.3, 96);
        const Filled filled = fill(mesh, 1);
        expect_volume(
            fmt::format("cylinder, 0.3 voxels' radius, along {:g} {:g} {:g}", direction.x, direction.y, direction.z),
            grid_volume(filled), pi * 0.09 * 60, 0.001);
    }
}

TEST(Voxelize, UnweldedTrianglesAreAsGoodAsWelded) {
    const Mesh mesh = ball({0, 0, 0}, 5);
    Mesh loose;
    for (const auto& t : mesh.triangles) {
        const auto first = static_cast<std::uint32_t>(loose.vertices.size());
        for (const std::uint32_t vertex : t)
            loose.vertices.push_back(mesh.vertices[vertex]);
        loose.triangles.push_back({first, first + 1, first + 2});
    }
    const Filled filled = fill(loose, 0.25);
    EXPECT_TRUE(filled.mesh.watertight());
    EXPECT_EQ(filled.mesh.vertices, mesh.vertices.size());
    EXPECT_NEAR(grid_volume(filled), signed_volume(mesh), 1e-4 * signed_volume(mesh));
}

// Half a ball without its flat side: the cap is plane, so the answer is half a ball.
TEST(Voxelize, APlaneHoleIsClosedByAPlane) {
    Mesh half = ball({0, 0, 0}, 10);
    std::erase_if(half.triangles, [&](const auto& t) {
        return half.vertices[t[0]].z + half.vertices[t[1]].z + half.vertices[t[2]].z < 0;
    });
    const Filled filled = fill(half, 0.25);
    EXPECT_EQ(filled.mesh.holes, 1U);
    EXPECT_EQ(filled.mesh.uneven_holes, 0U);
    EXPECT_EQ(filled.voxels.decided_by_winding, 0U);
    EXPECT_NEAR(grid_volume(filled) / (2 * pi / 3 * 1000), 1, 0.005);
}

TEST(Voxelize, AFloodFillsCavitiesAndNothingElse) {
    const Mesh boxes = joined(box({0, 0, 0}, {40, 40, 40}), inside_out(box({4, 4, 4}, {36, 36, 36})));
    EXPECT_NEAR(grid_volume(fill(boxes, 1, InsideRule::Flood)), 40.0 * 40 * 40, 1e-6);
    const Mesh solid = ball({0.3, 0.2, 0.1}, 10);
    const Mesh hollow = joined(solid, inside_out(ball({1, 2, 3}, 5)));
    EXPECT_LT(grid_volume(fill(hollow, 0.25)), 0.9 * signed_volume(solid));
    EXPECT_NEAR(grid_volume(fill(hollow, 0.25, InsideRule::Flood)) / signed_volume(solid), 1, 1e-4);
    EXPECT_NEAR(grid_volume(fill(inside_out(solid), 0.25, InsideRule::Flood)) / signed_volume(solid), 1, 1e-4);
    const Mesh two = joined(box({0, 0, 0}, {10, 10, 10}), box({4.5, 3.3, 2.2}, {14, 12, 11}));
    EXPECT_NEAR(grid_volume(fill(two, 0.5, InsideRule::Flood)), 1000 + 9.5 * 8.7 * 8.8 - 5.5 * 6.7 * 7.8, 3);
    // Two plates and a rim all around, but for a window: outside gets in.
    Mesh open = joined(box({0, 0, 0}, {20, 20, 2}), box({0, 0, 18}, {20, 20, 20}));
    open = joined(open, joined(box({0, 0, 2}, {2, 20, 18}), box({18, 0, 2}, {20, 20, 18})));
    const double plates = 2 * 800 + 2 * 640;
    EXPECT_NEAR(grid_volume(fill(open, 1, InsideRule::Flood)), plates, 1e-6);
}

TEST(Voxelize, LongSpansAreTilesAndCostNoLeaves) {
    const Filled filled = fill(box({0, 0, 0}, {512, 512, 512}), 1);
    EXPECT_EQ(filled.grid.active_voxels, 512U * 512U * 512U);
    EXPECT_LT(filled.grid.memory_bytes, 20'000'000U);
}

TEST(Voxelize, TheSameVoxelsForAnyNumberOfThreads) {
    const Mesh mesh = joined(ball({0, 0, 0}, 10), ball({5, 3, 2}, 8));
    const Filled many = fill(mesh, 0.2);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Filled alone = fill(mesh, 0.2);
    EXPECT_EQ(many.voxels.volume_um3, alone.voxels.volume_um3);
    EXPECT_EQ(many.grid.total_mol, alone.grid.total_mol);
    EXPECT_EQ(many.grid.active_voxels, alone.grid.active_voxels);
}

TEST(Voxelize, NothingInsideIsAnErrorAndNotAnEmptyGrid) {
    Mesh sheet;
    sheet.vertices = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    EXPECT_THROW(fill(sheet, 1), InputError);
}

TEST(Voxelize, AGridFarTooLargeIsRefusedWithTheLikelyCause) {
    try {
        fill(ball({0, 0, 0}, 20000), 0.1);
        FAIL() << "should have thrown";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("add --mesh-unit nm"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace fluovox
