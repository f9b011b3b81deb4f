#include "fluovox/volume/label_field.h"

#include "fluovox/volume/vdb_internal.h"

#include <openvdb/openvdb.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace fluovox {

struct LabelField::Impl {
    openvdb::Int32Grid::ConstPtr grid;
    double um_per_unit = 1;
};

std::optional<LabelField> LabelField::load(const std::filesystem::path& file, double um_per_unit) {
    constexpr const char* kName = "labels";
    const auto grids = list_grids(file);
    const bool has = std::any_of(grids.begin(), grids.end(), [&](const GridEntry& grid) { return grid.name == kName; });
    if (!has) return std::nullopt;
    const auto grid = openvdb::gridPtrCast<openvdb::Int32Grid>(load_any_grid(file, kName));
    if (!grid) return std::nullopt;
    return LabelField(std::make_shared<const Impl>(Impl{grid, um_per_unit}));
}

int LabelField::at(Vec3 world_um) const {
    const Vec3 p = (1 / impl_->um_per_unit) * world_um;
    const openvdb::Vec3d index = impl_->grid->transform().worldToIndex({p.x, p.y, p.z});
    constexpr double kFarthest = 0x1.0p31 - 1;  // a picture may show more than the tree has places for
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(index[axis]) < kFarthest)) return impl_->grid->background();
    }
    // The tree itself, not an accessor: accessors keep what they saw last, so threads could not share one.
    return impl_->grid->tree().getValue(openvdb::Coord::round(index));
}

}  // namespace fluovox
