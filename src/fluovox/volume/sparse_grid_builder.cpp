#include "fluovox/volume/sparse_grid_builder.h"

#include "fluovox/core/error.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace fluovox {
namespace {

constexpr int kBrick = SparseGrid::kBrickSize;
constexpr std::size_t kVoxels = std::size_t{kBrick} * kBrick * kBrick;
constexpr std::size_t kMaskWords = 4;

// Constants are few, such as the solid inside of meshes; a grid of many different ones keeps its blocks.
constexpr std::size_t kMaxConstants = 256;

// Largest value among the voxels of a block that lie in its first layer along each axis whose bit is set: what the
// neighbour on the lower side of those axes can see through trilinear interpolation.
using LayerMaxima = std::array<float, 8>;

// From the largest value of voxels that are in the first layer along exactly these axes.
LayerMaxima with_all_layers(const LayerMaxima& exactly) {
    LayerMaxima highest{};
    for (std::size_t axes = 0; axes < 8; ++axes) {
        for (std::size_t flags = 0; flags < 8; ++flags) {
            if ((flags & axes) == axes) highest[axes] = std::max(highest[axes], exactly[flags]);
        }
    }
    return highest;
}

std::size_t layers_of(int x, int y, int z) {
    return static_cast<std::size_t>((x == 0 ? 4 : 0) | (y == 0 ? 2 : 0) | (z == 0 ? 1 : 0));
}

// Of the voxels of a brick; those in no first layer are left out.
LayerMaxima maxima_in_first_layers(const float* values) {
    LayerMaxima exactly{};
    for (int x = 0; x < kBrick; ++x) {
        for (int y = 0; y < kBrick; ++y) {
            const int count = x == 0 || y == 0 ? kBrick : 1;
            for (int z = 0; z < count; ++z) {
                float& highest = exactly[layers_of(x, y, z)];
                highest = std::max(highest, values[(x * kBrick + y) * kBrick + z]);
            }
        }
    }
    return with_all_layers(exactly);
}

bool are_same(const std::array<float, 64>& values) {
    bool same = true;
    for (const float value : values)
        same = same && value == values[0];
    return same;
}

// Steps below the largest value of a brick, in the order of floating-point numbers, to the nearest 2^shift.
std::uint16_t encoded(float value, float largest, unsigned shift) {
    const auto top = std::bit_cast<std::uint32_t>(largest);
    const std::uint32_t below = top - std::bit_cast<std::uint32_t>(value);
    const std::uint32_t nearest = (below + ((1U << shift) >> 1U)) >> shift;
    return static_cast<std::uint16_t>(std::min(nearest, (top - 1) >> shift));  // what is not zero stays so
}

// The least shift with which codes reach from the largest to the smallest positive value.
std::uint8_t shift_for(float smallest, float largest) {
    const std::uint32_t below = std::bit_cast<std::uint32_t>(largest) - std::bit_cast<std::uint32_t>(smallest);
    std::uint8_t shift = 0;
    while ((below + ((1U << shift) >> 1U)) >> shift > std::numeric_limits<std::uint16_t>::max())
        ++shift;
    return shift;
}

constexpr int kMost = std::numeric_limits<int>::max();

Voxel smaller(Voxel a, Voxel b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Voxel larger(Voxel a, Voxel b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
bool is_before(Voxel a, Voxel b) {
    return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
}
Voxel before(Voxel place, int axes) {
    return {place.x - ((axes >> 2) & 1), place.y - ((axes >> 1) & 1), place.z - (axes & 1)};
}
unsigned bit_in_node(Voxel brick) {
    return static_cast<unsigned>(((brick.x & 3) << 4) | ((brick.y & 3) << 2) | (brick.z & 3));
}

}  // namespace

// Index in the grid's list ([0] is the background), or kConstants when there is no room.
std::uint16_t SparseGridBuilder::constant(float value) {
    if (value == background_) return 0;
    const auto known = std::find(constants_.begin(), constants_.end(), value);
    const auto index = static_cast<std::size_t>(known - constants_.begin());
    if (known == constants_.end()) {
        if (constants_.size() >= kMaxConstants) return SparseGrid::kConstants;
        constants_.push_back(value);
    }
    return static_cast<std::uint16_t>(index + 1);
}

// What the brick's child is then.
std::uint16_t SparseGridBuilder::pack_block(const float* values, int block, SparseGrid::Brick& brick) {
    const float* first = values + (((block >> 2) & 1) * 256 + ((block >> 1) & 1) * 32 + (block & 1) * 4);
    std::array<float, 64> of_block{};
    for (std::size_t row = 0; row < 16; ++row)
        std::copy_n(first + (row >> 2) * 64 + (row & 3) * 8, 4, of_block.data() + 4 * row);
    if (are_same(of_block)) {
        const std::uint16_t index = constant(of_block[0]);
        if (index != SparseGrid::kConstants) return static_cast<std::uint16_t>(SparseGrid::kConstants + index);
    }
    std::array<std::uint16_t, 64> codes{};
    for (std::size_t i = 0; i < 64; ++i)
        codes[i] = encoded(of_block[i], brick.largest, brick.shift);
    std::uint64_t mask = 0;
    std::size_t stored = 0;
    for (std::size_t i = 0; i < 64; ++i) {
        const bool is_set = of_block[i] > 0;
        mask |= (is_set ? std::uint64_t{1} : 0) << i;
        codes[stored] = codes[i];
        stored += is_set ? 1 : 0;
    }
    const std::size_t at = codes_.size();
    codes_.resize(at + kMaskWords);
    std::memcpy(&codes_[at], &mask, sizeof(mask));
    codes_.insert(codes_.end(), codes.begin(), codes.begin() + static_cast<std::ptrdiff_t>(stored));
    return static_cast<std::uint16_t>(at - brick.base);
}

void SparseGridBuilder::require_room(std::size_t words) const {
    if (codes_.size() + words > std::numeric_limits<std::uint32_t>::max())
        throw InputError("it has too many voxels (over 2^32 words)");
}

void SparseGridBuilder::add_brick(Voxel origin, const float* values) {
    assert(origin.x % kBrick == 0 && origin.y % kBrick == 0 && origin.z % kBrick == 0);
    if (std::all_of(values + 1, values + kVoxels, [&](float v) { return v == values[0]; }) &&
        constant(values[0]) != SparseGrid::kConstants) {
        add_constant(origin, kBrick, values[0]);
        return;
    }
    Cell cell;
    cell.place = {origin.x >> 3, origin.y >> 3, origin.z >> 3};
    require_room(kVoxels + 8 * kMaskWords);
    cell.brick.base = static_cast<std::uint32_t>(codes_.size());
    float highest = 0;
    float lowest = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < kVoxels; ++i) {
        highest = std::max(highest, values[i]);
        lowest = std::min(lowest, values[i] > 0 ? values[i] : std::numeric_limits<float>::max());
    }
    const LayerMaxima maxima = maxima_in_first_layers(values);
    cell.brick.largest = highest;
    if (highest > 0) cell.brick.shift = shift_for(lowest, highest);
    for (std::size_t axes = 1; axes < 8; ++axes) {
        if (!(maxima[axes] > 0)) continue;
        const float packed = cell.brick.decoded(encoded(maxima[axes], highest, cell.brick.shift));
        cell.reached |= std::max(maxima[axes], packed) > background_ ? 1U << axes : 0U;
    }
    for (int block = 0; block < 8; ++block)
        cell.brick.child[static_cast<std::size_t>(block)] = pack_block(values, block, cell.brick);
    cells_.push_back(cell);
}

void SparseGridBuilder::add_constant(Voxel origin, int size, float value) {
    if (value == background_) return;
    const std::uint16_t index = constant(value);
    if (index == SparseGrid::kConstants) throw InputError("it has too many different constant tiles (over 256)");
    Cell cell;
    cell.brick.child.fill(static_cast<std::uint16_t>(SparseGrid::kConstants + index));
    cell.reached = value > background_ ? 0xfeU : 0U;
    const int bricks = size / kBrick;
    for (int x = 0; x < bricks; ++x) {
        for (int y = 0; y < bricks; ++y) {
            for (int z = 0; z < bricks; ++z) {
                cell.place = {(origin.x >> 3) + x, (origin.y >> 3) + y, (origin.z >> 3) + z};
                cells_.push_back(cell);
            }
        }
    }
}

bool SparseGridBuilder::append(SparseGridBuilder&& part) {
    std::vector<std::uint16_t> here{0};  // of its constants
    for (const float value : part.constants_) {
        here.push_back(constant(value));
        if (here.back() == SparseGrid::kConstants) return false;
    }
    require_room(part.codes_.size());
    const auto base = static_cast<std::uint32_t>(codes_.size());
    for (Cell& cell : part.cells_) {
        cell.brick.base += base;
        for (std::uint16_t& child : cell.brick.child) {
            if (child >= SparseGrid::kConstants)
                child = static_cast<std::uint16_t>(SparseGrid::kConstants + here[child - SparseGrid::kConstants]);
        }
    }
    cells_.insert(cells_.end(), part.cells_.begin(), part.cells_.end());
    codes_.insert(codes_.end(), part.codes_.begin(), part.codes_.end());
    return true;
}

void SparseGridBuilder::set_node_box(SparseGrid& grid) const {
    Voxel low{kMost, kMost, kMost};
    Voxel high{-kMost, -kMost, -kMost};
    for (const Cell& cell : cells_) {  // one brick below is reached by interpolation
        low = smaller(low, before(cell.place, 7));
        high = larger(high, cell.place);
    }
    if (cells_.empty()) low = high = {0, 0, 0};
    low = {low.x >> 2, low.y >> 2, low.z >> 2};
    high = {high.x >> 2, high.y >> 2, high.z >> 2};
    grid.node_min_ = low;
    grid.node_count_ = {high.x - low.x + 1, high.y - low.y + 1, high.z - low.z + 1};
    grid.group_count_ = {(grid.node_count_.x + 7) >> 3, (grid.node_count_.y + 7) >> 3, (grid.node_count_.z + 7) >> 3};
    constexpr int kMostGroups = 1 << 16;  // along an axis, of 256 voxels each: a ray passes them one by one
    const double groups = static_cast<double>(grid.group_count_.x) * grid.group_count_.y * grid.group_count_.z;
    const int longest = std::max({grid.group_count_.x, grid.group_count_.y, grid.group_count_.z});
    if (groups > 1 << 27 || longest > kMostGroups) {
        throw InputError(
            "its voxels are spread too far apart (over 2^27 cubes of 256^3, or 2^16 of them in a row): it "
            "is damaged, or has stray voxels that must go");
    }
    grid.groups_.assign(static_cast<std::size_t>(groups), -1);
}

// The node that holds a brick.
std::size_t SparseGridBuilder::ensure_node(SparseGrid& grid, Voxel place) {
    const int i = (place.x >> 2) - grid.node_min_.x;
    const int j = (place.y >> 2) - grid.node_min_.y;
    const int k = (place.z >> 2) - grid.node_min_.z;
    std::int32_t& group = grid.groups_[grid.group_slot(i >> 3, j >> 3, k >> 3)];
    if (group < 0) {
        group = static_cast<std::int32_t>(grid.slots_.size() / SparseGrid::kNodesPerGroup);
        grid.slots_.resize(grid.slots_.size() + SparseGrid::kNodesPerGroup, -1);
    }
    std::int32_t& node = grid.slots_[static_cast<std::size_t>(group) * SparseGrid::kNodesPerGroup +
                                     static_cast<std::size_t>(((i & 7) << 6) | ((j & 7) << 3) | (k & 7))];
    if (node < 0) {
        node = static_cast<std::int32_t>(grid.nodes_.size());
        grid.nodes_.emplace_back();
    }
    return static_cast<std::size_t>(node);
}

void SparseGridBuilder::place_bricks(SparseGrid& grid) const {
    for (const Cell& cell : cells_) {
        for (int axes = 0; axes < 8; ++axes) {
            if (axes > 0 && ((cell.reached >> axes) & 1U) == 0) continue;
            const Voxel place = before(cell.place, axes);
            grid.nodes_[ensure_node(grid, place)].mask |= std::uint64_t{1} << bit_in_node(place);
        }
    }
    std::uint32_t count = 0;
    for (SparseGrid::Node& node : grid.nodes_) {
        node.first = count;
        count += static_cast<std::uint32_t>(std::popcount(node.mask));
    }
    SparseGrid::Brick nothing;
    nothing.child.fill(SparseGrid::kConstants);
    grid.nodes_.shrink_to_fit();
    grid.bricks_.assign(count, nothing);
    grid.outlines_.resize(count);
    for (const Cell& cell : cells_) {
        const SparseGrid::Node& node = grid.nodes_[ensure_node(grid, cell.place)];
        const SparseGrid::Brick* brick = grid.brick_of(node, cell.place.x & 3, cell.place.y & 3, cell.place.z & 3);
        grid.bricks_[static_cast<std::size_t>(brick - grid.bricks_.data())] = cell.brick;
    }
}

// What the blocks of a cell, and their neighbours on the lower sides, see of its voxels.
void SparseGridBuilder::raise_bounds(const SparseGrid& grid, const Cell& cell,
                                     std::vector<std::array<float, 8>>& bounds) const {
    for (int block = 0; block < 8; ++block) {
        const std::uint16_t child = cell.brick.child[static_cast<std::size_t>(block)];
        LayerMaxima maxima{};
        if (child >= SparseGrid::kConstants) {
            maxima.fill(grid.constants_[child - SparseGrid::kConstants]);
        } else {
            const std::uint16_t* codes = &grid.codes_[cell.brick.base + child];
            std::uint64_t mask = 0;
            std::memcpy(&mask, codes, sizeof(mask));
            LayerMaxima exactly{};
            const std::uint16_t* code = codes + kMaskWords;
            for (std::uint64_t left = mask; left != 0; left &= left - 1, ++code) {
                const int i = std::countr_zero(left);
                float& highest = exactly[layers_of(i >> 4, (i >> 2) & 3, i & 3)];
                highest = std::max(highest, cell.brick.decoded(*code));
            }
            maxima = with_all_layers(exactly);
        }
        const Voxel place{2 * cell.place.x + ((block >> 2) & 1), 2 * cell.place.y + ((block >> 1) & 1),
                          2 * cell.place.z + (block & 1)};
        for (int axes = 0; axes < 8; ++axes) {
            const float highest = maxima[static_cast<std::size_t>(axes)];
            if (!(highest > background_)) continue;
            const Voxel target = before(place, axes);
            const std::int32_t node = grid.node_at(target.x >> 3, target.y >> 3, target.z >> 3);
            const SparseGrid::Brick* brick =
                grid.brick_of(grid.nodes_[static_cast<std::size_t>(node)], (target.x >> 1) & 3, (target.y >> 1) & 3,
                              (target.z >> 1) & 3);
            const auto in_brick =
                static_cast<std::size_t>(((target.x & 1) << 2) | ((target.y & 1) << 1) | (target.z & 1));
            float& bound = bounds[static_cast<std::size_t>(brick - grid.bricks_.data())][in_brick];
            bound = std::max(bound, highest);
        }
    }
}

void SparseGridBuilder::set_bounds(SparseGrid& grid, const std::vector<std::array<float, 8>>& bounds) {
    const auto largest = [](const std::array<float, 8>& of_brick) {
        return *std::max_element(of_brick.begin(), of_brick.end());
    };
    float highest = 0;
    for (const auto& of_brick : bounds)
        highest = std::max(highest, largest(of_brick));
    grid.levels_ = BoundLevels(highest);
    for (std::size_t b = 0; b < bounds.size(); ++b) {
        SparseGrid::Brick& brick = grid.bricks_[b];
        SparseGrid::Outline& outline = grid.outlines_[b];
        brick.bound = static_cast<float>(grid.levels_[grid.levels_.level_of(largest(bounds[b]))]);
        if (!std::isfinite(brick.bound)) {  // no shares of that; users of the grid refuse it by its largest value
            outline.bounds.fill(255);
            continue;
        }
        for (unsigned block = 0; block < 8; ++block) {
            const float bound = bounds[b][block];
            if (!(bound > 0)) continue;  // an infinite scale makes no number of an empty background
            const double share = std::ceil(256 * static_cast<double>(bound) / static_cast<double>(brick.bound)) - 1;
            outline.bounds[block] = static_cast<std::uint8_t>(std::clamp(share, 1.0, 255.0));
            if (outline.bound(block, static_cast<double>(brick.bound)) < static_cast<double>(bound))
                ++outline.bounds[block];
        }
    }
    for (SparseGrid::Node& node : grid.nodes_) {
        const auto count = static_cast<std::uint32_t>(std::popcount(node.mask));
        for (std::uint32_t i = 0; i < count; ++i)
            node.bound = std::max(node.bound, grid.bricks_[node.first + i].bound);
    }
}

void SparseGridBuilder::set_occupied_box(SparseGrid& grid) const {
    if (cells_.empty()) return;  // a box without an inside
    grid.occupied_min_ = {kMost, kMost, kMost};
    grid.occupied_max_ = {-kMost, -kMost, -kMost};
    for (const Cell& cell : cells_) {
        const unsigned seen = cell.reached | 1U;
        for (int axes = 0; axes < 8; ++axes) {
            if (((seen >> axes) & 1U) == 0) continue;
            const Voxel place = before(cell.place, axes);
            grid.occupied_min_ = smaller(grid.occupied_min_, {kBrick * place.x, kBrick * place.y, kBrick * place.z});
            grid.occupied_max_ =
                larger(grid.occupied_max_, {kBrick * (place.x + 1), kBrick * (place.y + 1), kBrick * (place.z + 1)});
        }
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 at{8.0 * (cell.place.x + (corner & 1)) - ((corner & 1) != 0 ? 0 : 1),
                          8.0 * (cell.place.y + ((corner >> 1) & 1)) - ((corner & 2) != 0 ? 0 : 1),
                          8.0 * (cell.place.z + ((corner >> 2) & 1)) - ((corner & 4) != 0 ? 0 : 1)};
            grid.bounds_.add(grid.world_from_index_.point(at));
        }
    }
}

