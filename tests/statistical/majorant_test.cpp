// The bounds that tracking relies on: never below the trilinear field, and no part of it left out.

#include "fluovox/volume/bound_visitor.h"
#include "fluovox/volume/majorant_walk.h"
#include "fluovox/volume/sparse_grid.h"

#include "random_grids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using testing::random_affine;
using testing::random_grid;
using testing::random_integer;
using testing::random_ray;

constexpr double kEnd_um = 1500;

// Where tracking looks for collisions, and the bound by which it keeps them.
struct Stretch {
    double begin = 0, end = 0;
    std::function<double(double)> bound;  // at t; with the random bits that keep most
    std::function<double(double)> mean;   // the same on average over the random bits
};

std::vector<Stretch> stretches_by_walk(const SparseGrid& grid, const Ray& ray) {
    std::vector<Stretch> stretches;
    MajorantWalk walk(grid, ray, {0, kEnd_um});
    for (MajorantWalk::Segment segment; walk.next(segment);) {
        const auto bound = [most = segment.bound](double) { return most; };
        stretches.push_back({segment.begin, segment.end, bound, bound});
    }
    return stretches;
}

// A tracking that writes down where it is led to and never ends.
class Notes {
public:
    explicit Notes(std::vector<Stretch>& stretches) : stretches_(&stretches) {}

    static double rest() { return 0; }
    void set_rest(double /*rest*/) {}
    template <class MakeTap>
    bool look(double begin, double end, double bound, const MakeTap& make_tap) {
        return look_inside(begin, end, bound, make_tap());
    }
    template <class Tap>
    bool look_inside(double begin, double end, double bound, const Tap& tap) {
        const auto local = [tap, bound](double t) { return tap.local_bound(tap.at(t), bound, 0); };
        const auto mean = [tap, bound](double t) {
            int kept = 0;
            for (std::uint64_t highest = 0; highest < 256; ++highest)
                kept += tap.local_bound(tap.at(t), bound, highest << 56U) > 0 ? 1 : 0;
            return bound * kept / 256;
        };
        stretches_->push_back({begin, end, local, mean});
        return false;
    }

private:
    std::vector<Stretch>* stretches_;
};

// Ways along a ray. The taps of the visitors' stretches need them.
struct Ways {
    std::vector<std::vector<Stretch>> all;
    std::vector<std::unique_ptr<BoundVisitor>> visitors;
};

Ways all_ways(const SparseGrid& grid, const Ray& ray) {
    Ways ways;
    ways.all.push_back(stretches_by_walk(grid, ray));
    if (!grid.has_directory()) return ways;
    // Few tentative collisions in a brick, some, and many.
    for (const double coefficient : {0.02, 0.2, 5.0}) {
        ways.visitors.push_back(std::make_unique<BoundVisitor>(grid, ray, Interval{0, kEnd_um}, coefficient));
        Notes notes(ways.all.emplace_back());
        ways.visitors.back()->run(notes);
    }
    return ways;
}

struct Findings {
    int points = 0;      // looked at, with a positive field
    int above = 0;       // the field is above the bound
    int unfair = 0;      // collisions are kept with another probability than the bound's share
    int uncovered = 0;   // the field is positive where there is no segment
    int disordered = 0;  // segments that are empty, overlap or go back
};

void look_along(const SparseGrid& grid, const Ray& ray, const std::vector<Stretch>& segments, double trust, Rng& rng,
                Findings& found) {
    double before = 0;
    for (const auto& s : segments) {
        if (!(s.begin < s.end) || s.begin < before - 1e-9) ++found.disordered;
        before = s.end;
    }
    std::size_t next = 0;
    for (int i = 0; i < 3000; ++i) {
        const double t = kEnd_um * (i + rng.uniform()) / 3000;
        while (next < segments.size() && segments[next].end <= t)
            ++next;
        const double field = grid.trilinear(ray.at(t));
        if (field < 1e-9) continue;  // rays in the plane of the outermost voxels see rounding only
        ++found.points;
        const bool covered = next < segments.size() && t >= segments[next].begin;
        if (!covered) {
            ++found.uncovered;
            continue;
        }
        const double bound = segments[next].bound(t);
        if (field > trust * bound * (1 + 1e-9)) ++found.above;
        if (i % 50 == 0 && std::abs(segments[next].mean(t) - trust * bound) > 1e-12 * bound) ++found.unfair;
    }
}

