#pragma once

#include "fluovox/volume/filled_cells.h"
#include "fluovox/volume/sparse_grid.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {

/// Collects bricks and constant cubes in any order and makes the SparseGrid of them. What it holds is packed as it
/// comes, so it needs little more memory than the grid.
class SparseGridBuilder {
public:
    explicit SparseGridBuilder(float background) : background_(background) {}

    /// The 512 values of the brick whose first voxel is `origin` (a multiple of 8), z fastest.
    void add_brick(Voxel origin, const float* values);
    /// A cube of `size` voxels (8 or a multiple) from `origin` with one value.
    void add_constant(Voxel origin, int size, float value);

    /// Adds the bricks of another one, which has the same background, behind those that are here. False, and none are
    /// added, where there is no room for its constants: then its bricks must be added one by one.
    bool append(SparseGridBuilder&& part);

    SparseGrid finish(const Affine& world_from_index, std::size_t active_voxels) &&;

    /// The other way round: the first voxels of the bricks in which the trilinear field of a grid is not its background
    /// everywhere (and of few others), in the order of their places. Costs what the grid holds, however far apart.
    static std::vector<Voxel> bricks_of(const SparseGrid& grid);

private:
    struct Cell {
        Voxel place;  // in bricks
        SparseGrid::Brick brick;
        unsigned reached = 0;  // bit per combination of axes: seen from the neighbour on the lower side of these
    };

    std::uint16_t constant(float value);
    void require_room(std::size_t words) const;
    std::uint16_t pack_block(const float* values, int block, SparseGrid::Brick& brick);
    void set_node_box(SparseGrid& grid) const;
    static std::size_t ensure_node(SparseGrid& grid, Voxel place);
    void place_bricks(SparseGrid& grid) const;
    void raise_bounds(const SparseGrid& grid, const Cell& cell, std::vector<std::array<float, 8>>& bounds) const;
    static void set_bounds(SparseGrid& grid, const std::vector<std::array<float, 8>>& bounds);
    void set_occupied_box(SparseGrid& grid) const;
    void set_directory(SparseGrid& grid) const;
    static void set_brick_map(SparseGrid& grid);
    static void sort_bricks(SparseGrid& grid, std::vector<std::uint32_t> sorted);
    static BrickVoxels voxels_of(const SparseGrid& grid, const SparseGrid::Brick& brick);
    static void set_cells(SparseGrid& grid);
    static std::uint8_t excess_of(const SparseGrid::Outline& outline);

    float background_;
    std::vector<Cell> cells_;
    std::vector<std::uint16_t> codes_;
    std::vector<float> constants_;
};

}  // namespace fluovox
