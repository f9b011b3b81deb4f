#pragma once

// OpenVDB's own types: see vdb_internal.h.

#include "fluovox/volume/vdb_structure.h"

#include <openvdb/Grid.h>

#include <filesystem>

namespace fluovox {

/// Reads one grid, by its place in the table of contents, as openvdb::io::File does. That one seeks at every leaf, with
/// which a file stream drops its buffer and reads the next 8 KB anew; here a seek within what was read costs nothing.
/// `parent`: the grid whose tree it shares, or null. Check the file before (check_vdb_float_grid).
/// Throws InputError for what OpenVDB cannot read.
openvdb::GridBase::Ptr read_vdb_grid(const std::filesystem::path& file, const VdbDescriptor& grid,
                                     const VdbDescriptor* parent);

}  // namespace fluovox