// Looks at points all along random rays. `trust`: the bounds are multiplied by it first.
Findings look(float background, double trust) {
    Findings found;
    for (std::uint64_t g = 0; g < 20; ++g) {
        Rng rng(11, g, background > 0 ? 1 : 0);
        const SparseGrid grid = random_grid(rng, g % 4 == 0 ? Affine{} : random_affine(rng), background);
        for (int r = 0; r < 60; ++r) {
            const Ray ray = random_ray(grid, r, rng);
            const Ways ways = all_ways(grid, ray);
            for (const auto& segments : ways.all)
                look_along(grid, ray, segments, trust, rng, found);
        }
    }
    return found;
}

TEST(Majorants, AreAboveTheTrilinearFieldAlongEveryRay) {
    const Findings found = look(0, 1);
    EXPECT_GT(found.points, 20000);
    EXPECT_EQ(found.above, 0);
    EXPECT_EQ(found.unfair, 0);
    EXPECT_EQ(found.uncovered, 0);
    EXPECT_EQ(found.disordered, 0);
}

TEST(Majorants, HoldWithABackgroundToo) {
    const Findings found = look(0.4F, 1);
    EXPECT_GT(found.points, 1000000);
    EXPECT_EQ(found.above, 0);
    EXPECT_EQ(found.unfair, 0);
    EXPECT_EQ(found.uncovered, 0);
    EXPECT_EQ(found.disordered, 0);
}

TEST(Majorants, OnePercentLowerWouldNotDo) {
    const Findings lower = look(0, 0.99);
    EXPECT_GT(lower.above, 100);
    EXPECT_GT(lower.unfair, 100);
    EXPECT_GT(look(0.4F, 0.99).above, 100);
}

// Few bricks in a box so tall that its columns take several words of the directory.
std::vector<Voxel> far_apart(Rng& rng) {
    std::vector<Voxel> bricks;
    for (int i = 0; i < 60; ++i)
        bricks.push_back({random_integer(rng, -6, 6), random_integer(rng, -6, 6), 3 * i - 90});
    return bricks;
}

SparseGrid grid_of(const std::vector<Voxel>& bricks, const Affine& world_from_index, Rng& rng) {
    SparseGridBuilder builder(0);
    for (const Voxel brick : bricks) {
        std::array<float, 512> values{};
        const double filled = rng.uniform() < 0.5 ? 0.3 : 0.02;  // all cells of 2^3 have something in them, or few
        for (float& value : values)
            value = rng.uniform() < filled ? static_cast<float>(rng.uniform()) : 0;
        builder.add_brick({8 * brick.x, 8 * brick.y, 8 * brick.z}, values.data());
    }
    return std::move(builder).finish(world_from_index, 1);
}

// Through two of the bricks, or along z through one.
Ray ray_through(const SparseGrid& grid, const std::vector<Voxel>& bricks, int number, Rng& rng) {
    const auto any = [&] {
        const Voxel brick = bricks[static_cast<std::size_t>(random_integer(rng, 0, static_cast<int>(bricks.size())))];
        return grid.world_from_index().point(
            {8 * (brick.x + rng.uniform()), 8 * (brick.y + rng.uniform()), 8 * (brick.z + rng.uniform())});
    };
    const Vec3 from = any();
    const double sign = number % 2 == 0 ? 1 : -1;
    const Vec3 direction =
        number % 3 == 0 ? grid.world_from_index().direction({0, 0, sign}) : any() - from + Vec3{1e-3, 0, 0};
    return {from - 700 * normalized(direction), normalized(direction)};
}

