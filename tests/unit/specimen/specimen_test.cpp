#include "fluovox/specimen/specimen.h"

#include "fluovox/core/bounds.h"
#include "fluovox/core/error.h"
#include "fluovox/core/progress.h"
#include "fluovox/core/rng.h"
#include "fluovox/specimen/pyramidal_neuron.h"
#include "fluovox/specimen/skin.h"
#include "fluovox/specimen/solids.h"
#include "fluovox/specimen/write_specimen.h"
#include "fluovox/volume/grid_info.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>

namespace fluovox {
namespace {

constexpr double kPi = std::numbers::pi;

// The obvious way: the least distance to many spheres along the axis.
double slow_distance(const RoundCone& cone, Vec3 p) {
    double least = 1e9;
    constexpr int kSpheres = 20000;
    for (int i = 0; i <= kSpheres; ++i) {
        const double t = static_cast<double>(i) / kSpheres;
        const Vec3 center = cone.begin + t * (cone.end - cone.begin);
        const double radius = cone.begin_radius_um + t * (cone.end_radius_um - cone.begin_radius_um);
        least = std::min(least, length(p - center) - radius);
    }
    return least;
}

TEST(RoundCone, DistanceIsThatOfTheUnionOfItsSpheres) {
    const std::vector<RoundCone> cones = {
        {{0, 0, 0}, {5, 1, -2}, 2, 0.5, 0}, {{0, 0, 0}, {0, 3, 0}, 1, 1, 0}, {{1, 2, 3}, {1.5, 2, 3}, 0.3, 2, 0}};
    Rng rng(3, 0, 0);
    for (const RoundCone& cone : cones) {
        for (int i = 0; i < 100; ++i) {
            const Vec3 p{8 * rng.uniform() - 2, 8 * rng.uniform() - 3, 8 * rng.uniform() - 4};
            EXPECT_NEAR(signed_distance_um(cone, p), slow_distance(cone, p), 1e-4);
        }
    }
}

TEST(Ball, IsClosedAndHasExactlyTheVolumeOfTheSphere) {
    for (const int divisions : {0, 1, 3}) {
        const Mesh ball = make_ball({10, -20, 30}, 5, divisions);
        EXPECT_EQ(ball.triangles.size(), 20U << (2 * divisions));
        EXPECT_EQ(count_bad_edges(ball), 0U);
        EXPECT_NEAR(signed_volume(ball), 4 * kPi / 3 * 125, 1e-6);
    }
}

TEST(Solids, CountsTheEdgesOfAHoleAndOfATriangleTurnedOver) {
    Mesh ball = make_ball({0, 0, 0}, 1, 2);
    Mesh turned = ball;
    std::swap(turned.triangles[7][0], turned.triangles[7][1]);
    EXPECT_EQ(count_bad_edges(turned), 3U);
    ball.triangles.pop_back();
    EXPECT_EQ(count_bad_edges(ball), 3U);
}

TEST(Skin, OfACapsuleIsClosedFacesOutwardsAndHasItsVolume) {
    const double radius = 2;
    const double along = 6;
    const Mesh skin = make_skin({{{0, 0, 0}, {along, 0, 0}, radius, radius, 0}}, 0.2);
    const double volume = kPi * radius * radius * along + 4 * kPi / 3 * radius * radius * radius;
    EXPECT_EQ(count_bad_edges(skin), 0U);
    EXPECT_NEAR(signed_volume(skin) / volume, 1, 0.01);
}

TEST(Skin, RefusesAResolutionThatIsNotPositive) {
    EXPECT_THROW(make_skin({}, 0), InputError);
}

TEST(Neuron, IsTheSameForTheSameSeedAndAnotherForAnother) {
    const std::string one = to_swc(grow_pyramidal_neuron(1), "");
    EXPECT_EQ(one, to_swc(grow_pyramidal_neuron(1), ""));
    EXPECT_NE(one, to_swc(grow_pyramidal_neuron(2), ""));
}

TEST(Neuron, HasTheSizesOfAPyramidalCell) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE(seed);
        const Morphology cell = grow_pyramidal_neuron(seed);
        Bounds box;
        int spines = 0;
        for (const MorphologyPoint& point : cell.points) {
            box.add(point.position);
            EXPECT_GE(point.radius_um, 0.3);
            EXPECT_LE(point.radius_um, 8);
            if (point.part == CellPart::Spine) ++spines;
        }
        EXPECT_GT(box.size().y, 330);
        EXPECT_LT(box.size().y, 430);
        EXPECT_GT(box.size().x, 180);
        EXPECT_LT(box.size().x, 280);
        EXPECT_LT(std::max(-box.min.z, box.max.z), 40);  // the slice of its scene is 80 um thick
        EXPECT_GT(cell.length_um(CellPart::BasalDendrite), 1000);
        EXPECT_GT(cell.length_um(CellPart::ApicalDendrite), 700);
        EXPECT_GT(cell.length_um(CellPart::Axon), 300);
        EXPECT_GT(spines, 3 * 400);
    }
}