// Where walking its box takes no longer than about the voxels did, and its words no more room than they do.
void SparseGridBuilder::set_directory(SparseGrid& grid) const {
    const Voxel low = grid.occupied_min_;
    const Voxel high = grid.occupied_max_;
    if (cells_.empty() || background_ > 0) return;
    const Voxel count{(high.x - low.x) / kBrick, (high.y - low.y) / kBrick, (high.z - low.z) / kBrick};
    const double places = static_cast<double>(count.x) * count.y * count.z;
    constexpr double kFree = 1 << 18;
    if (std::max(2 * places, BrickDirectory::bytes_of_words(count)) >
        kFree + static_cast<double>(std::max(grid.active_voxels_, grid.codes_.size())))
        return;
    grid.brick_count_ = count;
    set_brick_map(grid);
    BrickDirectory directory(count);
    std::vector<std::uint32_t> sorted;
    for (Voxel at; at.x < count.x; ++at.x) {
        for (at.y = 0; at.y < count.y; ++at.y) {
            for (at.z = 0; at.z < count.z; ++at.z) {
                const Voxel in_all{low.x / kBrick + at.x, low.y / kBrick + at.y, low.z / kBrick + at.z};
                const std::int32_t node = grid.node_at(in_all.x >> 2, in_all.y >> 2, in_all.z >> 2);
                if (node < 0) continue;
                const SparseGrid::Brick* brick = grid.brick_of(grid.nodes_[static_cast<std::size_t>(node)],
                                                               in_all.x & 3, in_all.y & 3, in_all.z & 3);
                if (brick == nullptr || !(brick->bound > 0)) continue;
                directory.add(at, grid.levels_.level_of(brick->bound));
                sorted.push_back(static_cast<std::uint32_t>(brick - grid.bricks_.data()));
            }
        }
    }
    directory.finish();
    grid.directory_ = std::move(directory);
    sort_bricks(grid, std::move(sorted));
    set_cells(grid);
}

