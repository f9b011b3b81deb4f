#include "fluovox/volume/sparse_grid.h"

#include "fluovox/volume/sparse_grid_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace fluovox {
namespace {

// Between the eight voxels around an index-space position.
template <class ValueOf>
double interpolated(Vec3 position, const ValueOf& value_of) {
    constexpr double kFar = 1 << 30;  // beyond all grids
    const auto clamped = [&](double x) { return std::clamp(x, -kFar, kFar); };
    const Vec3 p{clamped(position.x), clamped(position.y), clamped(position.z)};
    const Vec3 base{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    const Vec3 w = p - base;
    double total = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Voxel voxel{static_cast<int>(base.x) + (corner & 1), static_cast<int>(base.y) + ((corner >> 1) & 1),
                          static_cast<int>(base.z) + ((corner >> 2) & 1)};
        const double weight = ((corner & 1) != 0 ? w.x : 1 - w.x) * ((corner & 2) != 0 ? w.y : 1 - w.y) *
                              ((corner & 4) != 0 ? w.z : 1 - w.z);
        total += weight * static_cast<double>(value_of(voxel));
    }
    return total;
}

}  // namespace

Affine Affine::inverse() const {
    // Columns of the inverse are cross products of the rows over the determinant.
    const double determinant = dot(rows[0], cross(rows[1], rows[2]));
    const Vec3 a = (1 / determinant) * cross(rows[1], rows[2]);
    const Vec3 b = (1 / determinant) * cross(rows[2], rows[0]);
    const Vec3 c = (1 / determinant) * cross(rows[0], rows[1]);
    Affine back;
    back.rows = {Vec3{a.x, b.x, c.x}, Vec3{a.y, b.y, c.y}, Vec3{a.z, b.z, c.z}};
    back.offset = -back.direction(offset);
    return back;
}

double SparseGrid::trilinear(Vec3 world_um) const {
    return interpolated(index_from_world_.point(world_um), [&](Voxel voxel) { return value(voxel); });
}

double SparseGrid::trilinear_from_root(Vec3 index_position) const {
    return interpolated(index_position, [&](Voxel voxel) { return value_from_root(voxel); });
}

SparseGrid SparseGrid::from_function(Voxel min, Voxel max, const Affine& world_from_index,
                                     const std::function<double(Voxel)>& f) {
    SparseGridBuilder builder(0);
    std::size_t active = 0;
    std::array<float, 512> values{};
    for (int x = min.x & ~7; x < max.x; x += 8) {
        for (int y = min.y & ~7; y < max.y; y += 8) {
            for (int z = min.z & ~7; z < max.z; z += 8) {
                for (int i = 0; i < 512; ++i) {
                    const Voxel v{x + (i >> 6), y + ((i >> 3) & 7), z + (i & 7)};
                    const bool inside =
                        v.x >= min.x && v.x < max.x && v.y >= min.y && v.y < max.y && v.z >= min.z && v.z < max.z;
                    const float value = inside ? static_cast<float>(f(v)) : 0.0F;
                    values[static_cast<std::size_t>(i)] = value;
                    active += value > 0 ? 1 : 0;
                }
                builder.add_brick({x, y, z}, values.data());
            }
        }
    }
    return std::move(builder).finish(world_from_index, active);
}

std::size_t SparseGrid::memory_bytes() const {
    return sizeof(*this) + 4 * (groups_.size() + slots_.size() + constants_.size()) + directory_.memory_bytes() +
           sizeof(Node) * nodes_.size() + (sizeof(Brick) + sizeof(Outline)) * bricks_.size() + 4 * order_.size() +
           2 * codes_.size();
}

}  // namespace fluovox
