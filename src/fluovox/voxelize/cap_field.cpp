#include "fluovox/voxelize/cap_field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace fluovox {

CapField::CapField(const WindingTree& caps, const Vec3& corner, double side)
    : caps_(caps), whole_(make_cube(corner, side)) {
    for (std::size_t i = 0; i < eighths_.size() && !whole_.smooth; ++i) {
        const auto half = [&](unsigned bit) { return (i >> bit & 1U) != 0 ? side / 2 : 0.0; };
        eighths_[i] = make_cube(corner + Vec3{half(2), half(1), half(0)}, side / 2);
    }
}

CapField::Cube CapField::make_cube(const Vec3& corner, double side) const {
    Cube cube;
    cube.corner = corner;
    cube.side = side;
    // With no cap nearer than a side of the cube, straight lines between points half a side apart miss the number by
    // less than 0.01, as its second derivative falls with the square of the distance.
    const double half_diagonal = side * std::sqrt(3.0) / 2;
    const Vec3 center = corner + 0.5 * Vec3{side, side, side};
    cube.smooth = !caps_.any_within(center, half_diagonal + side);
    for (std::size_t i = 0; i < cube.values.size() && cube.smooth; ++i) {
        const std::size_t x = i / 9;
        const std::size_t y = i / 3 % 3;
        const std::size_t z = i % 3;
        const Vec3 step = {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
        cube.values[i] = caps_(corner + (side / 2) * step);
    }
    return cube;
}

double CapField::Cube::interpolated(const Vec3& point) const {
    std::array<std::size_t, 3> cell{};
    std::array<double, 3> along{};
    for (int axis = 0; axis < 3; ++axis) {
        const double at = std::clamp((point[axis] - corner[axis]) / (side / 2), 0.0, 2.0);
        const auto i = static_cast<std::size_t>(axis);
        cell[i] = at < 1 ? 0 : 1;
        along[i] = at - static_cast<double>(cell[i]);
    }
    double sum = 0;
    for (std::size_t i = 0; i < 8; ++i) {
        const std::size_t x = i >> 2U & 1U;
        const std::size_t y = i >> 1U & 1U;
        const std::size_t z = i & 1U;
        const double weight = (x != 0 ? along[0] : 1 - along[0]) * (y != 0 ? along[1] : 1 - along[1]) *
                              (z != 0 ? along[2] : 1 - along[2]);
        sum += weight * values[((cell[0] + x) * 3 + cell[1] + y) * 3 + cell[2] + z];
    }
    return sum;
}

double CapField::operator()(const Vec3& point) const {
    if (whole_.smooth) return whole_.interpolated(point);
    std::size_t part = 0;
    for (int axis = 0; axis < 3; ++axis)
        part = 2 * part + (point[axis] >= whole_.corner[axis] + whole_.side / 2 ? 1U : 0U);
    return eighths_[part].smooth ? eighths_[part].interpolated(point) : caps_(point);
}

}  // namespace fluovox