Findings look_far_apart(double trust) {
    Findings found;
    for (std::uint64_t g = 0; g < 12; ++g) {
        Rng rng(15, g, 0);
        const std::vector<Voxel> bricks = far_apart(rng);
        const SparseGrid grid = grid_of(bricks, g % 2 == 0 ? Affine{} : random_affine(rng), rng);
        EXPECT_TRUE(grid.has_directory());
        for (int r = 0; r < 40; ++r) {
            const Ray ray = ray_through(grid, bricks, r, rng);
            const Ways ways = all_ways(grid, ray);
            for (const auto& segments : ways.all)
                look_along(grid, ray, segments, trust, rng, found);
        }
    }
    return found;
}

TEST(Majorants, AreAboveTheFieldOfFewBricksFarApart) {
    const Findings found = look_far_apart(1);
    EXPECT_GT(found.points, 20000);
    EXPECT_EQ(found.above, 0);
    EXPECT_EQ(found.unfair, 0);
    EXPECT_EQ(found.uncovered, 0);
    EXPECT_EQ(found.disordered, 0);
    EXPECT_GT(look_far_apart(0.99).unfair, 100);
}

// Asks the taps along a ray for values. `shift`: of the voxel that they should have, along x.
struct Tapped {
    const SparseGrid* grid = nullptr;
    Rng* rng = nullptr;
    int shift = 0;
    int values = 0, positive = 0, wrong = 0;

    static double rest() { return 0; }
    void set_rest(double /*rest*/) {}
    template <class MakeTap>
    bool look(double begin, double end, double bound, const MakeTap& make_tap) {
        return look_inside(begin, end, bound, make_tap());
    }
    template <class Tap>
    bool look_inside(double begin, double end, double /*bound*/, const Tap& tap) {
        for (int i = 0; i < 20; ++i) {
            const auto place = tap.at(begin + rng->uniform() * (end - begin));
            const std::uint64_t bits = rng->bits();
            const Voxel voxel = tap.voxel(place, bits);
            const auto truth = static_cast<double>(grid->value_from_root({voxel.x + shift, voxel.y, voxel.z}));
            ++values;
            positive += truth > 0 ? 1 : 0;
            wrong += tap.value(place, bits) == truth ? 0 : 1;
        }
        return false;
    }
};

TEST(Taps, GiveTheValuesOfTheirVoxelsExactly) {
    for (const int shift : {0, 1}) {  // one voxel off must be noticed
        int positive = 0;
        int wrong = 0;
        for (std::uint64_t g = 0; g < 8; ++g) {
            Rng rng(16, g, 0);
            const std::vector<Voxel> bricks = far_apart(rng);
            const SparseGrid grid = g % 2 == 0 ? grid_of(bricks, {}, rng) : random_grid(rng, random_affine(rng), 0);
            ASSERT_TRUE(grid.has_directory());
            for (int r = 0; r < 40; ++r) {
                const Ray ray = g % 2 == 0 ? ray_through(grid, bricks, r, rng) : random_ray(grid, r, rng);
                for (const double coefficient : {0.02, 5.0}) {
                    Tapped tapped{&grid, &rng, shift};
                    BoundVisitor(grid, ray, {0, kEnd_um}, coefficient).run(tapped);
                    positive += tapped.positive;
                    wrong += tapped.wrong;
                }
            }
        }
        EXPECT_GT(positive, 5000);
        if (shift == 0) {
            EXPECT_EQ(wrong, 0);
        } else {
            EXPECT_GT(wrong, 5000);
        }
    }
}

// Goes past everything and knows how much that was, by the bounds.
struct Passing {
    static constexpr double kAll = 1000;
    double left = kAll;

    double rest() const { return left; }
    void set_rest(double rest) { left = rest; }
    template <class MakeTap>
    static bool look(double /*begin*/, double /*end*/, double /*bound*/, const MakeTap& /*make_tap*/) {
        return false;
    }
    template <class Tap>
    static bool look_inside(double /*begin*/, double /*end*/, double /*bound*/, const Tap& /*tap*/) {
        return false;
    }
};

