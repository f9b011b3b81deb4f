#include "fluovox/voxelize/tile_bins.h"

#include "fluovox/voxelize/chunks.h"
#include "fluovox/voxelize/mesh_topology.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

namespace fluovox {
namespace {

std::int32_t block_of(double coordinate) {
    return static_cast<std::int32_t>(std::floor(coordinate / kBlockSide));
}

/// An item, and a tile that it touches.
struct Entry {
    std::uint64_t tile;
    std::uint32_t item;
};

/// Enters an item for each tile that it touches, of `blocks_z` along z.
void enter(std::uint32_t item, const Bounds& box, const TileBins::SpanOf& span_of, std::uint64_t blocks_z,
           std::vector<Entry>& entries) {
    const std::int32_t z0 = block_of(box.min.z);
    const std::int32_t z1 = block_of(box.max.z);
    const std::int32_t y0 = block_of(box.min.y);
    const std::int32_t y1 = block_of(box.max.y);
    // A slanted item fills little of its box, so where that is large each row is looked at by itself.
    const bool large = y1 - y0 > 2 && z1 - z0 > 2;
    for (std::int32_t y = y0; y <= y1; ++y) {
        std::int32_t from = z0;
        std::int32_t to = z1;
        if (large) {
            const double low = static_cast<double>(kBlockSide) * y;
            const auto [begin, end] = span_of(item, low, low + kBlockSide);
            if (begin > end) continue;
            from = std::max(z0, block_of(begin));
            to = std::min(z1, block_of(end));
        }
        for (std::int32_t z = from; z <= to; ++z)
            entries.push_back({static_cast<std::uint64_t>(y) * blocks_z + static_cast<std::uint64_t>(z), item});
    }
}

using Entries = std::vector<Entry, UnsetAllocator<Entry>>;

/// One list of all, which frees the others as it goes.
Entries joined(std::vector<std::vector<Entry>> parts) {
    std::vector<std::size_t> places;
    places.reserve(parts.size());
    for (const auto& part : parts)
        places.push_back(part.size());
    Entries entries(counts_to_places(places));
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
        std::copy(parts[i].begin(), parts[i].end(), entries.begin() + static_cast<std::ptrdiff_t>(places[i]));
        parts[i] = {};
    });
    return entries;
}

}  // namespace

TileBins::TileBins(std::uint32_t items, const BoxOf& box_of, const SpanOf& span_of, std::int32_t blocks_z)
    : blocks_z_(static_cast<std::uint64_t>(blocks_z)) {
    Entries entries = joined(map_chunks(items, [&](std::size_t begin, std::size_t end) {
        std::vector<Entry> some;
        for (auto item = static_cast<std::uint32_t>(begin); item < end; ++item)
            enter(item, box_of(item), span_of, blocks_z_, some);
        return some;
    }));
    tbb::parallel_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return a.tile != b.tile ? a.tile < b.tile : a.item < b.item;
    });
    items_.resize(entries.size());
    for (const auto& some : map_chunks(entries.size(), [&](std::size_t begin, std::size_t end) {
             std::vector<Tile> tiles;
             for (std::size_t i = begin; i < end; ++i) {
                 items_[i] = entries[i].item;
                 if (i == 0 || entries[i].tile != entries[i - 1].tile) tiles.push_back({entries[i].tile, i, 0});
             }
             return tiles;
         }))
        tiles_.insert(tiles_.end(), some.begin(), some.end());
    for (std::size_t i = 0; i < tiles_.size(); ++i)
        tiles_[i].end = i + 1 < tiles_.size() ? tiles_[i + 1].begin : items_.size();
}

