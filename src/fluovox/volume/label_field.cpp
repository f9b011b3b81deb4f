#include "fluovox/volume/label_field.h"

#include "fluovox/core/error.h"
#include "fluovox/volume/vdb_internal.h"
#include "fluovox/volume/vdb_structure.h"

#include <openvdb/openvdb.h>

#include <utility>

namespace fluovox {

struct LabelField::Impl {
    openvdb::Int32Grid::ConstPtr grid;
    double um_per_unit = 1;
};

std::optional<LabelField> LabelField::load(const std::filesystem::path& file, double um_per_unit) {
    constexpr const char* kName = "labels";
    initialize_openvdb();
    try {
        check_vdb_checksum(file);
        openvdb::io::File in(file.string());
        in.open();
        if (!in.hasGrid(kName)) return std::nullopt;
        const auto grid = openvdb::gridPtrCast<openvdb::Int32Grid>(in.readGrid(kName));
        if (!grid) return std::nullopt;
        return LabelField(std::make_shared<const Impl>(Impl{grid, um_per_unit}));
    } catch (const openvdb::Exception& e) {
        throw InputError(file.string() + ": grid \"labels\" cannot be read: " + e.what());
    }
}

int LabelField::at(Vec3 world_um) const {
    const Vec3 p = (1 / impl_->um_per_unit) * world_um;
    const openvdb::Vec3d index = impl_->grid->transform().worldToIndex({p.x, p.y, p.z});
    // The tree itself, not an accessor: accessors keep what they saw last, so threads could not share one.
    return impl_->grid->tree().getValue(openvdb::Coord::round(index));
}

}  // namespace fluovox
