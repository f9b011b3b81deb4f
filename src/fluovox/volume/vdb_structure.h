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
/// anything. Throws InputError where that reading would leave the file or the format, and where what the format says
/// twice is not twice the same: the numbers of a transform, the masks of a leaf.
void check_vdb_float_grid(const std::filesystem::path& file, const VdbDescriptor& grid);

/// A line of text for the end of a VDB file, behind the last grid where OpenVDB does not look: a CRC-32 of all bytes
/// before it, but for the random identifier of the file. Other programs that write the file anew leave it out, so it
/// never is of other bytes.
std::string vdb_checksum_line(const std::filesystem::path& file);

/// Throws InputError where a file has such a line and it does not fit. A file without passes.
void check_vdb_checksum(const std::filesystem::path& file);

}  // namespace fluovox