double depth_of_bounds(const SparseGrid& grid, const Ray& ray) {
    Passing passing;
    constexpr double kLittleInABrick = 0.05;
    BoundVisitor(grid, ray, {0, kEnd_um}, kLittleInABrick).run(passing);
    return Passing::kAll - passing.left;
}

// Along x or z, in a plane between bricks or a little aside.
Ray ray_between(Voxel brick, int number, double aside) {
    const double along = number % 2 == 0 ? 1 : -1;
    const double across = std::array{0.0, -0.0, 1e-19, -1e-19}[static_cast<std::size_t>(number / 2 % 4)];
    const Vec3 corner{8.0 * brick.x, 8.0 * brick.y, 8.0 * brick.z};
    if (number % 16 < 8) return {corner + Vec3{-300 * along, aside, 2.7}, {along, across, 0}};
    return {corner + Vec3{aside, 3.3, -300 * along}, {across, 0, along}};
}

// Which side of the plane it takes is open, but no more.
TEST(Majorants, AreThoseOfOneSideForARayBetweenBricks) {
    Rng rng(17, 0, 0);
    const std::vector<Voxel> bricks = far_apart(rng);
    const SparseGrid sparse = grid_of(bricks, {}, rng);
    const SparseGrid dense = random_grid(rng, {}, 0);
    int positive = 0;
    for (int n = 0; n < 3000; ++n) {
        const bool is_sparse = n / 16 % 2 == 0;
        const Voxel brick = is_sparse ? bricks[static_cast<std::size_t>(n) / 32 % bricks.size()]
                                      : Voxel{n % 5 - 2, n % 7 - 3, n % 3 - 1};
        const auto depth = [&](double aside) {
            return depth_of_bounds(is_sparse ? sparse : dense, ray_between(brick, n, aside));
        };
        const double found = depth(0);
        const double off = std::min(std::abs(found - depth(1e-9)), std::abs(found - depth(-1e-9)));
        EXPECT_LT(off, 1e-6) << "ray " << n << ": " << found;
        positive += found > 0 ? 1 : 0;
    }
    EXPECT_GT(positive, 500);
}

TEST(Majorants, AreNoneWhereThereIsNothing) {
    // A lone brick of ones in a corner of its node: a bound of one on the whole node would be right, and slow.
    const SparseGrid grid = SparseGrid::from_function({0, 0, 0}, {8, 8, 8}, {}, [](Voxel) { return 1.0; });
    const Ray ray{{-50, 3.5, 3.5}, {1, 0, 0}};
    for (const auto& segments : all_ways(grid, ray).all) {
        double covered = 0;
        for (const auto& s : segments)
            covered += s.end - s.begin;
        EXPECT_LE(covered, 16);  // its own brick and the one that sees it by interpolation
        EXPECT_GE(covered, 9);
    }
    EXPECT_TRUE(grid.has_directory());
}

TEST(Majorants, AGridOfZerosHasNoneAndABareBackgroundOne) {
    const SparseGrid zeros = SparseGrid::from_function({0, 0, 0}, {20, 20, 20}, {}, [](Voxel) { return 0.0; });
    const SparseGrid everywhere = SparseGridBuilder(0.5F).finish({}, 0);
    for (const Ray& ray : {Ray{{-50, 3.5, 3.5}, {1, 0, 0}}, Ray{{1, 2, 3}, {0.6, 0, -0.8}}}) {
        MajorantWalk::Segment segment;
        EXPECT_FALSE(MajorantWalk(zeros, ray, {0, 1000}).next(segment));
        MajorantWalk walk(everywhere, ray, {0, 1000});
        ASSERT_TRUE(walk.next(segment));
        EXPECT_EQ(segment.begin, 0);
        EXPECT_EQ(segment.end, 1000);
        EXPECT_EQ(segment.bound, 0.5);
        EXPECT_FALSE(walk.next(segment));
    }
}

