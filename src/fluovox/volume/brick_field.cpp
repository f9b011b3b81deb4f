#include "fluovox/volume/brick_field.h"

#include "fluovox/volume/vdb_internal.h"

#include <memory>
#include <utility>

namespace fluovox {
namespace {

openvdb::FloatGrid::Ptr grid_of(const BrickField& field) {
    using Leaf = openvdb::FloatTree::LeafNodeType;
    auto grid = new_grid<openvdb::FloatGrid>();
    for (std::size_t b = 0; b < field.bricks.size(); ++b) {
        const Voxel& origin = field.bricks[b];
        auto leaf = std::make_unique<Leaf>(openvdb::Coord(origin.x, origin.y, origin.z), 0.0F, false);
        bool any = false;
        for (openvdb::Index n = 0; n < Leaf::SIZE; ++n) {
            const float value = field.values[b * Leaf::SIZE + n];
            if (value == 0.0F) continue;
            leaf->setValueOn(n, value);
            any = true;
        }
        if (any) grid->tree().addLeaf(leaf.release());
    }
    const auto& rows = field.world_from_index.rows;
    const Vec3& o = field.world_from_index.offset;
    // OpenVDB multiplies row vectors from the left.
    const openvdb::math::Mat4d matrix(rows[0].x, rows[1].x, rows[2].x, 0.0, rows[0].y, rows[1].y, rows[2].y, 0.0,
                                      rows[0].z, rows[1].z, rows[2].z, 0.0, o.x, o.y, o.z, 1.0);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setName(field.name);
    set_grid_metadata(*grid, field.metadata);
    return grid;
}

}  // namespace

void save_brick_fields(const std::filesystem::path& file, const std::vector<BrickField>& fields) {
    std::vector<openvdb::GridBase::Ptr> grids;
    grids.reserve(fields.size());
    for (const BrickField& field : fields)
        grids.push_back(grid_of(field));
    save_grids(file, grids);
}

}  // namespace fluovox
