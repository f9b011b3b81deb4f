#pragma once

#include "fluovox/voxelize/morphology.h"

#include <cstddef>
#include <vector>

namespace fluovox {

struct MergedCapsules {
    std::vector<Capsule> capsules;
    std::size_t merged_points = 0;  ///< ends between two capsules that are one now
};

/// Joins capsules that follow each other, from end to end, into one where it is the same shape within a hundredth of a
/// voxel (and far less than the radius): files of finely sampled cables then cost by voxels, not by points.
MergedCapsules merge_capsules(const std::vector<Capsule>& capsules, double voxel_size);

}  // namespace fluovox
