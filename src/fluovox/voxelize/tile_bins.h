#pragma once

#include "fluovox/voxelize/voxel_tile.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace fluovox {

/// Which items (triangles, capsules) touch which tile (a row of blocks along x). Memory follows the items, not the
/// lattice.
class TileBins {
public:
    /// The box of item `number` in voxels.
    using BoxOf = std::function<Bounds(std::uint32_t number)>;
    /// Where an item lies along z within `low <= y <= high` (from, to); nowhere when from > to.
    using SpanOf = std::function<std::pair<double, double>(std::uint32_t number, double low, double high)>;
    /// `blocks_z`: how many tiles there are along z. `span_of` is asked about items that are long both ways.
    TileBins(std::uint32_t items, const BoxOf& box_of, const SpanOf& span_of, std::int32_t blocks_z);

    /// Notes blocks where the winding number without caps decides.
    void add_open_blocks(const std::vector<BlockPlace>& blocks);

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
    std::vector<std::uint32_t> items_;
    std::vector<Tile> tiles_;
    std::map<std::uint64_t, std::vector<std::int32_t>> open_blocks_;
};

/// Finds the blocks where `caps` (vertices in voxels) turn the winding number by enough to matter, and notes them in
/// `surface.open_blocks`; none at all where they would be too many.
void add_open_blocks(const Mesh& caps, VoxelSurface& surface);

}  // namespace fluovox
