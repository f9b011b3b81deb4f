#pragma once

#include "fluovox/voxelize/voxel_tile.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace fluovox {

/// Which triangles touch which tile (a row of blocks along x). Memory follows the triangles, not the box.
class TileBins {
public:
    /// `blocks_z`: how many tiles there are along z.
    TileBins(const VoxelSurface& surface, std::int32_t blocks_z);

    /// Tiles with anything to do, by y and then z.
    std::size_t size() const { return tiles_.size(); }
    TileTask task(std::size_t number) const;

private:
    struct Tile {
        std::uint64_t key = 0;
        std::size_t begin = 0;
        std::size_t end = 0;
    };

    std::uint64_t blocks_z_;
    std::vector<std::uint32_t> triangles_;
    std::vector<Tile> tiles_;
    std::map<std::uint64_t, std::vector<std::int32_t>> open_blocks_;
};

/// Finds the blocks where `caps` (vertices in voxels) turn the winding number by enough to matter, and notes them in
/// `surface.open_blocks`.
void add_open_blocks(const Mesh& caps, VoxelSurface& surface);

}  // namespace fluovox
