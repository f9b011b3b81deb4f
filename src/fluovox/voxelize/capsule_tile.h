#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/voxelize/morphology.h"
#include "fluovox/voxelize/voxel_tile.h"

#include <vector>

namespace fluovox {

Bounds capsule_bounds(const Capsule& capsule);

/// Area from above: of the capsule as wide as its wider end.
double capsule_area(const Capsule& capsule);

/// Fills a tile with the union of capsules (in voxels; the task's items are their numbers): 64 lines along x in each
/// column of voxels are cut into what is inside any of them and what isn't, exactly along x.
TileResult fill_capsule_tile(const std::vector<Capsule>& capsules, const TileTask& task);

}  // namespace fluovox
