#pragma once

// Sparse grids of every awkward sort, from a seed.

#include "fluovox/core/rng.h"
#include "fluovox/volume/sparse_grid_builder.h"

#include <array>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

namespace fluovox::testing {

/// Rotated, sheared and scaled by up to a factor of two either way, and moved.
inline Affine random_affine(Rng& rng) {
    Affine map;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            map.rows[static_cast<std::size_t>(row)][column] =
                (row == column ? 0.5 + rng.uniform() : 0.0) + 0.6 * (rng.uniform() - 0.5);
        }
        map.offset[row] = 200 * (rng.uniform() - 0.5);
    }
    return map;
}

inline int random_integer(Rng& rng, int from, int to) {
    return from + static_cast<int>(std::floor(rng.uniform() * (to - from)));
}

/// Bricks of noise and constant cubes of one brick and of a whole node, scattered over nodes with negative and positive
/// coordinates.
inline SparseGrid random_grid(Rng& rng, const Affine& world_from_index, float background) {
    SparseGridBuilder builder(background);
    std::set<std::tuple<int, int, int>> taken;
    const auto claim = [&](Voxel brick) { return taken.emplace(brick.x, brick.y, brick.z).second; };
    if (rng.uniform() < 0.5) {  // one node is all constant
        const Voxel node{random_integer(rng, -2, 2), random_integer(rng, -2, 2), random_integer(rng, -2, 2)};
        for (int i = 0; i < 16 * 16 * 16; ++i)
            claim({node.x * 16 + (i >> 8), node.y * 16 + ((i >> 4) & 15), node.z * 16 + (i & 15)});
        builder.add_constant({node.x * 128, node.y * 128, node.z * 128}, 128, static_cast<float>(rng.uniform()));
    }
    for (int i = 0; i < 500; ++i) {
        const Voxel brick{random_integer(rng, -8, 9), random_integer(rng, -18, 5), random_integer(rng, -6, 20)};
        if (!claim(brick)) continue;
        const Voxel origin{brick.x * 8, brick.y * 8, brick.z * 8};
        if (rng.uniform() < 0.3) {
            builder.add_constant(origin, 8, static_cast<float>(2 * rng.uniform()));
            continue;
        }
        std::array<float, 512> values{};
        for (float& value : values)
            value = rng.uniform() < 0.5 ? 0.0F : static_cast<float>(3 * rng.uniform() * rng.uniform());
        builder.add_brick(origin, values.data());
    }
    return std::move(builder).finish(world_from_index, 1);
}

/// A ray that passes near the middle of such a grid; every third runs along an axis of the grid, every fifth starts
/// inside.
inline Ray random_ray(const SparseGrid& grid, int number, Rng& rng) {
    const auto anywhere = [&](double size) {
        return Vec3{size * (rng.uniform() - 0.5), size * (rng.uniform() - 0.5), size * (rng.uniform() - 0.5)};
    };
    Vec3 index_direction = anywhere(1);
    if (number % 3 == 0) {
        index_direction = {0, 0, 0};
        index_direction[random_integer(rng, 0, 3)] = rng.uniform() < 0.5 ? 1 : -1;
    }
    Vec3 place = anywhere(240);
    if (number % 4 == 0) place = {std::floor(place.x), std::floor(place.y), std::floor(place.z)};
    const Affine& map = grid.world_from_index();
    const Vec3 direction = normalized(map.direction(index_direction));
    return {map.point(place) - (number % 5 == 0 ? 0 : 600) * direction, direction};
}

}  // namespace fluovox::testing
