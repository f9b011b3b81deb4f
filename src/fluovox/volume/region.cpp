#include "fluovox/volume/region.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

// Where `low <= origin + t * slope <= high`.
Interval between(double origin, double slope, double low, double high) {
    if (slope == 0) return origin >= low && origin <= high ? Interval{-kFar, kFar} : Interval{0, 0};
    const double a = (low - origin) / slope;
    const double b = (high - origin) / slope;
    return {std::min(a, b), std::max(a, b)};
}

Interval common(Interval a, Interval b) {
    return {std::max(a.begin, b.begin), std::min(a.end, b.end)};
}

// Where a t^2 + 2 b t + c <= 0, for a >= 0.
Interval inside_quadric(double a, double b, double c) {
    if (a == 0) return c <= 0 ? Interval{-kFar, kFar} : Interval{0, 0};
    const double discriminant = b * b - a * c;
    if (discriminant <= 0) return {0, 0};
    // The root that adds numbers of one sign, then the other from their product: no cancellation.
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    const double t0 = q / a;
    const double t1 = q == 0 ? 0 : c / q;
    return {std::min(t0, t1), std::max(t0, t1)};
}

Interval chord(const Everywhere& /*region*/, const Ray& /*ray*/) {
    return {-kFar, kFar};
}

Interval chord(const BoxRegion& box, const Ray& ray) {
    Interval span{-kFar, kFar};
    for (int axis = 0; axis < 3; ++axis) {
        span = common(span, between(ray.origin[axis], ray.direction[axis], box.min[axis], box.max[axis]));
    }
    return span;
}

Interval chord(const SphereRegion& sphere, const Ray& ray) {
    const Vec3 from_center = ray.origin - sphere.center;
    return inside_quadric(1, dot(from_center, ray.direction),
                          length_squared(from_center) - sphere.radius * sphere.radius);
}

Interval chord(const CylinderRegion& cylinder, const Ray& ray) {
    const double height = length(cylinder.to - cylinder.from);
    const Vec3 axis = normalized(cylinder.to - cylinder.from);
    const Vec3 origin = ray.origin - cylinder.from;
    const double along = dot(ray.direction, axis);
    const Vec3 origin_across = origin - dot(origin, axis) * axis;
    const Vec3 direction_across = ray.direction - along * axis;
    const Interval round = inside_quadric(length_squared(direction_across), dot(origin_across, direction_across),
                                          length_squared(origin_across) - cylinder.radius * cylinder.radius);
    return common(round, between(dot(origin, axis), along, 0, height));
}

Interval chord(const SlabRegion& slab, const Ray& ray) {
    return between(ray.origin[slab.axis], ray.direction[slab.axis], slab.min, slab.max);
}

Vec3 along_axis(int axis, double sign) {
    Vec3 normal;
    normal[axis] = sign;
    return normal;
}

Vec3 normal_at(const Everywhere& /*region*/, Vec3 /*p*/) {
    return {0, 0, 1};
}
Vec3 normal_at(const BoxRegion& box, Vec3 p) {
    Vec3 normal{0, 0, 1};
    double nearest = kFar;
    for (int axis = 0; axis < 3; ++axis) {
        const double below = std::abs(p[axis] - box.min[axis]);
        const double above = std::abs(p[axis] - box.max[axis]);
        if (std::min(below, above) >= nearest) continue;
        nearest = std::min(below, above);
        normal = along_axis(axis, below < above ? -1 : 1);
    }
    return normal;
}
Vec3 normal_at(const SphereRegion& sphere, Vec3 p) {
    return normalized(p - sphere.center);
}
Vec3 normal_at(const CylinderRegion& cylinder, Vec3 p) {
    const double height = length(cylinder.to - cylinder.from);
    const Vec3 axis = normalized(cylinder.to - cylinder.from);
    const double along = dot(p - cylinder.from, axis);
    const Vec3 across = p - cylinder.from - along * axis;
    const double to_wall = std::abs(length(across) - cylinder.radius);
    if (to_wall <= std::min(std::abs(along), std::abs(height - along))) return normalized(across);
    return along < 0.5 * height ? -axis : axis;
}
Vec3 normal_at(const SlabRegion& slab, Vec3 p) {
    return along_axis(slab.axis, std::abs(p[slab.axis] - slab.min) < std::abs(p[slab.axis] - slab.max) ? -1 : 1);
}

