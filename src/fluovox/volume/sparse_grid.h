#pragma once

#include "fluovox/core/bits.h"
#include "fluovox/core/bounds.h"
#include "fluovox/core/huge_pages.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/bound_levels.h"
#include "fluovox/volume/brick_directory.h"
#include "fluovox/volume/fixed_point.h"
#include "fluovox/volume/grid_info.h"
#include "fluovox/volume/vdb_sampler.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
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

/// The largest whole number that is not above `x`, for |x| < 2^31; no call of a library function.
constexpr int floor_to_int(double x) {
    const int whole = static_cast<int>(x);
    return whole - (static_cast<double>(whole) > x ? 1 : 0);
}

/// A sparse scalar field made once for tracking. Voxels that are not zero are stored in 16 bits behind a mask per block
/// of 4^3; constant bricks and blocks take no room and are exact. In other bricks of 8^3 the largest value is exact,
/// and the rest are rounded to steps of equal ratio that reach from it to the smallest: 1 part in 2^17 where they are
/// within a factor 2, in 2^14 within 256, in 2^12 within 10^9. Upper bounds are kept over blocks, bricks and nodes of
/// 4^3 bricks. Between voxel centres the field is trilinear, and the bounds hold for that. Memory follows the active
/// voxels. Immutable: any number of threads may read it.
class SparseGrid {
public:
    static constexpr int kBlockSize = 4;  ///< voxels along a block
    static constexpr int kBrickSize = 8;  ///< voxels along a brick
    static constexpr int kNodeSize = 32;  ///< voxels along a node

    enum class Tree { Free, Keep };

    /// Reads one grid of a VDB file; `units` turns what the file says of itself into factors for its values and
    /// lengths. The tree of the file takes many times the room: it is freed, or kept to compare with. Throws InputError
    /// for anything that is not a field of finite values >= 0 with an affine transform.
    static SparseGrid load(const std::filesystem::path& file, const std::string& name,
                           const std::function<GridScale(const GridMetadata&)>& units, Tree tree = Tree::Free);

    /// Values `f(voxel)` for the voxels from `min` up to but not including `max`, zero elsewhere.
    static SparseGrid from_function(Voxel min, Voxel max, const Affine& world_from_index,
                                    const std::function<double(Voxel)>& f);

    /// Value of a voxel.
    float value(Voxel voxel) const {
        if (!has_directory()) return value_from_root(voxel);
        return value_in_box({voxel.x - occupied_min_.x, voxel.y - occupied_min_.y, voxel.z - occupied_min_.z});
    }
    /// The same by the tree alone.
    float value_from_root(Voxel voxel) const {
        const std::int32_t node = node_at(voxel.x >> 5, voxel.y >> 5, voxel.z >> 5);
        if (node < 0) return constants_[0];
        const Brick* brick = brick_of(nodes_[static_cast<std::size_t>(node)], (voxel.x >> 3) & 3, (voxel.y >> 3) & 3,
                                      (voxel.z >> 3) & 3);
        return brick == nullptr ? constants_[0] : value_in(*brick, voxel);
    }

    /// Value of one of the eight voxels around an index-space position, drawn with the trilinear weights (in steps of
    /// 2^-18) by 54 random bits: its expectation is the trilinear value. Valid wherever the result is used linearly.
    float tap(Vec3 index_position, std::uint64_t bits) const { return value(FixedPoint(index_position).rounded(bits)); }

    /// The trilinear field at a world position (micrometres); at an index-space position, all eight voxels from the
    /// root.
    double trilinear(Vec3 world_um) const;
    double trilinear_from_root(Vec3 index_position) const;

