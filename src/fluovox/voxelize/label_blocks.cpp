#include "fluovox/voxelize/label_blocks.h"

#include "fluovox/core/error.h"
#include "fluovox/core/version.h"
#include "fluovox/volume/vdb_internal.h"

#include <fmt/format.h>
#include <openvdb/tools/Count.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <set>

namespace fluovox {
namespace {

using FloatLeaf = openvdb::FloatTree::LeafNodeType;
using LabelLeaf = openvdb::Int64Tree::LeafNodeType;

/// One place of a leaf in a layer, cut out of it.
class Block {
public:
    Block(const LabelSlab& slab, const openvdb::Coord& origin, std::int64_t z_end) : origin_(origin) {
        const auto columns = std::min<std::int64_t>(LabelSlab::kSide, slab.width() - origin.x());
        const auto rows = std::min<std::int64_t>(LabelSlab::kSide, slab.height() - origin.y());
        for (std::int64_t z = origin.z(); z < z_end; ++z) {
            for (std::int64_t y = 0; y < rows; ++y) {
                const std::uint32_t* const row = slab.row(origin.y() + y, z) + origin.x();
                for (std::int64_t x = 0; x < columns; ++x)
                    numbers_[static_cast<std::size_t>((x * 8 + y) * 8 + (z - origin.z()))] = row[x];
            }
        }
    }

    /// One label everywhere, which may be none.
    bool uniform() const {
        return std::all_of(numbers_.begin(), numbers_.end(), [&](std::uint32_t n) { return n == numbers_[0]; });
    }
    std::uint32_t first() const { return numbers_[0]; }
    const openvdb::Coord& origin() const { return origin_; }

