#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/voxelize/block_lattice.h"
#include "fluovox/voxelize/tile_bins.h"
#include "fluovox/voxelize/voxelize.h"

#include <functional>

namespace fluovox {

/// Makes what is in one tile; called by any thread.
using FillTile = std::function<TileResult(const TileTask& task)>;

/// Fills a grid tile by tile in parallel, the same for any number of threads. Throws InputError when it stays empty or
/// its volume is no number.
VoxelizedGrid fill_grid(const BlockLattice& lattice, const VoxelizeSettings& settings, const TileBins& bins,
                        Progress& progress, const FillTile& fill);

}  // namespace fluovox
