#pragma once

#include "fluovox/volume/sparse_grid.h"

#include <cstddef>
#include <vector>

namespace fluovox {

/// Collects bricks and constant cells in any order and makes the SparseGrid of them.
class SparseGridBuilder {
public:
    explicit SparseGridBuilder(float background) : background_(background) {}

    /// The 512 values of the brick whose first voxel is `origin` (a multiple of 8), z fastest.
    void add_brick(Voxel origin, const float* values);
    /// A cube of `size` voxels (8 or a multiple) from `origin` with one value.
    void add_constant(Voxel origin, int size, float value);

    SparseGrid finish(const Affine& world_from_index, std::size_t active_voxels) &&;

private:
    struct Cell {
        Voxel brick;         // brick coordinates
        std::int32_t index;  // into voxels_ by brick, or ~ into constants
        float value;         // of a constant
    };

    void set_node_box(SparseGrid& grid) const;
    std::size_t ensure_cell(SparseGrid& grid, Voxel brick) const;
    void spread_bound(SparseGrid& grid, const Cell& cell) const;

    float background_;
    std::vector<Cell> cells_;
    std::vector<float> voxels_;
    std::vector<float> constants_;
};

}  // namespace fluovox
