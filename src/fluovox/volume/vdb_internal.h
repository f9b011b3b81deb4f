#pragma once

// OpenVDB's own types: for the sources of this library that need them, never for a public header.
//
// A source that calls the constructor of a type of grid compiles all that is virtual in it: reading, writing, printing,
// copying and counting, 5 to 10 s of work that OpenVDB's library holds already. So `new_grid` makes grids, and virtual
// functions are called through openvdb::GridBase and its baseTree().

#include "fluovox/volume/dye_grid.h"
#include "fluovox/volume/grid_info.h"
#include "fluovox/volume/vdb_sampler.h"

#include <openvdb/openvdb.h>

#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// Readies OpenVDB; call before the first use of it. Cheap after the first time.
void initialize_openvdb();

/// An empty grid.
template <class Grid>
typename Grid::Ptr new_grid(typename Grid::ValueType background = 0) {
    initialize_openvdb();
    auto grid = openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
    grid->tree().root().setBackground(background, /*updateChildNodes=*/false);
    return grid;
}

/// Reads a grid of concentrations (or of density). `name` may be empty when the file has one grid only; otherwise it
/// must match exactly or, failing that, without regard to case.
/// Throws InputError: file missing, damaged, truncated or no VDB; no such grid (lists those of the file); not a
/// float grid; a level set; values that are NaN, infinite or negative (how many, and where the first is).
openvdb::FloatGrid::Ptr load_float_grid(const std::filesystem::path& file, const std::string& name);

/// A grid of any type, of a file whose structure is not checked but for its table of contents and checksum. Throws
/// InputError.
openvdb::GridBase::Ptr load_any_grid(const std::filesystem::path& file, const std::string& name);

/// As `load_float_grid`, but takes level sets and any values too.
openvdb::FloatGrid::Ptr load_any_float_grid(const std::filesystem::path& file, const std::string& name);

/// What the grid says about itself.
GridMetadata grid_metadata(const openvdb::GridBase& grid);

/// Writes `metadata` (all of it that isn't empty) into the grid.
void set_grid_metadata(openvdb::GridBase& grid, const GridMetadata& metadata);

/// Writes a file of grids in one step (see write_atomically). Throws OutputError.
void save_grids(const std::filesystem::path& file, const std::vector<openvdb::GridBase::Ptr>& grids);

/// Statistics of a float grid; its `entry` is left empty.
GridInfo inspect_grid(const openvdb::FloatGrid& grid);

struct VdbTree {
    openvdb::FloatGrid::ConstPtr grid;
    float factor = 1;
};

struct DyeGrid::Impl {
    openvdb::GridBase::Ptr grid;
};

}  // namespace fluovox
