#pragma once

#include <cmath>

namespace fluovox {

/// A point or direction; micrometres where it is a place.
struct Vec3 {
    double x = 0, y = 0, z = 0;

    constexpr double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
    constexpr double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    constexpr bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(Vec3 a, Vec3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Vec3 operator-(Vec3 a, Vec3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Vec3 operator-(Vec3 v) {
    return {-v.x, -v.y, -v.z};
}
constexpr Vec3 operator*(double s, Vec3 v) {
    return {s * v.x, s * v.y, s * v.z};
}
constexpr double dot(Vec3 a, Vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 cross(Vec3 a, Vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double length_squared(Vec3 v) {
    return dot(v, v);
}
inline double length(Vec3 v) {
    return std::sqrt(length_squared(v));
}
/// `v` scaled to unit length; `v` must not be zero.
inline Vec3 normalized(Vec3 v) {
    return (1 / length(v)) * v;
}

/// Half-line `origin + t * direction`; `direction` has unit length, so `t` is in micrometres.
struct Ray {
    Vec3 origin;
    Vec3 direction;

    constexpr Vec3 at(double t_um) const { return origin + t_um * direction; }
};

/// Right-handed orthonormal axes whose third is a given direction.
struct Frame {
    Vec3 x, y, z;

    /// Any frame around the unit vector `z`. Duff et al., JCGT 6(1), 2017.
    static Frame around(Vec3 z) {
        const double sign = std::copysign(1.0, z.z);
        const double a = -1 / (sign + z.z);
        const double b = z.x * z.y * a;
        return {{1 + sign * z.x * z.x * a, sign * b, -sign * z.x}, {b, sign + z.y * z.y * a, -z.y}, z};
    }
    constexpr Vec3 to_world(Vec3 local) const { return local.x * x + local.y * y + local.z * z; }
    constexpr Vec3 to_local(Vec3 world) const { return {dot(world, x), dot(world, y), dot(world, z)}; }
};

}  // namespace fluovox
