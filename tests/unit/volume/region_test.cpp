#include "fluovox/volume/region.h"

#include "fluovox/core/rng.h"
#include "fluovox/medium/phase_function.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

std::vector<Region> regions() {
    return {BoxRegion{{-3, -1, 0}, {2, 4, 2.5}}, SphereRegion{{0.5, 1, 0}, 2},
            CylinderRegion{{-2, 0, 1}, {1, 3, 0}, 1.2}, SlabRegion{1, -0.5, 2}, SlabRegion{0, 1}};
}

Vec3 random_point(Rng& rng) {
    return {-5 + 10 * rng.uniform(), -5 + 10 * rng.uniform(), -5 + 10 * rng.uniform()};
}

// To the surface along a ray, infinite where it misses.
double distance_along(const Region& region, const Ray& ray) {
    const Interval chord = chord_of(region, ray);
    if (chord.empty()) return kFar;
    double nearest = kFar;
    for (const double t : {chord.begin, chord.end}) {
        if (t >= 0) nearest = std::min(nearest, t);
    }
    return nearest;
}

double nearest_of_many(const Region& region, Vec3 point, Rng& rng) {
    double nearest = kFar;
    for (int i = 0; i < 3000; ++i)
        nearest = std::min(nearest, distance_along(region, {point, sample_isotropic(rng)}));
    return nearest;
}

TEST(Region, ClearanceHoldsNoSurfaceInAnyDirection) {
    Rng rng(1, 0, 0);
    for (const Region& region : regions()) {
        for (int i = 0; i < 60; ++i) {
            const Vec3 point = random_point(rng);
            EXPECT_GE(nearest_of_many(region, point, rng), clearance(region, point) * (1 - 1e-12))
                << "region " << region.index() << ", point " << point.x << " " << point.y << " " << point.z;
        }
    }
}

TEST(Region, InsideTheClearanceReachesTheSurface) {
    Rng rng(2, 0, 0);
    for (const Region& region : regions()) {
        for (int tried = 0, found = 0; found < 20; ++tried) {
            ASSERT_LT(tried, 10000);
            const Vec3 point = random_point(rng);
            if (!contains(region, point)) continue;
            ++found;
            // The nearest of so many directions is off by a few degrees.
            EXPECT_LE(nearest_of_many(region, point, rng), clearance(region, point) * 1.02);
        }
    }
}

TEST(Region, EverywhereIsClear) {
    EXPECT_EQ(clearance(Everywhere{}, {1, 2, 3}), kFar);
}

}  // namespace
}  // namespace fluovox
