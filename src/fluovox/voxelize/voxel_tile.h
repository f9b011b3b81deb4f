#pragma once

// How a row of leaves is filled: the part of the voxelizer that is all geometry and no OpenVDB.

#include "fluovox/voxelize/mesh.h"
#include "fluovox/voxelize/winding_tree.h"

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fluovox {

/// Voxels along the side of a leaf of the tree; a block is the place of one leaf.
constexpr int kBlockSide = 8;
constexpr int kBlockColumns = kBlockSide * kBlockSide;
constexpr int kBlockVoxels = kBlockColumns * kBlockSide;

/// A block by its place along x, y, z.
using BlockPlace = std::array<std::int32_t, 3>;

/// A closed surface in units of voxels, with its origin at the low corner of the lattice: voxel (i, j, k) is the cube
/// from (i, j, k) to (i+1, j+1, k+1).
struct VoxelSurface {
    Mesh mesh;
    WindingTree open_caps;  ///< caps that are only a guess; where they matter the winding number without them decides
    std::vector<std::uint8_t> is_open_cap;  ///< of each triangle; empty: none is
    std::vector<BlockPlace> open_blocks;    ///< where they matter
};

/// What is solid.
enum class Solid {
    Inside,    ///< what the surface winds around at least once
    Enclosed,  ///< what it winds around any number of times but none, either way; all touched voxels are noted
};

/// A leaf's worth of inside fractions, x slowest and z fastest, as OpenVDB has it.
using BlockValues = std::array<float, kBlockVoxels>;

/// What one tile (a row of blocks along x) came to.
struct TileResult {
    struct Block {
        std::int32_t x = 0;  ///< in blocks
        std::uint32_t values = 0;
    };
    struct Run {
        std::int32_t begin = 0;  ///< blocks, all inside
        std::int32_t end = 0;
    };
    std::vector<BlockValues> values;
    std::vector<Block> blocks;  ///< several may share values
    std::vector<Run> full;
    std::vector<std::pair<std::int32_t, std::bitset<kBlockVoxels>>>
        crossed;                           ///< Solid::Enclosed: touched voxels by block
    double winding_volume = 0;             ///< voxels: integral of the winding number
    double volume = 0;                     ///< voxels: what is inside
    std::uint64_t decided_by_winding = 0;  ///< voxels
};

/// One row of blocks along x, by its place across and the triangles whose box touches it.
struct TileTask {
    std::int32_t y = 0, z = 0;  ///< in blocks
    const std::uint32_t* begin = nullptr;
    const std::uint32_t* end = nullptr;
    std::vector<std::int32_t> open_blocks;  ///< x of blocks where the winding number without caps decides; sorted
};

/// What a piece of surface adds to the voxels of a row: `volume` to the one it is in, `area` to all beyond.
struct Piece {
    std::int32_t x = 0;        ///< voxel
    std::uint16_t column = 0;  ///< y * 8 + z within the tile
    double volume = 0;
    double area = 0;
};

/// Fills a tile. The fraction of a voxel is exact where the surface winds around nothing twice: each triangle is
/// clipped to the voxels it crosses and adds the volume between itself and the far end of its row, with its sign.
/// Where surfaces overlap, 64 lines along x per column of voxels are cut into what is inside (enter +1, leave -1,
/// inside where the sum is at least 1) and what isn't.
TileResult fill_tile(const VoxelSurface& surface, const TileTask& task, Solid solid = Solid::Inside);

/// Fills a tile with a layer of `thickness` (in voxels, thin) on the surface: each voxel gets the area in it times
/// that.
TileResult fill_layer_tile(const VoxelSurface& surface, const TileTask& task, double thickness);

/// Sums up pieces of surfaces that overlap nowhere (reorders them).
TileResult sweep_tile(const TileTask& task, std::vector<Piece>& pieces);

}  // namespace fluovox
