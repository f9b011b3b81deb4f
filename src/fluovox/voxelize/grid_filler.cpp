#include "fluovox/voxelize/grid_filler.h"

#include "fluovox/core/error.h"
#include "fluovox/volume/vdb_internal.h"
#include "fluovox/voxelize/flood.h"

#include <openvdb/tools/Prune.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
using Leaves = std::vector<std::unique_ptr<Leaf>>;

class GridFiller {
public:
    GridFiller(const BlockLattice& lattice, const VoxelizeSettings& settings)
        : lattice_(lattice), settings_(settings), grid_(new_grid<openvdb::FloatGrid>()), tree_(grid_->tree()) {
        using openvdb::math::Transform;
        grid_->setTransform(Transform::createLinearTransform(settings.voxel_size_um));
        grid_->transform().postTranslate(openvdb::Vec3d(settings.voxel_size_um / 2));
        grid_->setGridClass(openvdb::GRID_FOG_VOLUME);
    }

    /// Leaves of one tile, made by any thread.
    Leaves make_leaves(const TileTask& task, const TileResult& result) const {
        Leaves leaves;
        leaves.reserve(result.blocks.size());
        for (const auto& block : result.blocks) {
            auto leaf = std::make_unique<Leaf>(origin(block.x, task), 0.0F, false);
            const BlockValues& values = result.values[block.values];
            // What rounding leaves beside a surface is no voxel of it; a speck far smaller than a voxel is.
            constexpr float kNothing = 1e-12F;
            constexpr float kNothingBesideOthers = 1e-6F;
            const float least =
                std::max(kNothing, kNothingBesideOthers * *std::max_element(values.begin(), values.end()));
            for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
                if (!(values[i] > least)) continue;
                leaf->setValueOn(i, static_cast<float>(settings_.value * static_cast<double>(values[i])));
            }
            leaves.push_back(std::move(leaf));
        }
        return leaves;
    }
    void add(const TileTask& task, const TileResult& result, Leaves leaves) {
        for (auto& leaf : leaves)
            tree_.addLeaf(leaf.release());
        const auto value = static_cast<float>(settings_.value);
        for (const auto& run : result.full) {
            for (std::int32_t x = run.begin; x < run.end; ++x)
                tree_.addTile(1, origin(x, task), value, true);
        }
    }
    /// Fills what a flood left dry.
    void add(const std::vector<Flood::Enclosed>& enclosed) {
        const auto value = static_cast<float>(settings_.value);
        for (const auto& part : enclosed) {
            TileTask task;
            task.y = part.y;
            task.z = part.z;
            for (std::int32_t x = part.begin; x < part.end; ++x) {
                if (part.voxels.all()) {
                    tree_.addTile(1, origin(x, task), value, true);
                    continue;
                }
                Leaf* const leaf = tree_.touchLeaf(origin(x, task));
                for (std::size_t i = 0; i < part.voxels.size(); ++i)
                    if (part.voxels[i]) leaf->setValueOn(static_cast<openvdb::Index>(i), value);
            }
        }
    }
    openvdb::FloatGrid::Ptr finish() {
        openvdb::tools::pruneTiles(grid_->tree());
        if (settings_.clip_um) clip();
        return grid_;
    }

private:
    openvdb::Coord origin(std::int32_t x, const TileTask& task) const {
        return {lattice_.corner[0] + kBlockSide * x, lattice_.corner[1] + kBlockSide * task.y,
                lattice_.corner[2] + kBlockSide * task.z};
    }
    /// Voxels that a face of the box cuts keep the share of them that is inside.
    void clip() {
        // So that a face on the lattice is on it whatever the rounding.
        constexpr double kOnLattice = 1e-6;
        constexpr double kFar = 1 << 30;
        openvdb::CoordBBox box;
        std::array<std::array<double, 2>, 3> share{};
        for (int axis = 0; axis < 3; ++axis) {
            const double low = std::clamp(settings_.clip_um->min[axis] / settings_.voxel_size_um, -kFar, kFar);
            const double high = std::clamp(settings_.clip_um->max[axis] / settings_.voxel_size_um, -kFar, kFar);
            box.min()[axis] = static_cast<int>(std::floor(low + kOnLattice));
            box.max()[axis] = std::max(box.min()[axis], static_cast<int>(std::ceil(high - kOnLattice)) - 1);
            const bool one = box.min()[axis] == box.max()[axis];
            const auto i = static_cast<std::size_t>(axis);
            share[i] = {one ? high - low : box.min()[axis] + 1 - low, one ? 1 : high - box.max()[axis]};
        }
        openvdb::GridBase& grid = *grid_;
        grid.clip(box);
        openvdb::CoordBBox filled;
        if (!grid.baseTree().evalActiveVoxelBoundingBox(filled)) return;
        for (int axis = 0; axis < 3; ++axis) {
            for (std::size_t side = 0; side < 2; ++side) {
                const double kept = share[static_cast<std::size_t>(axis)][side];
                if (kept > 1 - kOnLattice) continue;
                openvdb::CoordBBox slab = filled;
                slab.min()[axis] = slab.max()[axis] = side == 0 ? box.min()[axis] : box.max()[axis];
                if (slab.min()[axis] >= filled.min()[axis] && slab.max()[axis] <= filled.max()[axis])
                    scale(slab, static_cast<float>(kept));
            }
        }
    }
    /// Multiplies the voxels of a slab, block by block, as most of it is empty.
    void scale(const openvdb::CoordBBox& slab, float factor) {
        const auto blocks = [](const openvdb::Coord& voxel) {
            return openvdb::Coord(voxel.x() & ~(kBlockSide - 1), voxel.y() & ~(kBlockSide - 1),
                                  voxel.z() & ~(kBlockSide - 1));
        };
        const openvdb::Coord first = blocks(slab.min());
        openvdb::tree::ValueAccessor<openvdb::FloatTree> tree(grid_->tree());
        for (int x = first.x(); x <= slab.max().x(); x += kBlockSide) {
            for (int y = first.y(); y <= slab.max().y(); y += kBlockSide) {
                for (int z = first.z(); z <= slab.max().z(); z += kBlockSide) {
                    const openvdb::Coord origin(x, y, z);
                    if (tree.probeConstLeaf(origin) == nullptr && !tree.isValueOn(origin)) continue;
                    Leaf* const leaf = tree.touchLeaf(origin);
                    for (auto voxel = leaf->beginValueOn(); voxel; ++voxel)
                        if (slab.isInside(voxel.getCoord())) voxel.setValue(*voxel * factor);
                }
            }
        }
    }

    BlockLattice lattice_;
    VoxelizeSettings settings_;
    openvdb::FloatGrid::Ptr grid_;
    openvdb::tree::ValueAccessor<openvdb::FloatTree> tree_;
};

