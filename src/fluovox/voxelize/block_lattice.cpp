#include "fluovox/voxelize/block_lattice.h"

#include "fluovox/core/error.h"
#include "fluovox/voxelize/voxel_tile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace fluovox {

BlockLattice make_block_lattice(const Bounds& bounds_um, double voxel_um) {
    BlockLattice lattice;
    lattice.voxel_um = voxel_um;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = std::floor(bounds_um.min[axis] / voxel_um / kBlockSide);
        const double high = std::floor(bounds_um.max[axis] / voxel_um / kBlockSide) + 1;
        constexpr double kFarthest = 1 << 27;  // in blocks; the tree's indices have 32 bits
        if (!(std::abs(low) < kFarthest && std::abs(high) < kFarthest)) {
            throw InputError(fmt::format("the mesh reaches to {:g} um, too far from the origin for voxels of {:g} um",
                                         std::max(std::abs(bounds_um.min[axis]), std::abs(bounds_um.max[axis])),
                                         voxel_um));
        }
        const auto index = static_cast<std::size_t>(axis);
        lattice.corner[index] = kBlockSide * static_cast<std::int32_t>(low);
        lattice.blocks[index] = static_cast<std::int32_t>(high - low);
    }
    return lattice;
}

Vec3 to_voxels(const Vec3& position_um, const BlockLattice& lattice) {
    Vec3 placed;
    for (int axis = 0; axis < 3; ++axis)
        placed[axis] = position_um[axis] / lattice.voxel_um - lattice.corner[static_cast<std::size_t>(axis)];
    return placed;
}

}  // namespace fluovox