// Which of its voxels are not zero.
BrickVoxels SparseGridBuilder::voxels_of(const SparseGrid& grid, const SparseGrid::Brick& brick) {
    BrickVoxels voxels;
    for (unsigned block = 0; block < 8; ++block) {
        const std::uint16_t child = brick.child[block];
        std::uint64_t mask = 0;
        if (child < SparseGrid::kConstants) {
            std::memcpy(&mask, &grid.codes_[brick.base + child], sizeof(mask));
        } else if (grid.constants_[child - SparseGrid::kConstants] != 0) {
            mask = ~mask;
        }
        voxels.set_block(block, mask);
    }
    return voxels;
}

// Of the bricks in the directory.
void SparseGridBuilder::set_cells(SparseGrid& grid) {
    const BrickDirectory& directory = grid.directory_;
    const Voxel count = grid.brick_count_;
    std::vector<BrickVoxels> voxels(directory.size());
    tbb::parallel_for(std::size_t{0}, voxels.size(),
                      [&](std::size_t b) { voxels[b] = voxels_of(grid, grid.bricks_[b]); });
    const BrickVoxels none;
    const auto voxels_at = [&](Voxel at) {
        if (at.x >= count.x || at.y >= count.y || at.z >= count.z) return &none;
        const std::size_t place = directory.place(at);
        return directory.has(place) ? &voxels[directory.brick(place)] : &none;
    };
    tbb::parallel_for(0, count.x, [&](int x) {
        for (Voxel at{x, 0, 0}; at.y < count.y; ++at.y) {
            for (at.z = 0; at.z < count.z; ++at.z) {
                const std::size_t place = directory.place(at);
                if (!directory.has(place)) continue;
                std::array<const BrickVoxels*, 8> bricks{};
                for (int axes = 0; axes < 8; ++axes)
                    bricks[static_cast<std::size_t>(axes)] =
                        voxels_at({at.x + (axes >> 2 & 1), at.y + (axes >> 1 & 1), at.z + (axes & 1)});
                const std::size_t brick = directory.brick(place);
                SparseGrid::Outline& outline = grid.outlines_[brick];
                outline.cells = filled_cells(bricks);
                grid.bricks_[brick].excess = excess_of(outline);
            }
        }
    });
}