bool holds(const Everywhere& /*region*/, Vec3 /*p*/) {
    return true;
}
bool holds(const BoxRegion& box, Vec3 p) {
    for (int axis = 0; axis < 3; ++axis) {
        if (p[axis] < box.min[axis] || p[axis] > box.max[axis]) return false;
    }
    return true;
}
bool holds(const SphereRegion& sphere, Vec3 p) {
    return length_squared(p - sphere.center) <= sphere.radius * sphere.radius;
}
bool holds(const CylinderRegion& cylinder, Vec3 p) {
    const Vec3 axis = cylinder.to - cylinder.from;
    const double along = dot(p - cylinder.from, axis) / length_squared(axis);
    if (along < 0 || along > 1) return false;
    return length_squared(p - cylinder.from - along * axis) <= cylinder.radius * cylinder.radius;
}
bool holds(const SlabRegion& slab, Vec3 p) {
    return p[slab.axis] >= slab.min && p[slab.axis] <= slab.max;
}

// How far outside the point is at least; how far inside, less than zero.
double outside_by(const Everywhere& /*region*/, Vec3 /*p*/) {
    return -kFar;
}
double outside_by(const BoxRegion& box, Vec3 p) {
    double distance = -kFar;
    for (int axis = 0; axis < 3; ++axis)
        distance = std::max({distance, box.min[axis] - p[axis], p[axis] - box.max[axis]});
    return distance;
}
double outside_by(const SphereRegion& sphere, Vec3 p) {
    return length(p - sphere.center) - sphere.radius;
}
double outside_by(const CylinderRegion& cylinder, Vec3 p) {
    const double height = length(cylinder.to - cylinder.from);
    const Vec3 axis = normalized(cylinder.to - cylinder.from);
    const double along = dot(p - cylinder.from, axis);
    const Vec3 across = p - cylinder.from - along * axis;
    return std::max({length(across) - cylinder.radius, -along, along - height});
}
double outside_by(const SlabRegion& slab, Vec3 p) {
    return std::max(slab.min - p[slab.axis], p[slab.axis] - slab.max);
}

}  // namespace

Interval chord_of(const Region& region, const Ray& ray) {
    return std::visit([&](const auto& shape) { return chord(shape, ray); }, region);
}

Vec3 surface_normal(const Region& region, Vec3 position_um) {
    return std::visit([&](const auto& shape) { return normal_at(shape, position_um); }, region);
}

Interval intersect(const Region& region, const Ray& ray) {
    const Interval ahead = common(chord_of(region, ray), {0, kFar});
    return ahead.empty() ? Interval{0, 0} : ahead;
}

bool contains(const Region& region, Vec3 position_um) {
    return std::visit([&](const auto& shape) { return holds(shape, position_um); }, region);
}

double clearance(const Region& region, Vec3 position_um) {
    return std::abs(std::visit([&](const auto& shape) { return outside_by(shape, position_um); }, region));
}

Bounds bounds_of(const Region& region) {
    Bounds bounds;
    if (const auto* box = std::get_if<BoxRegion>(&region)) {
        bounds = {box->min, box->max};
    } else if (const auto* sphere = std::get_if<SphereRegion>(&region)) {
        const Vec3 r{sphere->radius, sphere->radius, sphere->radius};
        bounds = {sphere->center - r, sphere->center + r};
    } else if (const auto* cylinder = std::get_if<CylinderRegion>(&region)) {
        const Vec3 axis = normalized(cylinder->to - cylinder->from);
        Vec3 r;
        for (int i = 0; i < 3; ++i)
            r[i] = cylinder->radius * std::sqrt(std::max(0.0, 1 - axis[i] * axis[i]));
        bounds.add({cylinder->from - r, cylinder->from + r});
        bounds.add({cylinder->to - r, cylinder->to + r});
    } else {
        bounds = {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
        if (const auto* slab = std::get_if<SlabRegion>(&region)) {
            bounds.min[slab->axis] = slab->min;
            bounds.max[slab->axis] = slab->max;
        }
    }
    return bounds;
}

}  // namespace fluovox