// Integral of the trilinear field by small steps through each segment, against the same without the segments.
TEST(Majorants, LoseNoAmountOfDye) {
    Rng rng(12, 0, 0);
    const SparseGrid grid = random_grid(rng, random_affine(rng), 0);
    double all = 0;
    double in_segments = 0;
    for (int r = 0; r < 200; ++r) {
        const Ray ray = random_ray(grid, r, rng);
        constexpr double kStep = 0.05;
        for (double t = 0.5 * kStep; t < kEnd_um; t += kStep)
            all += kStep * grid.trilinear(ray.at(t));
        const Ways ways = all_ways(grid, ray);
        for (const auto& s : ways.all.back()) {
            const int steps = static_cast<int>(std::ceil((s.end - s.begin) / kStep));
            const double step = (s.end - s.begin) / steps;
            for (int i = 0; i < steps; ++i)
                in_segments += step * grid.trilinear(ray.at(s.begin + (i + 0.5) * step));
        }
    }
    EXPECT_GT(all, 100);
    EXPECT_NEAR(in_segments / all, 1, 1e-4);
}

// Values of 16 bits that were steps of the largest in their brick would be 7 % off beside one 10^4 times larger.
TEST(PackedValues, KeepTheirPrecisionBesideMuchLargerOnes) {
    for (const double ratio : {2.0, 256.0, 1e4, 1e9}) {
        const auto value_of = [&](Voxel v) {
            const double u = Rng(14, static_cast<std::uint64_t>(64 * v.x + 8 * v.y + v.z), 0).uniform();
            return v.x % 4 == 0 && v.y % 4 == 0 && v.z % 4 == 0 ? ratio : 1 + u;
        };
        const SparseGrid grid = SparseGrid::from_function({0, 0, 0}, {8, 8, 8}, {}, value_of);
        const double precision = ratio <= 2 ? 0x1.0p-17 : ratio <= 256 ? 0x1.0p-14 : 0x1.0p-12;
        double most = 0;
        for (int i = 0; i < 512; ++i) {
            const Voxel v{i >> 6, (i >> 3) & 7, i & 7};
            const auto truth = static_cast<double>(static_cast<float>(value_of(v)));
            most = std::max(most, std::abs(static_cast<double>(grid.value(v)) / truth - 1));
        }
        EXPECT_LE(most, precision) << ratio;
        EXPECT_GT(most, 0.01 * precision) << ratio;
        EXPECT_EQ(grid.max(), ratio);
    }
}

TEST(StochasticTap, AveragesToTheTrilinearField) {
    Rng rng(13, 0, 0);
    const SparseGrid grid = random_grid(rng, random_affine(rng), 0.25F);
    int tested = 0;
    int failing_twins = 0;
    for (int i = 0; i < 4000 && tested < 40; ++i) {
        const Vec3 index{120 * (rng.uniform() - 0.5), 120 * (rng.uniform() - 0.5), 120 * (rng.uniform() - 0.5)};
        const double truth = grid.trilinear(grid.world_from_index().point(index));
        double sum = 0;
        double squares = 0;
        constexpr int kTaps = 20000;
        for (int k = 0; k < kTaps; ++k) {
            const auto value = static_cast<double>(grid.tap(index, rng.bits()));
            sum += value;
            squares += value * value;
        }
        const double mean = sum / kTaps;
        const double error = std::sqrt(std::max(0.0, squares / kTaps - mean * mean) / kTaps);
        if (error <= 1e-9) {
            EXPECT_NEAR(mean, truth, 1e-6);
            continue;
        }
        ++tested;
        EXPECT_LT(std::abs(mean - truth), 5 * error);
        // Half a voxel off, the commonest mistake.
        const double shifted = grid.trilinear(grid.world_from_index().point(index + Vec3{0.5, 0, 0}));
        failing_twins += std::abs(mean - shifted) > 5 * error ? 1 : 0;
    }
    EXPECT_EQ(tested, 40);
    EXPECT_GT(failing_twins, 30);
}

}  // namespace
}  // namespace fluovox
