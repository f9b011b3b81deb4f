#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/grid_info.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace fluovox {

/// An affine map of space, p -> linear p + offset.
struct Affine {
    std::array<Vec3, 3> rows = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    Vec3 offset;

    constexpr Vec3 direction(Vec3 d) const { return {dot(rows[0], d), dot(rows[1], d), dot(rows[2], d)}; }
    constexpr Vec3 point(Vec3 p) const { return direction(p) + offset; }
    /// The map back; the linear part must not be singular.
    Affine inverse() const;
};

/// What the numbers of a file are multiplied by.
struct GridScale {
    double value = 1;   ///< each value
    double length = 1;  ///< each length of its world space, giving micrometres
};

/// Integer position of a voxel. Its centre is at the same index-space coordinates.
struct Voxel {
    int x = 0, y = 0, z = 0;
};

/// A sparse scalar field made once for tracking: values in 8^3 bricks, constant stretches without storage, and upper
/// bounds over bricks and over nodes of 16^3 bricks. Between voxel centres the field is trilinear, and the bounds hold
/// for that. Memory follows the active voxels. Immutable: any number of threads may read it.
class SparseGrid {
public:
    static constexpr int kBrickSize = 8;                   ///< voxels along a brick
    static constexpr int kNodeSize = 128;                  ///< voxels along a node
    static constexpr int kCells = kNodeSize / kBrickSize;  ///< bricks along a node

    /// Reads one grid of a VDB file; `units` turns what the file says of itself into factors for its values and
    /// lengths. Throws InputError for anything that is not a field of finite values >= 0 with an affine transform.
    static SparseGrid load(const std::filesystem::path& file, const std::string& name,
                           const std::function<GridScale(const GridMetadata&)>& units);

    /// Values `f(voxel)` for the voxels from `min` up to but not including `max`, zero elsewhere.
    static SparseGrid from_function(Voxel min, Voxel max, const Affine& world_from_index,
                                    const std::function<double(Voxel)>& f);

    /// Value of a voxel.
    float value(Voxel voxel) const {
        const std::int32_t node = node_at(voxel.x >> 7, voxel.y >> 7, voxel.z >> 7);
        if (node < 0) return constants_[static_cast<std::size_t>(~node)];
        const auto cell = static_cast<std::size_t>((((voxel.x >> 3) & 15) << 8) | (((voxel.y >> 3) & 15) << 4) |
                                                   ((voxel.z >> 3) & 15));
        const std::int32_t brick = cells_[static_cast<std::size_t>(node) * kCellsPerNode + cell];
        if (brick < 0) return constants_[static_cast<std::size_t>(~brick)];
        const auto in_brick = static_cast<std::size_t>(((voxel.x & 7) << 6) | ((voxel.y & 7) << 3) | (voxel.z & 7));
        return voxels_[static_cast<std::size_t>(brick) * kVoxelsPerBrick + in_brick];
    }

    /// Value of one of the eight voxels around an index-space position, drawn with the trilinear weights by three
    /// uniform numbers in `u`: its expectation is the trilinear value. Valid wherever the result is used linearly.
    float tap(Vec3 index_position, Vec3 u) const {
        return value({static_cast<int>(std::floor(index_position.x + u.x)),
                      static_cast<int>(std::floor(index_position.y + u.y)),
                      static_cast<int>(std::floor(index_position.z + u.z))});
    }

    /// The trilinear field at a world position (micrometres).
    double trilinear(Vec3 world_um) const;

    const Affine& index_from_world() const { return index_from_world_; }
    const Affine& world_from_index() const { return world_from_index_; }
    /// World box outside which the field is `background()`.
    const Bounds& bounds() const { return bounds_; }
    double background() const { return constants_[0]; }
    /// Largest voxel value.
    double max() const { return max_; }
    std::size_t active_voxels() const { return active_voxels_; }
    std::size_t memory_bytes() const;

private:
    friend class SparseGridBuilder;
    friend class MajorantWalk;

    static constexpr std::size_t kCellsPerNode = std::size_t{kCells} * kCells * kCells;
    static constexpr std::size_t kVoxelsPerBrick = std::size_t{kBrickSize} * kBrickSize * kBrickSize;

    SparseGrid() = default;

    // Index of the node with these node coordinates, or the complement of an index into constants_.
    std::int32_t node_at(int x, int y, int z) const {
        const int i = x - node_min_.x;
        const int j = y - node_min_.y;
        const int k = z - node_min_.z;
        if (static_cast<unsigned>(i) >= static_cast<unsigned>(node_count_.x) ||
            static_cast<unsigned>(j) >= static_cast<unsigned>(node_count_.y) ||
            static_cast<unsigned>(k) >= static_cast<unsigned>(node_count_.z)) {
            return ~0;
        }
        return nodes_[node_slot(i, j, k)];
    }
    std::size_t node_slot(int i, int j, int k) const {
        return (static_cast<std::size_t>(i) * static_cast<std::size_t>(node_count_.y) + static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(node_count_.z) +
               static_cast<std::size_t>(k);
    }

    Affine world_from_index_, index_from_world_;
    Voxel node_min_, node_count_;
    Voxel occupied_min_, occupied_max_;   // box of the cells with a bound above the background, in voxels
    std::vector<std::int32_t> nodes_;     // per slot of the node box: a node, or ~constant
    std::vector<float> node_bounds_;      // per slot
    std::vector<std::int32_t> cells_;     // per node and cell: a brick, or ~constant
    std::vector<float> cell_bounds_;      // per node and cell
    std::vector<float> voxels_;           // per brick
    std::vector<float> constants_ = {0};  // [0] is the background
    Bounds bounds_;
    double max_ = 0;
    std::size_t active_voxels_ = 0;
};

}  // namespace fluovox
