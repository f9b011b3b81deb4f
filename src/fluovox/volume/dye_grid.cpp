#include "fluovox/volume/dye_grid.h"

#include "fluovox/volume/vdb_internal.h"

namespace fluovox {

void save_dye_grids(const std::filesystem::path& file, const std::vector<DyeGrid>& grids) {
    std::vector<openvdb::GridBase::Ptr> all;
    all.reserve(grids.size());
    for (const DyeGrid& grid : grids)
        all.push_back(grid.impl().grid);
    save_grids(file, all);
}

GridInfo inspect_dye_grid(const DyeGrid& grid) {
    const auto floats = openvdb::gridConstPtrCast<openvdb::FloatGrid>(grid.impl().grid);
    if (!floats) {
        GridInfo info;
        info.entry.name = grid.impl().grid->getName();
        info.active_voxels = grid.impl().grid->activeVoxelCount();
        return info;
    }
    GridInfo info = inspect_grid(*floats);
    info.entry = {floats->getName(), "float", floats->saveFloatAsHalf(), true};
    return info;
}

void describe_dye_grid(const DyeGrid& grid, const std::string& name, const GridMetadata& metadata, bool half) {
    grid.impl().grid->setName(name);
    grid.impl().grid->setSaveFloatAsHalf(half);
    set_grid_metadata(*grid.impl().grid, metadata);
}

}  // namespace fluovox