    const Affine& index_from_world() const { return index_from_world_; }
    const Affine& world_from_index() const { return world_from_index_; }
    /// World box outside which the field is `background()`.
    const Bounds& bounds() const { return bounds_; }
    double background() const { return static_cast<double>(constants_[0]); }
    /// Largest voxel value.
    double max() const { return max_; }
    std::size_t active_voxels() const { return active_voxels_; }
    /// About how many voxels are not zero, active or not.
    std::size_t filled_voxels() const { return std::max(active_voxels_, codes_.size()); }
    /// What it was made of, where that was kept; else empty.
    const std::shared_ptr<const VdbTree>& tree() const { return tree_; }
    /// True where the box of all bricks is small enough for a list of them by place: BoundVisitor needs it.
    bool has_directory() const { return !directory_.empty(); }
    std::size_t memory_bytes() const;

private:
    friend class SparseGridBuilder;
    friend class MajorantWalk;
    friend class BoundVisitor;
    friend class ShadowGrid;

    /// Children at or above this are constants, not blocks.
    static constexpr std::uint16_t kConstants = 0xfe00;

    /// 8^3 voxels in eight blocks; the first one lies at codes_[base].
    struct Brick {
        std::uint32_t base = 0;
        float bound = 0;                       // a level that no block is above
        float largest = 0;                     // value
        std::uint8_t shift = 0;                // of the codes
        std::uint8_t excess = 0;               // of the bound over its mean by cells, in 1/255 of it
        std::array<std::uint16_t, 8> child{};  // a block, from `base`; or kConstants + a constant

        // What a code stands for: so many steps below the largest, in the order of floating-point numbers.
        float decoded(std::uint16_t code) const {
            return std::bit_cast<float>(std::bit_cast<std::uint32_t>(largest) - (std::uint32_t{code} << shift));
        }
    };
    // What tracking asks of a brick before it asks for its voxels.
    struct Outline {
        std::array<std::uint8_t, 8> bounds{};  // of the blocks: 0, or in 1/256 of the brick's, less one
        std::uint64_t cells = 0;               // see filled_cells; where there is a directory

        double bound(unsigned block, double of_brick) const {
            const unsigned share = bounds[block];
            return share == 0 ? 0 : of_brick * ((share + 1) * (1.0 / 256));
        }
        double bound_in_cell(unsigned cell, double of_brick) const {
            return has(cell) ? bound(block_of(cell), of_brick) : 0;
        }
        bool is_full() const { return cells == ~std::uint64_t{0}; }
        bool has(unsigned cell) const { return (cells >> cell & 1U) != 0; }
        static unsigned block_of(unsigned cell) { return (cell >> 3U & 4U) | (cell >> 2U & 2U) | (cell >> 1U & 1U); }
    };
    /// 4^3 bricks; only those that differ from the background are there, one after the other.
    struct Node {
        std::uint64_t mask = 0;
        std::uint32_t first = 0;  // brick
        float bound = 0;          // largest of the bricks
    };

    /// From the world to the bricks of a box: coordinates count bricks from its corner.
    struct BrickMap {
        Affine map;
        Vec3 scale;               // the diagonal of `map`
        bool is_diagonal = true;  // most are: three products do
        Vec3 count;               // bricks along the box

        Vec3 point(Vec3 p) const { return direction(p) + map.offset; }
        Vec3 direction(Vec3 d) const {
            return is_diagonal ? Vec3{scale.x * d.x, scale.y * d.y, scale.z * d.z} : map.direction(d);
        }
    };

    SparseGrid() = default;

