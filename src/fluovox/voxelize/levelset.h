#pragma once

#include "fluovox/volume/dye_grid.h"

#include <filesystem>
#include <string>

namespace fluovox {

/// Makes a concentration of a level set: `value` inside, 0 outside, and in the voxels between by how far their centre
/// is from the surface, over the voxel's size. `name` may be empty where the file has one grid. The grid's unit of
/// length is `um_per_unit`. Throws InputError; a grid that is no level set is refused.
DyeGrid load_levelset_as_dye(const std::filesystem::path& file, const std::string& name, double value,
                             double um_per_unit);

}  // namespace fluovox
