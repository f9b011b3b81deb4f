#pragma once

#include "fluovox/volume/grid_info.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace fluovox {

/// A grid in memory, on its way to or from a VDB file. A copy shares the voxels.
class DyeGrid {
public:
    struct Impl;  // an OpenVDB grid
    explicit DyeGrid(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

    Impl& impl() const { return *impl_; }

private:
    std::shared_ptr<Impl> impl_;
};

/// Writes all grids into one VDB file in one step (see write_atomically). Throws OutputError.
void save_dye_grids(const std::filesystem::path& file, const std::vector<DyeGrid>& grids);

/// Statistics of a float grid, as inspect_grids gives them of a file.
GridInfo inspect_dye_grid(const DyeGrid& grid);

/// Gives the grid its name and metadata; `half` stores 16 bits a value in files.
void describe_dye_grid(const DyeGrid& grid, const std::string& name, const GridMetadata& metadata, bool half);

}  // namespace fluovox
