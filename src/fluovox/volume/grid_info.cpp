#include "fluovox/volume/grid_info.h"

#include "fluovox/core/error.h"
#include "fluovox/core/quantity.h"
#include "fluovox/volume/vdb_internal.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <unordered_set>

namespace fluovox {
namespace {

struct Statistics {
    double min = std::numeric_limits<double>::infinity();
    double max = -std::numeric_limits<double>::infinity();
    double sum = 0;
    std::uint64_t voxels = 0;

    void add(double value, std::uint64_t count) {
        min = std::min(min, value);
        max = std::max(max, value);
        sum += value * static_cast<double>(count);
        voxels += count;
    }
    void add(const Statistics& other) {
        min = std::min(min, other.min);
        max = std::max(max, other.max);
        sum += other.sum;
        voxels += other.voxels;
    }
};

/// In pieces of a fixed size that are added in a fixed order: the same sum for any number of threads.
Statistics active_statistics(const openvdb::FloatGrid& grid) {
    std::vector<const openvdb::FloatTree::LeafNodeType*> leaves;
    grid.tree().getNodes(leaves);
    Statistics all = tbb::parallel_deterministic_reduce(
        tbb::blocked_range<std::size_t>(0, leaves.size(), 256), Statistics{},
        [&](const tbb::blocked_range<std::size_t>& range, Statistics found) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
                for (auto value = leaves[i]->cbeginValueOn(); value; ++value)
                    found.add(static_cast<double>(*value), 1);
            return found;
        },
        [](Statistics a, const Statistics& b) {
            a.add(b);
            return a;
        });
    auto tile = grid.cbeginValueOn();
    tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile)
        all.add(static_cast<double>(*tile), tile.getVoxelCount());
    return all;
}

Vec3 to_vec3(const openvdb::Vec3d& v) {
    return {v.x(), v.y(), v.z()};
}

/// um per unit of length; 1 where unknown.
double length_scale(const std::string& unit) {
    if (unit == "nm") return 1e-3;
    if (unit == "mm") return 1e3;
    if (unit == "cm") return 1e4;
    if (unit == "m") return 1e6;
    return 1;
}
/// umol/L per unit of value; umol/L itself where the file is silent, nothing for a unit of something else.
std::optional<double> concentration_scale(const std::string& unit) {
    if (unit.empty()) return 1;
    try {
        return parse_quantity("1 " + unit, Dimension::Concentration);
    } catch (const std::invalid_argument&) {
        return std::nullopt;
    }
}

Bounds active_bounds_um(const openvdb::GridBase& grid, double um) {
    openvdb::CoordBBox box;
    Bounds bounds;
    if (!grid.baseTree().evalActiveVoxelBoundingBox(box)) return bounds;
    for (int corner = 0; corner < 8; ++corner) {
        openvdb::Vec3d index;
        for (int axis = 0; axis < 3; ++axis)
            index[axis] = ((corner >> axis) & 1) != 0 ? box.max()[axis] + 0.5 : box.min()[axis] - 0.5;
        bounds.add(um * to_vec3(grid.indexToWorld(index)));
    }
    return bounds;
}

template <class Grid>
void inspect_labels(const Grid& grid, GridInfo& info) {
    info.metadata = grid_metadata(grid);
    const double um = length_scale(info.metadata.length_unit);
    info.voxel_size_um = um * to_vec3(grid.voxelSize());
    info.bbox_um = active_bounds_um(grid, um);
    info.memory_bytes = grid.baseTree().memUsage();
    info.active_voxels = grid.baseTree().activeVoxelCount();
    LabelStatistics found;
    std::unordered_set<std::int64_t> labels;
    std::int64_t last = 0;  // neighbours mostly have the same
    for (auto at = grid.cbeginValueOn(); at; ++at) {
        const std::int64_t label = *at;
        if (label == 0 || label == last) continue;
        last = label;
        found.largest = labels.empty() ? label : std::max(found.largest, label);
        labels.insert(label);
    }
    found.labels = labels.size();
    info.labels = found;
}

/// Nothing where the grid is none of whole numbers.
void inspect_labels(const std::filesystem::path& file, const std::string& name, GridInfo& info) {
    const auto grid = load_any_grid(file, name);
    if (const auto small = openvdb::gridPtrCast<openvdb::Int32Grid>(grid)) inspect_labels(*small, info);
    if (const auto large = openvdb::gridPtrCast<openvdb::Int64Grid>(grid)) inspect_labels(*large, info);
}

}  // namespace

GridInfo inspect_grid(const openvdb::FloatGrid& grid) {
    GridInfo info;
    info.metadata = grid_metadata(grid);
    info.grid_class = openvdb::GridBase::gridClassToMenuName(grid.getGridClass());
    std::transform(info.grid_class.begin(), info.grid_class.end(), info.grid_class.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const double um = length_scale(info.metadata.length_unit);
    info.voxel_size_um = um * to_vec3(grid.voxelSize());
    info.bbox_um = active_bounds_um(grid, um);
    info.memory_bytes = grid.baseTree().memUsage();
    const std::optional<double> uM = concentration_scale(info.metadata.value_unit);
    info.has_concentrations = uM.has_value();
    const Statistics found = active_statistics(grid);
    info.active_voxels = found.voxels;
    if (found.voxels == 0) return info;
    info.min = found.min;
    info.mean = found.sum / static_cast<double>(found.voxels);
    info.max = found.max;
    // umol/L x um^3: 1 um^3 = 1e-15 L, 1 umol = 1e-6 mol.
    const double voxel_um3 = std::abs(grid.transform().voxelVolume()) * um * um * um;
    info.total_mol = found.sum * uM.value_or(0) * voxel_um3 * 1e-21;
    return info;
}

std::vector<GridInfo> inspect_grids(const std::filesystem::path& file) {
    std::vector<GridInfo> infos;
    for (const GridEntry& entry : list_grids(file)) {
        GridInfo info;
        if (entry.readable) info = inspect_grid(*load_any_float_grid(file, entry.name));
        if (entry.value_type.starts_with("int")) inspect_labels(file, entry.name, info);
        info.entry = entry;
        infos.push_back(std::move(info));
    }
    return infos;
}

}  // namespace fluovox