// Of the bound of a brick over the mean of those of its cells, in 1/255 of it.
std::uint8_t SparseGridBuilder::excess_of(const SparseGrid::Outline& outline) {
    double sum = 0;
    for (unsigned cell = 0; cell < 64; ++cell)
        sum += outline.bound_in_cell(cell, 1);
    return static_cast<std::uint8_t>(std::lround(255 * (1 - sum / 64)));
}

void SparseGridBuilder::set_brick_map(SparseGrid& grid) {
    const Voxel low = grid.occupied_min_;
    const Voxel count = grid.brick_count_;
    SparseGrid::BrickMap& to_bricks = grid.to_bricks_;
    to_bricks.count = {1.0 * count.x, 1.0 * count.y, 1.0 * count.z};
    for (int axis = 0; axis < 3; ++axis) {
        const Vec3 row = grid.index_from_world_.rows[static_cast<std::size_t>(axis)];
        to_bricks.map.rows[static_cast<std::size_t>(axis)] = (1.0 / kBrick) * row;
        to_bricks.scale[axis] = row[axis] / kBrick;
        for (int other = 0; other < 3; ++other)
            to_bricks.is_diagonal = to_bricks.is_diagonal && (other == axis || row[other] == 0);
    }
    to_bricks.map.offset =
        (1.0 / kBrick) * (grid.index_from_world_.offset - Vec3{1.0 * low.x, 1.0 * low.y, 1.0 * low.z});
}

