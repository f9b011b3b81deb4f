#pragma once

#include "fluovox/volume/grid_info.h"
#include "fluovox/volume/sparse_grid.h"

#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// A computed field in bricks of 8^3 voxels, to be written to a VDB file.
struct BrickField {
    std::string name;
    GridMetadata metadata;
    Affine world_from_index;
    std::vector<Voxel> bricks;  ///< first voxel of each, multiples of 8
    std::vector<float> values;  ///< 512 for each brick, z fastest; zeros stay inactive
};

/// Writes the fields as fog volumes, in one step. Throws OutputError.
void save_brick_fields(const std::filesystem::path& file, const std::vector<BrickField>& fields);

}  // namespace fluovox
