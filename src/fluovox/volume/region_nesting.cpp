#include "fluovox/volume/region_nesting.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace fluovox {
namespace {

// Points of [0, 1)^2 that fill it evenly (Roberts' R2 sequence).
std::array<double, 2> spread(int i) {
    const double x = 0.5 + 0.7548776662466927 * i;
    const double y = 0.5 + 0.5698402909980532 * i;
    return {x - std::floor(x), y - std::floor(y)};
}

// Points just under the surface of a finite region.
std::vector<Vec3> points_under_surface(const Region& region) {
    constexpr int kPoints = 2000;
    constexpr double kShrink = 1 - 1e-6;
    const Bounds box = bounds_of(region);
    const Vec3 center = box.center();
    std::vector<Vec3> points;
    for (int i = 0; i < kPoints; ++i) {
        const auto [u, v] = spread(i);
        const double z = 1 - 2 * u;
        const double r = std::sqrt(1 - z * z);
        const double angle = 2 * std::numbers::pi * v;
        Vec3 direction{r * std::cos(angle), r * std::sin(angle), z};
        // Stretched to the proportions of the box, so that flat regions get points all over their faces.
        direction = normalized({direction.x * box.size().x, direction.y * box.size().y, direction.z * box.size().z});
        const Interval chord = chord_of(region, {center, direction});
        points.push_back(center + (kShrink * chord.end) * direction);
    }
    return points;
}

enum class Share { None, Some, All };

Share share_inside(const Region& of, const Region& region) {
    std::size_t inside = 0;
    const std::vector<Vec3> points = points_under_surface(of);
    for (const Vec3 p : points)
        inside += contains(region, p) ? 1 : 0;
    return inside == 0 ? Share::None : inside == points.size() ? Share::All : Share::Some;
}

bool finite(const Region& region) {
    const Vec3 size = bounds_of(region).size();
    return std::isfinite(size.x + size.y + size.z);
}

// Slabs along one axis.
bool holds(const SlabRegion& outer, const SlabRegion& inner) {
    return inner.min >= outer.min && inner.max <= outer.max;
}

Nesting nesting(bool a_in_b, bool b_in_a, bool apart) {
    if (a_in_b && b_in_a) return Nesting::Equal;
    if (a_in_b || b_in_a) return a_in_b ? Nesting::FirstInSecond : Nesting::SecondInFirst;
    return apart ? Nesting::Apart : Nesting::Partial;
}

}  // namespace

Nesting nesting_of(const Region& a, const Region& b) {
    const bool everywhere_a = std::holds_alternative<Everywhere>(a);
    const bool everywhere_b = std::holds_alternative<Everywhere>(b);
    if (everywhere_a || everywhere_b) return nesting(everywhere_b, everywhere_a, false);
    const auto* slab_a = std::get_if<SlabRegion>(&a);
    const auto* slab_b = std::get_if<SlabRegion>(&b);
    if (slab_a != nullptr && slab_b != nullptr) {
        if (slab_a->axis != slab_b->axis) return Nesting::Partial;
        return nesting(holds(*slab_b, *slab_a), holds(*slab_a, *slab_b),
                       slab_a->max <= slab_b->min || slab_b->max <= slab_a->min);
    }
    const Share a_in_b = finite(a) ? share_inside(a, b) : Share::None;
    const Share b_in_a = finite(b) ? share_inside(b, a) : Share::None;
    return nesting(a_in_b == Share::All, b_in_a == Share::All, a_in_b == Share::None && b_in_a == Share::None);
}

const char* index_conflict(const Region& a, const Region& b) {
    switch (nesting_of(a, b)) {
        case Nesting::Partial:
            return "overlap in part";
        case Nesting::Equal:
            return "fill the same space";
        default:
            return nullptr;
    }
}

}  // namespace fluovox
