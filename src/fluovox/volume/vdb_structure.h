#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// A grid in the table of contents of a VDB file.
struct VdbDescriptor {
    std::string unique_name;  ///< tells grids of one name apart
    std::string name;
    std::string type;  ///< "Tree_float_5_4_3"
    bool half = false;
    std::string parent;  ///< unique name of the grid whose tree it shares, or empty
    std::uint64_t grid_position = 0, block_position = 0, end_position = 0;  ///< bytes from the file's begin
};

/// Reads the table of contents of a VDB file, with every offset checked against the file's size.
/// Throws InputError when the file is missing, empty, truncated, damaged, or no VDB file.
///
/// The OpenVDB library trusts what it reads: counts and sizes of a damaged file make it loop for hours, ask for
/// absurd memory or crash. So this walk comes first, bounded by the file's size.
std::vector<VdbDescriptor> read_vdb_directory(const std::filesystem::path& file);

/// Walks through all of a float grid (metadata, transform, tree, leaf buffers) as OpenVDB would, without keeping
/// anything. Throws InputError where that reading would leave the file or the format.
void check_vdb_float_grid(const std::filesystem::path& file, const VdbDescriptor& grid);

}  // namespace fluovox
