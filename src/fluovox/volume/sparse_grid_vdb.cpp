// Makes the render-time grid from a VDB tree: the one meeting point of the two.

#include "fluovox/core/error.h"
#include "fluovox/core/memory.h"
#include "fluovox/volume/sparse_grid_builder.h"
#include "fluovox/volume/vdb_internal.h"

#include <openvdb/openvdb.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using openvdb::FloatGrid;
using FloatLeaf = FloatGrid::TreeType::LeafNodeType;

Affine affine_of(const FloatGrid& grid, double um_per_unit, const std::string& place) {
    if (!grid.transform().isLinear()) throw InputError(place + ": its transform is not affine (a frustum?)");
    const auto map = grid.transform().baseMap()->getAffineMap()->getMat4();  // row vectors: p M
    Affine affine;
    for (int row = 0; row < 3; ++row) {
        affine.rows[static_cast<std::size_t>(row)] = um_per_unit * Vec3{map(0, row), map(1, row), map(2, row)};
        affine.offset[row] = um_per_unit * map(3, row);
    }
    const double volume = dot(affine.rows[0], cross(affine.rows[1], affine.rows[2]));
    if (!(std::abs(volume) > 0) || !std::isfinite(volume)) throw InputError(place + ": its transform is singular");
    return affine;
}

// Tiles of the tree's upper levels, active or not, that differ from the background.
template <class Node>
void add_tiles(const Node& node, float background, float scale, SparseGridBuilder& builder) {
    for (auto tile = node.cbeginValueAll(); tile; ++tile) {
        const float value = tile.getValue();
        if (value == background) continue;
        const openvdb::Coord origin = tile.getCoord();
        builder.add_constant({origin.x(), origin.y(), origin.z()}, static_cast<int>(Node::ChildNodeType::DIM),
                             scale * value);
    }
}

void add_leaf(const FloatLeaf& leaf, float factor, SparseGridBuilder& builder) {
    std::array<float, FloatLeaf::SIZE> values{};
    const float* data = leaf.buffer().data();
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = factor * data[i];
    const openvdb::Coord origin = leaf.origin();
    builder.add_brick({origin.x(), origin.y(), origin.z()}, values.data());
}

void add_leaves(std::span<const FloatLeaf* const> leaves, float factor, SparseGridBuilder& builder) {
    for (const FloatLeaf* leaf : leaves)
        add_leaf(*leaf, factor, builder);
}

// Many are packed in parts, side by side: a few at a time, so that they take little memory. Few are packed one by one:
// what a second thread frees stays with it, and is too much beside a small grid (1 MB, where 256^3 tubes take 4.5 MB).
void add_all_leaves(const FloatGrid& grid, float factor, SparseGridBuilder& builder) {
    constexpr std::size_t kInPart = 1024;
    constexpr std::size_t kParts = 32;
    std::vector<const FloatLeaf*> leaves;
    leaves.reserve(grid.tree().leafCount());
    grid.tree().getNodes(leaves);
    const std::span<const FloatLeaf* const> all(leaves);
    if (all.size() <= kInPart * kParts) return add_leaves(all, factor, builder);
    for (std::size_t first = 0; first < all.size(); first += kInPart * kParts) {
        const auto some = all.subspan(first, std::min(kInPart * kParts, all.size() - first));
        const auto part_of = [&](std::size_t i) {
            return some.subspan(i * kInPart, std::min(kInPart, some.size() - i * kInPart));
        };
        std::vector<SparseGridBuilder> parts((some.size() + kInPart - 1) / kInPart,
                                             SparseGridBuilder(factor * grid.background()));
        tbb::parallel_for(std::size_t{0}, parts.size(),
                          [&](std::size_t i) { add_leaves(part_of(i), factor, parts[i]); });
        for (std::size_t i = 0; i < parts.size(); ++i)
            if (!builder.append(std::move(parts[i]))) add_leaves(part_of(i), factor, builder);
    }
}

// All below the root.
void add_tree(const FloatGrid& grid, float factor, SparseGridBuilder& builder) {
    using Lower = FloatGrid::TreeType::RootNodeType::ChildNodeType::ChildNodeType;
    const float background = grid.background();
    for (auto upper = grid.tree().root().cbeginChildOn(); upper; ++upper) {
        add_tiles(*upper, background, factor, builder);
        for (auto lower = upper->cbeginChildOn(); lower; ++lower)
            add_tiles<Lower>(*lower, background, factor, builder);
    }
    add_all_leaves(grid, factor, builder);
}

}  // namespace

SparseGrid SparseGrid::load(const std::filesystem::path& file, const std::string& name,
                            const std::function<GridScale(const GridMetadata&)>& units, Tree tree) {
    FloatGrid::ConstPtr grid = load_float_grid(file, name);
    const std::string place = file.string() + ": grid \"" + grid->getName() + '"';
    const GridScale scale = units(grid_metadata(*grid));
    const auto factor = static_cast<float>(scale.value);
    const float background = grid->background();
    SparseGridBuilder builder(factor * background);

    for (auto tile = grid->tree().root().cbeginValueAll(); tile; ++tile) {
        if (tile.getValue() != background)
            throw InputError(place +
                             ": has a constant tile of 4096^3 voxels, which no specimen fills; give an even dye as a "
                             "medium with a region and a concentration instead of a grid");
    }
    const Affine affine = affine_of(*grid, scale.length, place);
    const std::size_t active = grid->activeVoxelCount();
    try {
        add_tree(*grid, factor, builder);
        std::shared_ptr<const VdbTree> kept;
        if (tree == Tree::Keep) kept = std::make_shared<const VdbTree>(VdbTree{grid, factor});
        grid.reset();
        SparseGrid result = std::move(builder).finish(affine, active);
        result.tree_ = std::move(kept);
        release_freed_memory();  // the tree is many times larger than what is made of it
        return result;
    } catch (const InputError& e) {
        throw InputError(place + ": " + e.what());
    }
}

}  // namespace fluovox