TEST(Neuron, SwcHasOneRootAndParentsFirst) {
    std::istringstream swc(to_swc(grow_pyramidal_neuron(8), "two\nlines"));
    std::string line;
    int expected = 0;
    int roots = 0;
    int comments = 0;
    while (std::getline(swc, line)) {
        if (line[0] == '#') {
            ++comments;
            continue;
        }
        std::istringstream fields(line);
        int id = 0;
        int part = 0;
        int parent = 0;
        Vec3 place;
        double radius = 0;
        ASSERT_TRUE(fields >> id >> part >> place.x >> place.y >> place.z >> radius >> parent) << line;
        EXPECT_EQ(id, ++expected);
        EXPECT_TRUE(part >= 1 && part <= 5) << line;
        EXPECT_GT(radius, 0) << line;
        if (parent == -1)
            ++roots;
        else
            EXPECT_TRUE(parent >= 1 && parent < id) << line;
    }
    EXPECT_EQ(roots, 1);
    EXPECT_EQ(comments, 2);
}

TEST(Neuron, SurfaceIsClosedAndTheSameForAnyNumberOfThreads) {
    const Specimen one = [] {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        return make_specimen("neuron", 8);
    }();
    const Mesh& cell = one.bodies[0].mesh;
    const Mesh& nucleus = one.bodies[1].mesh;
    EXPECT_EQ(count_bad_edges(cell), 0U);
    EXPECT_EQ(count_bad_edges(nucleus), 0U);
    EXPECT_GT(signed_volume(cell), 5000);
    EXPECT_LT(signed_volume(cell), 12000);
    EXPECT_GT(signed_volume(nucleus), 400);
    EXPECT_GT(cell.triangles.size(), 100'000U);
    EXPECT_LT(cell.triangles.size(), 400'000U);
    const Specimen two = make_specimen("neuron", 8);
    EXPECT_EQ(to_obj(cell, ""), to_obj(two.bodies[0].mesh, ""));
}

TEST(Beads, AreTwentySevenSpheresOfTenMicrometres) {
    const Specimen beads = make_specimen("beads", 0);
    ASSERT_EQ(beads.bodies.size(), 1U);
    EXPECT_EQ(count_bad_edges(beads.bodies[0].mesh), 0U);
    EXPECT_NEAR(signed_volume(beads.bodies[0].mesh), 27 * kPi / 6 * 1000, 1e-3);
}

TEST(Specimens, BeadsOnDiskHoldTheAmountOfDyeTheirReadmeStates) {
    const auto folder = std::filesystem::temp_directory_path() / "fluovox_specimen_test_beads";
    NoProgress silent;
    const auto files = write_specimen("beads", folder, {}, silent);
    ASSERT_EQ(files.size(), 3U);
    const auto grids = inspect_grids(folder / "beads.vdb");
    ASSERT_EQ(grids.size(), 1U);
    EXPECT_EQ(grids[0].entry.name, "EGFP");
    EXPECT_EQ(grids[0].metadata.value_unit, "umol/L");
    EXPECT_EQ(grids[0].metadata.source, "beads.obj");
    EXPECT_EQ(grids[0].metadata.source_sha256.size(), 64U);
    EXPECT_NEAR(grids[0].total_mol / 7.069e-16, 1, 0.001);
    EXPECT_NEAR(grids[0].max, 50, 1e-3);
    std::filesystem::remove_all(folder);
}

TEST(Specimens, AnUnknownNameGetsTheListAndAGuess) {
    try {
        make_specimen("neurone", 1);
        FAIL();
    } catch (const UsageError& e) {
        EXPECT_NE(std::string(e.what()).find("did you mean \"neuron\""), std::string::npos) << e.what();
        EXPECT_NE(std::string(e.what()).find("cuvette-gfp"), std::string::npos) << e.what();
    }
}

TEST(Specimens, AllHaveAScene) {
    for (const SpecimenInfo& info : specimens())
        EXPECT_NE(make_specimen(info.name, info.seed).scene_toml.find("[camera]"), std::string::npos) << info.name;
}

}  // namespace
}  // namespace fluovox
