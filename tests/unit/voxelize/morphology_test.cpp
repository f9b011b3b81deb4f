#include "fluovox/voxelize/morphology.h"

#include "fluovox/core/error.h"
#include "fluovox/core/rng.h"
#include "fluovox/voxelize/capsule_tile.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/voxelize.h"

#include "unit/voxelize/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

namespace fluovox {
namespace {

using std::numbers::pi;

CapsuleNeuron swc(const std::string& text) {
    return parse_morphology(text, ".swc", "m.swc");
}

CapsuleNeuron asc(const std::string& text) {
    return parse_morphology(text, ".asc", "m.asc");
}

double voxel_volume(const std::vector<Capsule>& capsules, double voxel_um) {
    VoxelizeSettings settings;
    settings.voxel_size_um = voxel_um;
    NoProgress progress;
    return voxelize_capsules(capsules, settings, progress).report.volume_um3;
}

/// By the distance to the axis, with no regard to how the voxelizer cuts capsules.
bool inside(const Capsule& capsule, const Vec3& p) {
    const Vec3 axis = capsule.to - capsule.from;
    const double squared = dot(axis, axis);
    const double shrink = capsule.from_radius - capsule.to_radius;
    double s = 0;
    if (squared > shrink * shrink) {
        // The ball of the family between the two ends that reaches farthest towards p.
        const double along = dot(p - capsule.from, axis) / std::sqrt(squared);
        const double across = std::sqrt(std::max(0.0, dot(p - capsule.from, p - capsule.from) - along * along));
        const double slope = shrink / std::sqrt(squared - shrink * shrink);
        s = std::clamp((along - across * slope) / std::sqrt(squared), 0.0, 1.0);
    } else if (shrink < 0) {
        s = 1;
    }
    const double radius = capsule.from_radius - s * shrink;
    return length(p - capsule.from - s * axis) <= radius;
}

TEST(Capsules, HoldTheirVolumeInAnyDirection) {
    const std::vector<Capsule> shapes = {{{0, 0, 0}, {9, 0, 0}, 2, 2},       {{0, 0, 0}, {0, 9, 1}, 3, 0.5},
                                         {{1, 2, 3}, {4, 9, -5}, 0.7, 2.2},  {{0, 0, 0}, {0, 0, 0}, 3, 3},
                                         {{0, 0, 0}, {1, 0, 0}, 4, 2},       {{0, 0, 0}, {5, 0, 0}, 4, 0.1},
                                         {{0, 0, 0}, {40, 30, 20}, 0.2, 0.2}};
    for (const Capsule& shape : shapes) {
        EXPECT_NEAR(voxel_volume({shape}, 0.25) / capsule_volume(shape), 1, 0.003)
            << shape.to.x << ' ' << shape.to_radius;
    }
}

TEST(Capsules, TheVolumeFormulaIsThatOfAMonteCarloCount) {
    const Capsule shape = {{0, 0, 0}, {3, 2, 1}, 2, 0.8};
    Rng random(5, 5, 5);
    constexpr int kPoints = 400000;
    int count = 0;
    for (int i = 0; i < kPoints; ++i) {
        const auto at = [&](double low, double high) { return low + (high - low) * random.uniform(); };
        const double x = at(-2, 4);
        const double y = at(-2, 3);
        count += inside(shape, {x, y, at(-2, 2)}) ? 1 : 0;
    }
    const double box = 6 * 5 * 4;
    const double share = static_cast<double>(count) / kPoints;
    EXPECT_NEAR(box * share, capsule_volume(shape), 5 * box * std::sqrt(share / kPoints));
}

TEST(Capsules, AreAUnionWhereTheyOverlap) {
    const Capsule one = {{0, 0, 0}, {6, 0, 0}, 2, 1};
    EXPECT_NEAR(voxel_volume({one, one, one}, 0.25), voxel_volume({one}, 0.25), 1e-9);
}

/// A cable of r = 1 um with `points` points, straight or along a wave.
std::vector<Capsule> sampled_cable(int points, double wave_um, double taper) {
    std::vector<Capsule> cable;
    const auto at = [&](int i) {
        const double s = static_cast<double>(i) / (points - 1);
        return Vec3{100 * s, wave_um * std::sin(20 * s), wave_um * std::cos(15 * s)};
    };
    const auto radius = [&](int i) { return 1 - taper * static_cast<double>(i) / (points - 1); };
    for (int i = 1; i < points; ++i)
        cable.push_back({at(i - 1), at(i), radius(i - 1), radius(i)});
    return cable;
}

TEST(Capsules, FinelySampledCablesCostByVoxelsAndHoldTheSame) {
    VoxelizeSettings settings;
    settings.voxel_size_um = 0.2;
    NoProgress progress;
    const double straight = voxel_volume(sampled_cable(2, 0, 0), 0.2);
    const auto fine = voxelize_capsules(sampled_cable(100'000, 0, 0), settings, progress).report;
    EXPECT_EQ(fine.merged_points, 99'998U);
    EXPECT_NEAR(fine.volume_um3 / straight, 1, 1e-4);
    const double tapered = voxel_volume(sampled_cable(2, 0, 0.8), 0.2);
    EXPECT_NEAR(voxel_volume(sampled_cable(20'000, 0, 0.8), 0.2) / tapered, 1, 1e-4);
    const auto wave = voxelize_capsules(sampled_cable(20'000, 3, 0.3), settings, progress).report;
    EXPECT_GT(wave.merged_points, 19'000U);
    EXPECT_NEAR(wave.volume_um3 / voxel_volume(sampled_cable(1'500, 3, 0.3), 0.2), 1, 1e-4);
}

TEST(Capsules, MergingKeepsWhatIsNotTheSameShape) {
    VoxelizeSettings settings;
    settings.voxel_size_um = 0.5;
    NoProgress progress;
    const auto merged = [&](const std::vector<Capsule>& capsules) {
        return voxelize_capsules(capsules, settings, progress).report.merged_points;
    };
    EXPECT_EQ(merged({{{0, 0, 0}, {5, 0, 0}, 1, 1}, {{5, 0, 0}, {9, 0, 0}, 1, 1}}), 1U);
    EXPECT_EQ(merged({{{0, 0, 0}, {5, 0, 0}, 1, 1.1}, {{5, 0, 0}, {9, 0, 0}, 1.1, 1}}), 0U) << "a bulge";
    EXPECT_EQ(merged({{{0, 0, 0}, {5, 0.1, 0}, 1, 1}, {{5, 0.1, 0}, {9, 0, 0}, 1, 1}}), 0U) << "a bend";
    EXPECT_EQ(merged({{{0, 0, 0}, {9, 0, 0}, 1, 1}, {{9, 0, 0}, {5, 0, 0}, 1, 1}}), 0U) << "the way back";
    // A ring has no beginning; a fork goes on in one of its branches.
    EXPECT_EQ(merged({{{0, 0, 0}, {5, 0, 0}, 1, 1}, {{5, 0, 0}, {0, 5, 0}, 1, 1}, {{0, 5, 0}, {0, 0, 0}, 1, 1}}), 0U);
    const std::vector<Capsule> fork = {
        {{0, 0, 0}, {5, 0, 0}, 1, 1}, {{5, 0, 0}, {5, 8, 0}, 1, 1}, {{5, 0, 0}, {9, 0, 0}, 1, 1}};
    EXPECT_NEAR(voxel_volume(fork, 0.25), voxel_volume({fork[2], fork[0], fork[1]}, 0.25), 1e-6);
}

TEST(Morphology, SomaRules) {
    const CapsuleNeuron ball = swc("# one point\n1 1 0 0 0 5 -1\n2 3 10 0 0 1 1\n3 3 20 0 0 1 2\n");
    EXPECT_EQ(ball.report.soma, "ball");
    // The dendrite starts with its own radius at the centre of the soma.
    const Capsule& dendrite =
        *std::find_if(ball.capsules.begin(), ball.capsules.end(), [](const Capsule& c) { return c.to.x == 10; });
    EXPECT_EQ(dendrite.from_radius, 1);
    const CapsuleNeuron three = swc("1 1 0 0 0 5 -1\n2 1 0 5 0 5 1\n3 1 0 -5 0 5 1\n4 3 20 0 0 1 1\n");
    ASSERT_EQ(three.capsules.size(), 2U);
    EXPECT_NEAR(capsule_volume(three.capsules[0]), 4 * pi / 3 * 125, 1e-9);
    const CapsuleNeuron all = swc("1 1 0 0 0 1 -1\n2 1 10 0 0 1 1\n3 1 20 0 0 1 2\n4 1 30 0 0 1 3\n");
    EXPECT_EQ(all.capsules.size(), 3U);
    EXPECT_TRUE(all.report.soma.starts_with("none (every point"));
    EXPECT_EQ(swc("1 3 0 0 0 1 -1\n2 3 5 0 0 1 1\n").report.soma, "none");
}

TEST(Morphology, SpinesAndAxonsAreAsThickAtTheirFootAsTheyAre) {
    const CapsuleNeuron cell =
        swc("1 3 0 0 0 2 -1\n2 3 50 0 0 2 1\n3 5 50 3 0 0.3 2\n4 5 50 4 0 0.6 3\n5 2 50 0 9 0.4 2\n");
    EXPECT_EQ(cell.report.spines, 1U);
    const auto from_radius = [&](const Vec3& to) {
        return std::find_if(cell.capsules.begin(), cell.capsules.end(),
                            [&](const Capsule& c) { return length(c.to - to) < 1e-9; })
            ->from_radius;
    };
    EXPECT_EQ(from_radius({50, 3, 0}), 0.3);
    EXPECT_EQ(from_radius({50, 4, 0}), 0.3);
    EXPECT_EQ(from_radius({50, 0, 9}), 0.4);
    EXPECT_EQ(from_radius({50, 0, 0}), 2);
    // In older files type 5 is a fork, and nothing sprouts.
    EXPECT_EQ(swc("1 0 0 0 0 2 -1\n2 5 5 0 0 1 1\n").capsules[0].from_radius, 2);
}

TEST(Morphology, BrokenFilesAreMendedAndCounted) {
    const CapsuleNeuron radii = swc("1 3 0 0 0 2 -1\n2 3 5 0 0 0 1\n3 3 9 0 0 -1 2\n");
    EXPECT_EQ(radii.report.mended_radii, 2U);
    for (const Capsule& capsule : radii.capsules)
        EXPECT_EQ(capsule.to_radius, 2);
    const CapsuleNeuron orphan = swc("1 3 0 0 0 2 -1\n2 3 5 0 0 1 77\n3 3 9 0 0 1 2\n");
    EXPECT_EQ(orphan.report.missing_parents, 1U);
    EXPECT_EQ(orphan.report.roots, 2U);
    const CapsuleNeuron cycle = swc("1 3 0 0 0 2 3\n2 3 5 0 0 1 1\n3 3 9 0 0 1 2\n");
    EXPECT_EQ(cycle.report.cycles, 1U);
    EXPECT_EQ(cycle.capsules.size(), 2U);
    EXPECT_EQ(swc("1 3 0 0 0 2 1\n2 3 5 0 0 1 1\n").report.cycles, 1U) << "its own parent";
    EXPECT_EQ(swc("1 3 0 0 0 2 -1\n2 3 0 0 0 2 1\n").report.zero_lengths, 1U);
    EXPECT_EQ(swc("1 3 0 0 0 2 -1\n1 3 5 0 0 2 1\n2 3 5 0 0 2 1\n").report.repeated_points, 1U);
    EXPECT_EQ(swc("1 3 0 0 0 2 -1\r\n\n# x\n2 3.0 5 0 0 2 1 extra\n").capsules.size(), 1U);
}

TEST(Morphology, ANeuriteWithoutARadiusNeverTakesTheSomas) {
    const auto radius_at = [](const CapsuleNeuron& cell, double x) {
        return std::find_if(cell.capsules.begin(), cell.capsules.end(), [&](const Capsule& c) { return c.to.x == x; })
            ->to_radius;
    };
    const CapsuleNeuron child = swc("1 1 0 0 0 5 -1\n2 3 6 0 0 -1 1\n3 3 20 0 0 1 2\n");
    EXPECT_EQ(radius_at(child, 6), 1);
    EXPECT_NEAR(voxel_volume(child.capsules, 0.25), 573, 3);
    const CapsuleNeuron other = swc("1 1 0 0 0 5 -1\n2 3 6 0 0 0 1\n3 2 0 9 0 2 1\n4 2 0 20 0 0.5 3\n");
    EXPECT_EQ(radius_at(other, 6), 0.5) << "the least of the file's neurites";
    const CapsuleNeuron type = swc("1 2 0 0 0 5 -1\n2 3 6 0 0 0 1\n3 3 9 0 0 2 2\n");
    EXPECT_EQ(radius_at(type, 6), 2) << "a child of its type before a parent of another";
    const CapsuleNeuron nothing = swc("1 1 0 0 0 5 -1\n2 3 6 0 0 0 1\n");
    EXPECT_EQ(radius_at(nothing, 6), 5) << "there is no other radius";
    const CapsuleNeuron backwards = swc("1 3 20 0 0 0 2\n2 3 9 0 0 0 3\n3 3 5 0 0 2 4\n4 1 0 0 0 5 -1\n");
    EXPECT_EQ(radius_at(backwards, 20), 2) << "children before their parents";
}

TEST(Morphology, HopelessFilesAreRefusedWithAReason) {
    const auto message = [](const auto& read) {
        try {
            read();
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_NE(message([] { swc(""); }).find("is empty"), std::string::npos);
    EXPECT_NE(message([] { swc("# nothing\n"); }).find("no points"), std::string::npos);
    EXPECT_NE(message([] { swc("1 3 0 0 0\n"); }).find("m.swc:1: a number is missing"), std::string::npos);
    EXPECT_NE(message([] { swc("1 3 0 zero 0 1 -1\n"); }).find("\"zero\" is not a number"), std::string::npos);
    EXPECT_NE(message([] { swc("1 3 0 0 0 0 -1\n"); }).find("radius above zero"), std::string::npos);
    EXPECT_NE(message([] { asc("hello"); }).find("not a Neurolucida"), std::string::npos);
    EXPECT_NE(message([] { asc("((Dendrite) (0 0 0 1) (1 0 0 1)"); }).find("truncated"), std::string::npos);
    EXPECT_NE(message([] { asc(std::string(200000, '(')); }), "");
}

TEST(Morphology, ReadsNeurolucidaTreesContoursAndSpines) {
    const CapsuleNeuron cell =
        asc("; a comment\n(\"Cell Body\" (Color Red) (CellBody) (5 0 0 0.1) (0 4 0 0.1) (-5 0 0 0.1) (0 -4 0 0.1))\n"
            "((Color Blue) (Dendrite) (0 0 0 2) (10 0 0 2) <(10 1.5 0 0.4)>\n"
            " ( (20 5 0 1) (30 9 0 1) Normal | (20 -5 0 1 S2) ( (25 -9 0 1) | (25 -1 0 1) High ) ) )\n");
    EXPECT_EQ(cell.report.points, 7U);
    EXPECT_EQ(cell.report.branch_points, 2U);
    EXPECT_EQ(cell.report.spines, 1U);
    EXPECT_EQ(cell.report.soma, "contour");
    EXPECT_EQ(cell.report.roots, 1U);
    const auto wide =
        std::count_if(cell.capsules.begin(), cell.capsules.end(), [](const Capsule& c) { return c.to_radius > 2; });
    EXPECT_GT(wide, 5) << "the soma is made of discs";
}

/// A circle of the plane z, of a ball of r = 10 um, as points `x y z`.
std::vector<Vec3> circle_of_ball(double z, int points) {
    std::vector<Vec3> circle;
    for (int i = 0; i < points; ++i) {
        const double angle = 2 * pi * i / points;
        const double r = std::sqrt(100 - z * z);
        circle.push_back({r * std::cos(angle), r * std::sin(angle), z});
    }
    return circle;
}

std::string asc_contour(const std::vector<Vec3>& points) {
    std::string text = "(\"Cell Body\" (CellBody)";
    for (const Vec3& p : points)
        text += " (" + std::to_string(p.x) + ' ' + std::to_string(p.y) + ' ' + std::to_string(p.z) + " 0.1)";
    return text + ")\n";
}

Bounds box_of(const std::vector<Capsule>& capsules) {
    Bounds box;
    for (const Capsule& capsule : capsules)
        box.add(capsule_bounds(capsule));
    return box;
}

TEST(Soma, AContourIsTheBallOfItsAreaOrTheSpheroidOfItsProportions) {
    const CapsuleNeuron square = asc(asc_contour({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}}));
    EXPECT_NEAR(voxel_volume(square.capsules, 0.25) / (4 * pi / 3 * std::pow(100 / pi, 1.5)), 1, 0.003);
    std::vector<Vec3> ellipse = circle_of_ball(0, 100);
    for (Vec3& p : ellipse)
        p = {2 * p.x, 5, p.y / 2};
    const auto body = asc(asc_contour(ellipse)).capsules;
    EXPECT_NEAR(voxel_volume(body, 0.25) / (4 * pi / 3 * 20 * 5 * 5), 1, 0.01);
    EXPECT_NEAR(box_of(body).max.x, 20, 0.1);
    EXPECT_NEAR(box_of(body).min.y, 0, 0.1);
    EXPECT_TRUE(asc(asc_contour({{0, 0, 0}, {5, 0, 0}, {9, 0, 0}}) + "((Dendrite) (0 0 0 2) (9 0 0 2))")
                    .report.soma.starts_with("none"));
}

TEST(Soma, ContoursOnTopOfEachOtherAreOneBody) {
    std::string text;
    for (const double z : {4.0, -8.0, 0.0, 8.0, -4.0})
        text += asc_contour(circle_of_ball(z, 60));
    const CapsuleNeuron cell = asc(text);
    EXPECT_EQ(cell.report.soma, "contours");
    EXPECT_NEAR(voxel_volume(cell.capsules, 0.25) / (4 * pi / 3 * 1000), 1, 0.02);
    const Bounds box = box_of(cell.capsules);
    EXPECT_NEAR(box.max.z, 10, 1e-6);
    EXPECT_NEAR(box.min.z, -10, 1e-6);
    EXPECT_NEAR(box.max.x, 10, 0.05);
    // Two cells side by side stay two.
    std::vector<Vec3> beside = circle_of_ball(0, 60);
    for (Vec3& p : beside)
        p = p + Vec3{50, 0, 2};
    EXPECT_NEAR(
        voxel_volume(asc(asc_contour(circle_of_ball(0, 60)) + asc_contour(beside)).capsules, 0.5) / (8 * pi / 3 * 1000),
        1, 0.01);
}

TEST(Soma, SlicesHoldTheirVolumeInAnyDirection) {
    for (const Vec3& normal : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, normalized(Vec3{1, 2, -2})}) {
        // Leaning: its discs stay across the normal.
        const Vec3 aside = normalized(cross(normal, Vec3{0.3, 0.5, 0.9}));
        const Capsule slice = {{1, 2, 3}, Vec3{1, 2, 3} + 5.0 * normal + 2.0 * aside, 4, 1.5, normal};
        EXPECT_NEAR(capsule_volume(slice), 5 * pi * (16 + 6 + 2.25) / 3, 1e-9);
        EXPECT_NEAR(voxel_volume({slice}, 0.25) / capsule_volume(slice), 1, 0.003) << normal.x;
    }
}

TEST(Soma, ARingOfThinSwcPointsIsItsContour) {
    std::string text;
    int number = 0;
    for (const Vec3& p : circle_of_ball(0, 20)) {
        text += std::to_string(number + 1) + " 1 " + std::to_string(p.x) + ' ' + std::to_string(p.y) + " 0 0.1 " +
                std::to_string(number == 0 ? -1 : number) + '\n';
        ++number;
    }
    const CapsuleNeuron ring = swc(text + "21 3 30 0 0 1 1\n");
    EXPECT_TRUE(ring.report.soma.starts_with("outline (20 ")) << ring.report.soma;
    const double area = 10 * 100 * std::sin(2 * pi / 20);
    const double dendrite = pi * 20 + 2 * pi / 3;
    EXPECT_NEAR(voxel_volume(ring.capsules, 0.25), 4 * pi / 3 * std::pow(area / pi, 1.5) + dendrite, 15);
    // Thick points, or a row that is far from closing, are segments.
    EXPECT_EQ(swc("1 1 0 0 0 3 -1\n2 1 5 0 0 3 1\n3 1 5 5 0 3 2\n4 1 0 5 0 3 3\n5 3 9 9 0 1 3\n").report.soma,
              "segments");
    EXPECT_EQ(swc("1 1 0 0 0 .1 -1\n2 1 5 0 0 .1 1\n3 1 9 4 0 .1 2\n4 1 14 4 0 .1 3\n5 3 20 9 0 1 4\n").report.soma,
              "segments");
}

// Specimens beside the project; skipped without.
TEST(Morphology, ACorticalCellHoldsTheVolumeOfItsUnion) {
    const auto file = std::filesystem::path(FLUOVOX_SHARED_DIR) / "specimens/swc/allen_Scnn1a_L4pyr_328933585.swc";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
    const auto capsules = parse_morphology(load_bytes(file), ".swc", file.string()).capsules;
    // Independent: points at random in capsules drawn by volume, each weighed by how many capsules hold it.
    double sum = 0;
    std::vector<double> until;
    for (const Capsule& capsule : capsules)
        until.push_back(sum += capsule_volume(capsule));
    Rng random(9, 9, 9);
    constexpr int kPoints = 20000;
    double mean = 0;
    double mean_square = 0;
    for (int i = 0; i < kPoints; ++i) {
        const auto pick = std::upper_bound(until.begin(), until.end(), random.uniform() * sum) - until.begin();
        const Capsule& capsule =
            capsules[static_cast<std::size_t>(std::min<std::ptrdiff_t>(pick, std::ssize(capsules) - 1))];
        Vec3 point;
        do {
            for (int axis = 0; axis < 3; ++axis) {
                const double low =
                    std::min(capsule.from[axis] - capsule.from_radius, capsule.to[axis] - capsule.to_radius);
                const double high =
                    std::max(capsule.from[axis] + capsule.from_radius, capsule.to[axis] + capsule.to_radius);
                point[axis] = low + (high - low) * random.uniform();
            }
        } while (!inside(capsule, point));
        const auto holders =
            std::count_if(capsules.begin(), capsules.end(), [&](const Capsule& c) { return inside(c, point); });
        mean += 1.0 / static_cast<double>(holders) / kPoints;
        mean_square += 1.0 / static_cast<double>(holders * holders) / kPoints;
    }
    const double sigma = std::sqrt((mean_square - mean * mean) / kPoints);
    EXPECT_LT(5 * sigma / mean, 0.02);
    testing::expect_volume("cortical cell from SWC, against Monte Carlo", voxel_volume(capsules, 0.2), sum * mean,
                           std::max(0.01, 5 * sigma / mean));
}

TEST(Morphology, EverySpecimenIsReadOrRefused) {
    const auto folder = std::filesystem::path(FLUOVOX_SHARED_DIR) / "specimens";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
    std::size_t mended = 0;
    std::size_t read = 0;
    for (const char* kind : {"swc", "asc"}) {
        for (const auto& entry : std::filesystem::directory_iterator(folder / kind)) {
            const auto& path = entry.path();
            const CapsuleNeuron cell = parse_morphology(load_bytes(path), path.extension().string(), path.string());
            EXPECT_GT(cell.capsules.size(), 100U) << path;
            mended += cell.report.mended_radii;
            ++read;
        }
    }
    EXPECT_EQ(read, 10U);
    EXPECT_EQ(mended, 815U);
}

}  // namespace
}  // namespace fluovox
