#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/voxelize/mesh.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>

// Meshes whose volume is known.
namespace fluovox::testing {

inline void flip(Mesh::Triangle& triangle) {
    std::swap(triangle[1], triangle[2]);
}

inline Mesh inside_out(Mesh mesh) {
    for (auto& triangle : mesh.triangles)
        flip(triangle);
    return mesh;
}

inline Mesh joined(Mesh a, const Mesh& b) {
    append(a, b);
    return a;
}

inline Mesh moved(Mesh mesh, Vec3 by) {
    for (Vec3& v : mesh.vertices)
        v = v + by;
    return mesh;
}

inline Mesh box(Vec3 min, Vec3 max) {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.vertices.push_back(
            {(i & 1) != 0 ? max.x : min.x, (i & 2) != 0 ? max.y : min.y, (i & 4) != 0 ? max.z : min.z});
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// A prism with `sides` flat sides around the line from `from` to `to`.
inline Mesh cylinder(Vec3 from, Vec3 to, double radius, std::uint32_t sides) {
    Mesh mesh;
    const Frame frame = Frame::around(normalized(to - from));
    for (const Vec3& end : {from, to}) {
        for (std::uint32_t i = 0; i < sides; ++i) {
            const double angle = 2 * std::numbers::pi * i / sides;
            mesh.vertices.push_back(end + frame.to_world({radius * std::cos(angle), radius * std::sin(angle), 0}));
        }
    }
    for (std::uint32_t i = 0; i < sides; ++i) {
        const std::uint32_t j = (i + 1) % sides;
        mesh.triangles.push_back({i, j, sides + i});
        mesh.triangles.push_back({j, sides + j, sides + i});
        if (i >= 2) {
            mesh.triangles.push_back({0, i, i - 1});
            mesh.triangles.push_back({sides, sides + i - 1, sides + i});
        }
    }
    return mesh;
}

/// A ball of latitude and longitude lines.
inline Mesh ball(Vec3 center, double radius, std::uint32_t rows = 48) {
    Mesh mesh;
    const std::uint32_t columns = 2 * rows;
    for (std::uint32_t row = 1; row < rows; ++row) {
        const double theta = std::numbers::pi * row / rows;
        for (std::uint32_t column = 0; column < columns; ++column) {
            const double phi = 2 * std::numbers::pi * column / columns;
            mesh.vertices.push_back(center + radius * Vec3{std::sin(theta) * std::cos(phi),
                                                           std::sin(theta) * std::sin(phi), std::cos(theta)});
        }
    }
    const auto north = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(center + Vec3{0, 0, radius});
    mesh.vertices.push_back(center - Vec3{0, 0, radius});
    const auto at = [&](std::uint32_t row, std::uint32_t column) { return (row - 1) * columns + column % columns; };
    for (std::uint32_t column = 0; column < columns; ++column) {
        mesh.triangles.push_back({north, at(1, column), at(1, column + 1)});
        mesh.triangles.push_back({north + 1, at(rows - 1, column + 1), at(rows - 1, column)});
        for (std::uint32_t row = 1; row + 1 < rows; ++row) {
            mesh.triangles.push_back({at(row, column), at(row + 1, column), at(row + 1, column + 1)});
            mesh.triangles.push_back({at(row, column), at(row + 1, column + 1), at(row, column + 1)});
        }
    }
    return mesh;
}

}  // namespace fluovox::testing