/// Sum of all values.
double filled_voxels(const openvdb::FloatGrid& grid) {
    double sum = 0;
    for (auto at = grid.cbeginValueOn(); at; ++at)
        sum += static_cast<double>(*at) * static_cast<double>(at.getVoxelCount());
    return sum;
}

struct FilledTile {
    TileTask task;
    TileResult result;
    Leaves leaves;
};

}  // namespace

VoxelizedGrid fill_grid(const BlockLattice& lattice, const VoxelizeSettings& settings, const TileBins& bins,
                        Progress& progress, const FillTile& fill) {
    GridFiller filler(lattice, settings);
    VoxelizeReport report;
    Flood flood;
    progress.start("voxelizing", static_cast<long long>(bins.size()));
    // Tiles are filled in any order, a few at a time, and go into the tree in theirs, so that every sum is the same
    // for any number of threads.
    constexpr std::size_t kBatch = 16;
    constexpr std::size_t kBatchesAtOnce = 64;
    const double voxel_um3 = std::pow(settings.voxel_size_um, 3);
    std::size_t next = 0;
    const auto take = [&](tbb::flow_control& flow) {
        const std::size_t begin = next;
        if (begin >= bins.size() || progress.stopped()) flow.stop();
        next += kBatch;
        return begin;
    };
    const auto work = [&](std::size_t begin) {
        std::vector<FilledTile> tiles;
        for (std::size_t i = begin; i < std::min(begin + kBatch, bins.size()); ++i) {
            FilledTile& tile = tiles.emplace_back();
            tile.task = bins.task(i);
            tile.result = fill(tile.task);
            tile.leaves = filler.make_leaves(tile.task, tile.result);
            tile.result.values = {};
            progress.advance(1);
        }
        return tiles;
    };
    const auto put = [&](std::vector<FilledTile> tiles) {
        for (FilledTile& tile : tiles) {
            filler.add(tile.task, tile.result, std::move(tile.leaves));
            report.volume_um3 += tile.result.volume * voxel_um3;
            report.capped_um3 += tile.result.winding_volume * voxel_um3;
            report.decided_by_winding += tile.result.decided_by_winding;
            flood.add(tile.task, tile.result);
        }
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(kBatchesAtOnce,
                           tbb::make_filter<void, std::size_t>(filter_mode::serial_in_order, take) &
                               tbb::make_filter<std::size_t, std::vector<FilledTile>>(filter_mode::parallel, work) &
                               tbb::make_filter<std::vector<FilledTile>, void>(filter_mode::serial_in_order, put));
    if (settings.inside == InsideRule::Flood && !progress.stopped()) filler.add(flood.enclosed());
    auto grid = filler.finish();
    report.voxels = grid->baseTree().activeVoxelCount();
    if (settings.inside == InsideRule::Flood || settings.clip_um)
        report.volume_um3 = voxel_um3 * filled_voxels(*grid) / settings.value;
    if (report.voxels == 0 && !progress.stopped()) {
        throw InputError(settings.clip_um
                             ? "nothing of it is inside the box of --bbox or --clip: the grid would be empty"
                             : "nothing is inside the surface: the grid would be empty");
    }
    if (!std::isfinite(report.volume_um3) && !progress.stopped()) {
        throw InputError(
            "the surface is too open to have an inside: its volume is not a number; close it, or fill a layer along "
            "it with --shell");
    }
    return {DyeGrid(std::make_shared<DyeGrid::Impl>(DyeGrid::Impl{grid})), report};
}

}  // namespace fluovox
