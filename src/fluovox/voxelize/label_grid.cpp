#include "fluovox/voxelize/label_grid.h"

#include "fluovox/core/version.h"
#include "fluovox/volume/vdb_internal.h"

#include <openvdb/tools/Prune.h>

namespace fluovox {

LabelGrid::LabelGrid(double voxel_um, OverlapRule rule)
    : rule_(rule),
      labels_(new_grid<openvdb::Int32Grid>()),
      shares_(new_grid<openvdb::FloatGrid>()),
      label_at_(labels_->getAccessor()),
      share_at_(shares_->getAccessor()) {
    labels_->setName("labels");
    labels_->setTransform(openvdb::math::Transform::createLinearTransform(voxel_um));
    labels_->transform().postTranslate(openvdb::Vec3d(voxel_um / 2));
    labels_->insertMeta("length_unit", openvdb::StringMetadata("um"));
    labels_->insertMeta("fluovox_version", openvdb::StringMetadata(version()));
}

void LabelGrid::claim(const openvdb::Coord& voxel, float share, int label) {
    const bool taken = label_at_.isValueOn(voxel);
    if (taken && rule_ == OverlapRule::First) return;
    if (rule_ == OverlapRule::Max || rule_ == OverlapRule::Sum) {
        if (taken && share_at_.getValue(voxel) >= share) return;
        share_at_.setValueOn(voxel, share);
    }
    label_at_.setValueOn(voxel, label);
}

void LabelGrid::add(const openvdb::FloatGrid& part, float full, int label) {
    for (auto at = part.cbeginValueOn(); at; ++at) {
        const float share = *at / full;
        if (share < 0.5F) continue;
        if (at.isVoxelValue()) {
            claim(at.getCoord(), share, label);
            continue;
        }
        openvdb::CoordBBox box;
        at.getBoundingBox(box);
        for (const openvdb::Coord& voxel : box)
            claim(voxel, share, label);
    }
}

openvdb::GridBase::Ptr LabelGrid::finish() {
    openvdb::tools::prune(labels_->tree());
    return labels_;
}

}  // namespace fluovox
