#include "fluovox/volume/sparse_grid_builder.h"

#include "fluovox/core/error.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <utility>

namespace fluovox {
namespace {

constexpr int kBrick = SparseGrid::kBrickSize;
constexpr std::size_t kVoxels = std::size_t{kBrick} * kBrick * kBrick;

// Largest value of a brick among the voxels that lie in its first layer along each axis whose bit is set:
// what the neighbour on the lower side of those axes can see through trilinear interpolation.
float layer_max(const float* brick, int axes) {
    const int nx = (axes & 4) != 0 ? 1 : kBrick;
    const int ny = (axes & 2) != 0 ? 1 : kBrick;
    const int nz = (axes & 1) != 0 ? 1 : kBrick;
    float highest = 0;
    for (int x = 0; x < nx; ++x) {
        for (int y = 0; y < ny; ++y) {
            for (int z = 0; z < nz; ++z) {
                highest = std::max(highest, brick[static_cast<std::size_t>((x << 6) | (y << 3) | z)]);
            }
        }
    }
    return highest;
}

constexpr int kMost = std::numeric_limits<int>::max();
constexpr Voxel kFarthest{kMost, kMost, kMost};
constexpr Voxel kNearest{-kMost, -kMost, -kMost};

Voxel smaller(Voxel a, Voxel b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Voxel larger(Voxel a, Voxel b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

}  // namespace

void SparseGridBuilder::add_brick(Voxel origin, const float* values) {
    assert(origin.x % kBrick == 0 && origin.y % kBrick == 0 && origin.z % kBrick == 0);
    // Constants are few, such as the solid inside of meshes; a grid of many different ones keeps its bricks.
    constexpr std::size_t kMaxConstants = 256;
    if (constants_.size() < kMaxConstants &&
        std::all_of(values + 1, values + kVoxels, [&](float v) { return v == values[0]; })) {
        add_constant(origin, kBrick, values[0]);
        return;
    }
    const auto index = static_cast<std::int32_t>(voxels_.size() / kVoxels);
    cells_.push_back({{origin.x >> 3, origin.y >> 3, origin.z >> 3}, index, 0});
    voxels_.insert(voxels_.end(), values, values + kVoxels);
}

void SparseGridBuilder::add_constant(Voxel origin, int size, float value) {
    if (value == background_) return;
    const auto known = std::find(constants_.begin(), constants_.end(), value);
    std::size_t index = static_cast<std::size_t>(known - constants_.begin());
    if (known == constants_.end()) constants_.push_back(value);
    ++index;  // [0] of the grid is the background
    const int bricks = size / kBrick;
    for (int x = 0; x < bricks; ++x) {
        for (int y = 0; y < bricks; ++y) {
            for (int z = 0; z < bricks; ++z) {
                const Voxel brick{(origin.x >> 3) + x, (origin.y >> 3) + y, (origin.z >> 3) + z};
                cells_.push_back({brick, ~static_cast<std::int32_t>(index), value});
            }
        }
    }
}

void SparseGridBuilder::set_node_box(SparseGrid& grid) const {
    Voxel low = kFarthest;
    Voxel high = kNearest;
    for (const Cell& cell : cells_) {  // one brick below is reached by interpolation
        low = smaller(low, {(cell.brick.x - 1) >> 4, (cell.brick.y - 1) >> 4, (cell.brick.z - 1) >> 4});
        high = larger(high, {cell.brick.x >> 4, cell.brick.y >> 4, cell.brick.z >> 4});
    }
    if (cells_.empty()) low = high = {0, 0, 0};
    grid.node_min_ = low;
    grid.node_count_ = {high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1};
    const double slots = static_cast<double>(grid.node_count_.x) * grid.node_count_.y * grid.node_count_.z;
    if (slots > 1 << 27) throw InputError("the grid's voxels are spread too far apart (over 2^27 nodes of 128^3)");
    grid.nodes_.assign(static_cast<std::size_t>(slots), ~0);
    grid.node_bounds_.assign(grid.nodes_.size(), background_);
}

std::size_t SparseGridBuilder::ensure_cell(SparseGrid& grid, Voxel brick) const {
    const std::size_t slot = grid.node_slot((brick.x >> 4) - grid.node_min_.x, (brick.y >> 4) - grid.node_min_.y,
                                            (brick.z >> 4) - grid.node_min_.z);
    if (grid.nodes_[slot] < 0) {
        grid.nodes_[slot] = static_cast<std::int32_t>(grid.cells_.size() / SparseGrid::kCellsPerNode);
        grid.cells_.resize(grid.cells_.size() + SparseGrid::kCellsPerNode, ~0);
        grid.cell_bounds_.resize(grid.cells_.size(), background_);
    }
    const auto cell = static_cast<std::size_t>(((brick.x & 15) << 8) | ((brick.y & 15) << 4) | (brick.z & 15));
    return static_cast<std::size_t>(grid.nodes_[slot]) * SparseGrid::kCellsPerNode + cell;
}

void SparseGridBuilder::spread_bound(SparseGrid& grid, const Cell& cell) const {
    for (int axes = 0; axes < 8; ++axes) {
        const float highest =
            cell.index < 0 ? cell.value : layer_max(&voxels_[static_cast<std::size_t>(cell.index) * kVoxels], axes);
        if (!(highest > background_)) continue;
        const Voxel reached{cell.brick.x - ((axes >> 2) & 1), cell.brick.y - ((axes >> 1) & 1),
                            cell.brick.z - (axes & 1)};
        grid.occupied_min_ = smaller(grid.occupied_min_, {kBrick * reached.x, kBrick * reached.y, kBrick * reached.z});
        grid.occupied_max_ =
            larger(grid.occupied_max_, {kBrick * (reached.x + 1), kBrick * (reached.y + 1), kBrick * (reached.z + 1)});
        float& bound = grid.cell_bounds_[ensure_cell(grid, reached)];
        bound = std::max(bound, highest);
    }
}

SparseGrid SparseGridBuilder::finish(const Affine& world_from_index, std::size_t active_voxels) && {
    SparseGrid grid;
    grid.world_from_index_ = world_from_index;
    grid.index_from_world_ = world_from_index.inverse();
    grid.active_voxels_ = active_voxels;
    grid.constants_ = {background_};
    grid.constants_.insert(grid.constants_.end(), constants_.begin(), constants_.end());
    grid.max_ = static_cast<double>(*std::max_element(grid.constants_.begin(), grid.constants_.end()));
    for (const float v : voxels_)
        grid.max_ = std::max(grid.max_, static_cast<double>(v));

    set_node_box(grid);
    grid.occupied_min_ = kFarthest;
    grid.occupied_max_ = kNearest;
    for (const Cell& cell : cells_) {
        grid.cells_[ensure_cell(grid, cell.brick)] = cell.index;
        spread_bound(grid, cell);
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 at{8.0 * (cell.brick.x + (corner & 1)) - ((corner & 1) != 0 ? 0 : 1),
                          8.0 * (cell.brick.y + ((corner >> 1) & 1)) - ((corner & 2) != 0 ? 0 : 1),
                          8.0 * (cell.brick.z + ((corner >> 2) & 1)) - ((corner & 4) != 0 ? 0 : 1)};
            grid.bounds_.add(world_from_index.point(at));
        }
    }
    for (std::size_t slot = 0; slot < grid.nodes_.size(); ++slot) {
        if (grid.nodes_[slot] < 0) continue;
        const auto first =
            grid.cell_bounds_.begin() +
            static_cast<std::ptrdiff_t>(static_cast<std::size_t>(grid.nodes_[slot]) * SparseGrid::kCellsPerNode);
        grid.node_bounds_[slot] =
            *std::max_element(first, first + static_cast<std::ptrdiff_t>(SparseGrid::kCellsPerNode));
    }
    grid.voxels_ = std::move(voxels_);
    return grid;
}

}  // namespace fluovox