// Bricks as the directory numbers them; those that it does not have, behind.
void SparseGridBuilder::sort_bricks(SparseGrid& grid, std::vector<std::uint32_t> sorted) {
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> order(grid.bricks_.size(), kNone);
    for (std::size_t i = 0; i < sorted.size(); ++i)
        order[sorted[i]] = static_cast<std::uint32_t>(i);
    for (std::size_t b = 0; b < order.size(); ++b) {
        if (order[b] != kNone) continue;
        order[b] = static_cast<std::uint32_t>(sorted.size());
        sorted.push_back(static_cast<std::uint32_t>(b));
    }
    const auto sort = [&](auto& listed) {
        std::remove_reference_t<decltype(listed)> in_order;
        in_order.reserve(listed.size());
        for (const std::uint32_t b : sorted)
            in_order.push_back(listed[b]);
        listed.swap(in_order);
    };
    sort(grid.bricks_);
    sort(grid.outlines_);
    grid.order_ = std::move(order);
}

std::vector<Voxel> SparseGridBuilder::bricks_of(const SparseGrid& grid) {
    std::vector<Voxel> bricks;
    const auto add_node = [&](const SparseGrid::Node& node, Voxel place) {
        for (std::uint64_t left = node.mask; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left);
            bricks.push_back({kBrick * (4 * place.x + (bit >> 4)), kBrick * (4 * place.y + ((bit >> 2) & 3)),
                              kBrick * (4 * place.z + (bit & 3))});
        }
    };
    for (std::size_t g = 0; g < grid.groups_.size(); ++g) {
        if (grid.groups_[g] < 0) continue;
        const auto wide = static_cast<std::size_t>(grid.group_count_.z);
        const auto high = static_cast<std::size_t>(grid.group_count_.y);
        const Voxel first{grid.node_min_.x + 8 * static_cast<int>(g / (wide * high)),
                          grid.node_min_.y + 8 * static_cast<int>(g / wide % high),
                          grid.node_min_.z + 8 * static_cast<int>(g % wide)};
        for (int slot = 0; slot < static_cast<int>(SparseGrid::kNodesPerGroup); ++slot) {
            const Voxel place{first.x + (slot >> 6), first.y + ((slot >> 3) & 7), first.z + (slot & 7)};
            const std::int32_t node = grid.node_at(place.x, place.y, place.z);
            if (node >= 0) add_node(grid.nodes_[static_cast<std::size_t>(node)], place);
        }
    }
    std::sort(bricks.begin(), bricks.end(), is_before);
    return bricks;
}

SparseGrid SparseGridBuilder::finish(const Affine& world_from_index, std::size_t active_voxels) && {
    SparseGrid grid;
    grid.world_from_index_ = world_from_index;
    grid.index_from_world_ = world_from_index.inverse();
    grid.active_voxels_ = active_voxels;
    grid.constants_ = {background_};
    grid.constants_.insert(grid.constants_.end(), constants_.begin(), constants_.end());
    grid.codes_.assign(codes_.begin(), codes_.end());
    std::vector<std::uint16_t>().swap(codes_);

    set_node_box(grid);
    place_bricks(grid);
    std::vector<std::array<float, 8>> bounds(grid.bricks_.size());
    for (auto& of_brick : bounds)
        of_brick.fill(background_);
    for (const Cell& cell : cells_)
        raise_bounds(grid, cell, bounds);
    set_bounds(grid, bounds);
    set_occupied_box(grid);
    set_directory(grid);
    grid.max_ = static_cast<double>(background_);
    for (const SparseGrid::Node& node : grid.nodes_)
        grid.max_ = std::max(grid.max_, static_cast<double>(node.bound));
    return grid;
}

}  // namespace fluovox