    /// A leaf of what `value_of(number)` is not zero of; null when it is nowhere.
    template <class Leaf, class ValueOf>
    std::unique_ptr<Leaf> leaf(const ValueOf& value_of) const {
        std::unique_ptr<Leaf> leaf;
        for (std::size_t i = 0; i < numbers_.size(); ++i) {
            const auto value = value_of(numbers_[i]);
            if (value == 0) continue;
            if (!leaf) leaf = std::make_unique<Leaf>(origin_, typename Leaf::ValueType(0), false);
            leaf->setValueOn(static_cast<openvdb::Index>(i), value);
        }
        return leaf;
    }

private:
    openvdb::Coord origin_;
    std::array<std::uint32_t, 512> numbers_{};
};

/// What one block adds to one grid: a leaf or, without, a tile.
template <class Leaf>
struct Addition {
    std::size_t grid = 0;
    openvdb::Coord origin;
    std::unique_ptr<Leaf> leaf;
    typename Leaf::ValueType tile = 0;
};

struct RowOfBlocks {
    std::vector<Addition<FloatLeaf>> floats;
    std::vector<Addition<LabelLeaf>> labels;
};

std::int64_t label_value(const BlockLabel& label) {
    return label.grid < 0 ? 0 : static_cast<std::int64_t>(label.label);
}

void add_block(const Block& block, const std::vector<BlockLabel>& labels, std::size_t grids, bool with_labels,
               RowOfBlocks& row) {
    if (block.uniform()) {
        const BlockLabel& label = labels[block.first()];
        if (label.grid < 0) return;
        row.floats.push_back({static_cast<std::size_t>(label.grid), block.origin(), nullptr, label.value});
        if (with_labels) row.labels.push_back({0, block.origin(), nullptr, label_value(label)});
        return;
    }
    for (std::size_t grid = 0; grid < grids; ++grid) {
        auto leaf = block.leaf<FloatLeaf>([&](std::uint32_t number) {
            return labels[number].grid == static_cast<int>(grid) ? labels[number].value : 0.0F;
        });
        if (leaf) row.floats.push_back({grid, block.origin(), std::move(leaf), 0.0F});
    }
    if (!with_labels) return;
    auto leaf = block.leaf<LabelLeaf>([&](std::uint32_t number) { return label_value(labels[number]); });
    if (leaf) row.labels.push_back({0, block.origin(), std::move(leaf), 0});
}

template <class Tree, class Leaf>
void put(Tree& tree, Addition<Leaf>& addition) {
    if (addition.leaf) {
        tree.addLeaf(addition.leaf.release());
    } else {
        tree.addTile(1, addition.origin, addition.tile, true);
    }
}

/// 32 bits a label where they do.
openvdb::GridBase::Ptr narrowed(const openvdb::Int64Grid::Ptr& labels) {
    if (openvdb::tools::minMax(labels->tree()).max() > std::numeric_limits<std::int32_t>::max()) return labels;
    const auto narrow = new_grid<openvdb::Int32Grid>();
    narrow->tree().root() = labels->tree().root();
    narrow->setTransform(labels->transformPtr());
    narrow->openvdb::MetaMap::operator=(*labels);
    return narrow;
}

}  // namespace

LabelSlab::LabelSlab(std::int64_t width, std::int64_t height)
    : width_(width), height_(height), numbers_(static_cast<std::size_t>(kSide * width * height), 0) {}

BlockFiller::BlockFiller(const std::vector<BlockGrid>& grids, double max_bytes) : max_bytes_(max_bytes) {
    for (const BlockGrid& grid : grids) {
        if (grid.dye.empty()) {
            labels_ = new_grid<openvdb::Int64Grid>();
            continue;
        }
        dyes_.push_back(grid.dye);
        floats_.push_back(new_grid<openvdb::FloatGrid>());
        floats_.back()->setGridClass(openvdb::GRID_FOG_VOLUME);
    }
}

void BlockFiller::add(const LabelSlab& slab, std::int64_t z, const std::vector<BlockLabel>& labels) {
    constexpr std::int64_t kSide = LabelSlab::kSide;
    const std::int64_t z_begin = z - z % kSide;
    const auto rows = static_cast<std::size_t>((slab.height() + kSide - 1) / kSide);
    std::vector<RowOfBlocks> found(rows);
    tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t row) {
        for (std::int64_t x = 0; x < slab.width(); x += kSide) {
            const openvdb::Coord origin(static_cast<int>(x), static_cast<int>(row) * static_cast<int>(kSide),
                                        static_cast<int>(z_begin));
            add_block(Block(slab, origin, z + 1), labels, floats_.size(), labels_ != nullptr, found[row]);
        }
    });
    for (RowOfBlocks& row : found) {
        constexpr double kFloatLeafBytes = 2300;
        constexpr double kLabelLeafBytes = 4400;
        for (auto& addition : row.floats) {
            bytes_ += addition.leaf ? kFloatLeafBytes : 0;
            put(floats_[addition.grid]->tree(), addition);
        }
        for (auto& addition : row.labels) {
            bytes_ += addition.leaf ? kLabelLeafBytes : 0;
            put(labels_->tree(), addition);
        }
    }
    if (bytes_ <= max_bytes_) return;
    throw InputError(
        fmt::format("the grids would take more than {:.3g} GiB; choose fewer labels, a part with --clip, "
                    "or raise --max-bytes",
                    max_bytes_ / (1LL << 30)));
}

std::vector<BlockGrid> BlockFiller::finish(const openvdb::math::Transform::Ptr& transform) {
    std::vector<BlockGrid> grids;
    for (std::size_t i = 0; i < floats_.size(); ++i) {
        openvdb::tools::pruneTiles(floats_[i]->tree());
        floats_[i]->setTransform(transform->copy());
        grids.push_back({dyes_[i], floats_[i]});
    }
    if (labels_) {
        openvdb::tools::pruneTiles(labels_->tree());
        labels_->setTransform(transform->copy());
        labels_->setName("labels");
        labels_->insertMeta("length_unit", openvdb::StringMetadata("um"));
        labels_->insertMeta("fluovox_version", openvdb::StringMetadata(version()));
        grids.push_back({"", narrowed(labels_)});
    }
    return grids;
}

}  // namespace fluovox
