#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/vec.h"

#include <array>
#include <cstdint>

namespace fluovox {

/// The lattice of a grid and the part of it that is filled.
struct BlockLattice {
    double voxel_um = 0;
    std::array<std::int32_t, 3> corner{};  ///< voxel with the lowest indices; a multiple of the block's side
    std::array<std::int32_t, 3> blocks{};  ///< along each axis
};

/// The blocks that a box touches. Throws InputError where it is too far from the origin for the tree's indices.
BlockLattice make_block_lattice(const Bounds& bounds_um, double voxel_um);

/// A position in voxels from the lattice's corner.
Vec3 to_voxels(const Vec3& position_um, const BlockLattice& lattice);

}  // namespace fluovox