void TileBins::add_open_blocks(const std::vector<BlockPlace>& blocks) {
    for (const auto& [x, y, z] : blocks)
        open_blocks_[static_cast<std::uint64_t>(y) * blocks_z_ + static_cast<std::uint64_t>(z)].push_back(x);
    std::vector<Tile> added;
    for (auto& [key, xs] : open_blocks_) {
        std::sort(xs.begin(), xs.end());
        const auto at = std::lower_bound(tiles_.begin(), tiles_.end(), key,
                                         [](const Tile& tile, std::uint64_t wanted) { return tile.key < wanted; });
        if (at == tiles_.end() || at->key != key) added.push_back({key, 0, 0});
    }
    tiles_.insert(tiles_.end(), added.begin(), added.end());
    std::sort(tiles_.begin(), tiles_.end(), [](const Tile& a, const Tile& b) { return a.key < b.key; });
}

TileTask TileBins::task(std::size_t number) const {
    const Tile& tile = tiles_[number];
    TileTask task;
    task.y = static_cast<std::int32_t>(tile.key / blocks_z_);
    task.z = static_cast<std::int32_t>(tile.key % blocks_z_);
    task.begin = items_.data() + tile.begin;
    task.end = items_.data() + tile.end;
    const auto open = open_blocks_.find(tile.key);
    if (open != open_blocks_.end()) task.open_blocks = open->second;
    return task;
}

namespace {

/// The blocks that share a face with those of `edge`, less those already known.
std::vector<BlockPlace> blocks_beside(const std::vector<BlockPlace>& edge, const std::set<BlockPlace>& known) {
    std::set<BlockPlace> beside;
    for (const BlockPlace& at : edge) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const int step : {-1, 1}) {
                BlockPlace next = at;
                next[axis] += step;
                if (!known.contains(next)) beside.insert(next);
            }
        }
    }
    return {beside.begin(), beside.end()};
}

/// Whether caps turn the winding number in the middle of a block by enough to matter. `bounds`: of the surface.
bool caps_matter(const VoxelSurface& surface, const Bounds& bounds, const BlockPlace& block) {
    Vec3 center;
    bool outside = false;
    for (int axis = 0; axis < 3; ++axis) {
        center[axis] = kBlockSide * (block[static_cast<std::size_t>(axis)] + 0.5);
        outside |= center[axis] < bounds.min[axis] - kBlockSide || center[axis] > bounds.max[axis] + kBlockSide;
    }
    constexpr double kMatters = 0.3;
    return !outside && std::abs(surface.open_caps(center)) > kMatters;
}

}  // namespace

void add_open_blocks(const Mesh& caps, VoxelSurface& surface) {
    std::set<BlockPlace> found;
    std::vector<BlockPlace> edge;
    const Bounds bounds = mesh_bounds(surface.mesh);
    const auto visit = [&](const BlockPlace& block) {
        if (found.insert(block).second) edge.push_back(block);
    };
    for (const auto& t : caps.triangles) {
        for (const std::uint32_t vertex : t) {
            const Vec3& v = caps.vertices[vertex];
            visit({block_of(v.x), block_of(v.y), block_of(v.z)});
        }
    }
    // From the rims of the caps outwards, as long as the caps fill enough of the view.
    constexpr std::size_t kMostBlocks = 200'000;  // beyond, the caps must do: this takes time by volume, not by surface
    while (!edge.empty()) {
        if (found.size() > kMostBlocks) return;
        const std::vector<BlockPlace> asked = blocks_beside(edge, found);
        std::vector<std::uint8_t> matters(asked.size(), 0);
        tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t i) {
            matters[i] = static_cast<std::uint8_t>(caps_matter(surface, bounds, asked[i]));
        });
        edge.clear();
        for (std::size_t i = 0; i < asked.size(); ++i)
            if (matters[i] != 0) visit(asked[i]);
    }
    const auto in_range = [](const BlockPlace& b) { return b[0] >= 0 && b[1] >= 0 && b[2] >= 0; };
    std::copy_if(found.begin(), found.end(), std::back_inserter(surface.open_blocks), in_range);
}

}  // namespace fluovox