    // Index of the node with these node coordinates, or -1.
    std::int32_t node_at(int x, int y, int z) const {
        const int i = x - node_min_.x;
        const int j = y - node_min_.y;
        const int k = z - node_min_.z;
        if (static_cast<unsigned>(i) >= static_cast<unsigned>(node_count_.x) ||
            static_cast<unsigned>(j) >= static_cast<unsigned>(node_count_.y) ||
            static_cast<unsigned>(k) >= static_cast<unsigned>(node_count_.z)) {
            return -1;
        }
        const std::int32_t group = groups_[group_slot(i >> 3, j >> 3, k >> 3)];
        if (group < 0) return -1;
        return slots_[static_cast<std::size_t>(group) * kNodesPerGroup +
                      static_cast<std::size_t>(((i & 7) << 6) | ((j & 7) << 3) | (k & 7))];
    }
    std::size_t group_slot(int i, int j, int k) const {
        return (static_cast<std::size_t>(i) * static_cast<std::size_t>(group_count_.y) + static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(group_count_.z) +
               static_cast<std::size_t>(k);
    }
    const Brick* brick_of(const Node& node, int x, int y, int z) const {
        const std::uint64_t bit = std::uint64_t{1} << static_cast<unsigned>((x << 4) | (y << 2) | z);
        if ((node.mask & bit) == 0) return nullptr;
        const std::size_t in_tree = node.first + static_cast<unsigned>(count_bits(node.mask & (bit - 1)));
        return &bricks_[order_.empty() ? in_tree : order_[in_tree]];
    }
    // Of a voxel counted from the corner of the occupied box, by the directory.
    float value_in_box(Voxel voxel) const {
        const int i = voxel.x >> 3;
        const int j = voxel.y >> 3;
        const int k = voxel.z >> 3;
        if (static_cast<unsigned>(i) >= static_cast<unsigned>(brick_count_.x) ||
            static_cast<unsigned>(j) >= static_cast<unsigned>(brick_count_.y) ||
            static_cast<unsigned>(k) >= static_cast<unsigned>(brick_count_.z)) {
            return constants_[0];
        }
        const std::size_t place = directory_.place({i, j, k});
        return directory_.has(place) ? value_in(bricks_[directory_.brick(place)], voxel) : constants_[0];
    }
    // Of a voxel of the brick.
    float value_in(const Brick& brick, Voxel voxel) const {
        const auto block = static_cast<std::size_t>((voxel.x & 4) | ((voxel.y & 4) >> 1) | ((voxel.z & 4) >> 2));
        const std::uint16_t child = brick.child[block];
        if (child >= kConstants) return constants_[child - kConstants];
        const std::uint16_t* codes = &codes_[brick.base + child];
        std::uint64_t mask = 0;
        std::memcpy(&mask, codes, sizeof(mask));
        const std::uint64_t bit = std::uint64_t{1}
                                  << static_cast<unsigned>(((voxel.x & 3) << 4) | ((voxel.y & 3) << 2) | (voxel.z & 3));
        if ((mask & bit) == 0) return 0;
        return brick.decoded(codes[4 + count_bits(mask & (bit - 1))]);
    }
    const Outline& outline_of(const Brick& brick) const {
        return outlines_[static_cast<std::size_t>(&brick - bricks_.data())];
    }

    static constexpr std::size_t kNodesPerGroup = 512;

    Affine world_from_index_, index_from_world_;
    Voxel node_min_, node_count_, group_count_;
    Voxel occupied_min_, occupied_max_;  // box of the bricks with a bound above the background, in voxels
    std::vector<std::int32_t> groups_;   // of 8^3 nodes, in the box of nodes: one in slots_, or -1
    std::vector<std::int32_t> slots_;    // per group and place in it: a node, or -1
    std::vector<Node> nodes_;
    Voxel brick_count_;                 // of the occupied box
    BrickMap to_bricks_;                // from its corner
    BrickDirectory directory_;          // in that box; empty where the box is large
    std::vector<std::uint32_t> order_;  // of the bricks of nodes among bricks_; empty where they lie so
    BoundLevels levels_;
    HugePageVector<Brick> bricks_;
    HugePageVector<Outline> outlines_;     // of these
    HugePageVector<std::uint16_t> codes_;  // per block: its mask (4 words), then the voxels that are not zero
    std::vector<float> constants_ = {0};   // [0] is the background
    Bounds bounds_;
    double max_ = 0;
    std::size_t active_voxels_ = 0;
    std::shared_ptr<const VdbTree> tree_;
};

}  // namespace fluovox
