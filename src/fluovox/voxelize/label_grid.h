#pragma once

#include "fluovox/voxelize/specimen.h"

#include <openvdb/openvdb.h>

namespace fluovox {

/// Which part owns each voxel: a voxel at least half inside a part gets its label, 0 is nobody's. Where parts overlap
/// the rule decides; under `Max` and `Sum` the one that fills more of the voxel, the earlier one when they are alike.
class LabelGrid {
public:
    LabelGrid(double voxel_um, OverlapRule rule);

    /// `full` is the value of a voxel of `part` that is wholly inside.
    void add(const openvdb::FloatGrid& part, float full, int label);
    openvdb::GridBase::Ptr finish();

private:
    void claim(const openvdb::Coord& voxel, float share, int label);

    OverlapRule rule_;
    openvdb::Int32Grid::Ptr labels_;
    openvdb::FloatGrid::Ptr shares_;
    openvdb::Int32Grid::Accessor label_at_;
    openvdb::FloatGrid::Accessor share_at_;
};

}  // namespace fluovox
