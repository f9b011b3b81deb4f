#include "fluovox/voxelize/flood.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace fluovox {
namespace {

constexpr std::int32_t kEnd = std::numeric_limits<std::int32_t>::max();
constexpr std::array<int, 3> kStride = {kBlockColumns, kBlockSide, 1};

int coordinate(int voxel, int axis) {
    return voxel / kStride[static_cast<std::size_t>(axis)] % kBlockSide;
}

/// Where a run of a row begins and ends, in blocks.
template <class Blocks>
std::pair<std::int32_t, std::int32_t> run_range(const Blocks& blocks, std::size_t run) {
    return {run == 0 ? -kEnd : blocks[run - 1].x + 1, run == blocks.size() ? kEnd : blocks[run].x};
}

std::pair<std::int32_t, std::int32_t> beside(std::pair<std::int32_t, std::int32_t> place, int axis, int side) {
    (axis == 1 ? place.first : place.second) += side;
    return place;
}

}  // namespace

void Flood::add(const TileTask& task, const TileResult& result) {
    if (result.crossed.empty()) return;
    Row& row = rows_[{task.y, task.z}];
    for (const auto& [x, mask] : result.crossed)
        row.blocks.push_back({x, mask, {}});
    row.run_is_outside.assign(row.blocks.size() + 1, 0);
}

void Flood::reach_run(const RowPlace& place, std::size_t run) {
    Row& row = rows_.at(place);
    std::uint8_t& outside = row.run_is_outside[run];
    const auto [begin, end] = run_range(row.blocks, run);
    if (outside != 0 || begin >= end) return;  // between neighbours there is nothing to flood
    outside = 1;
    edge_.push_back({place, run, -1});
}

void Flood::reach_voxel(const RowPlace& place, std::size_t number, int voxel) {
    Block& block = rows_.at(place).blocks[number];
    const auto at = static_cast<std::size_t>(voxel);
    if (block.crossed[at] || block.outside[at]) return;
    block.outside[at] = true;
    edge_.push_back({place, number, voxel});
}

/// All voxels of a block's face; `side` -1: the low one.
void Flood::reach_face(const RowPlace& place, std::size_t block, int axis, int side) {
    for (int voxel = 0; voxel < kBlockVoxels; ++voxel)
        if (coordinate(voxel, axis) == (side < 0 ? 0 : kBlockSide - 1)) reach_voxel(place, block, voxel);
}

/// What lies from `begin` to `end` in the row to one side; its faces towards us are `-side`.
void Flood::reach_beside(const RowPlace& place, std::int32_t begin, std::int32_t end, int axis, int side) {
    const RowPlace other = beside(place, axis, side);
    const auto at = rows_.find(other);
    if (at == rows_.end()) return;  // no surface along all of it: outside, and known to be
    const auto& blocks = at->second.blocks;
    const auto first = std::lower_bound(blocks.begin(), blocks.end(), begin,
                                        [](const Block& block, std::int32_t x) { return block.x < x; });
    for (auto run = static_cast<std::size_t>(first - blocks.begin()); run <= blocks.size(); ++run) {
        const auto [low, high] = run_range(blocks, run);
        if (low >= end) break;
        if (std::max(low, begin) < std::min(high, end)) reach_run(other, run);
        if (run < blocks.size() && blocks[run].x < end) reach_face(other, run, axis, -side);
    }
}

void Flood::spread_run(const Reached& from) {
    const auto& blocks = rows_.at(from.row).blocks;
    if (from.number > 0) reach_face(from.row, from.number - 1, 0, 1);
    if (from.number < blocks.size()) reach_face(from.row, from.number, 0, -1);
    const auto [begin, end] = run_range(blocks, from.number);
    for (const int axis : {1, 2})
        for (const int side : {-1, 1})
            reach_beside(from.row, begin, end, axis, side);
}

void Flood::spread_voxel(const Reached& from) {
    for (int axis = 0; axis < 3; ++axis) {
        const int stride = kStride[static_cast<std::size_t>(axis)];
        for (const int side : {-1, 1}) {
            const int next = coordinate(from.voxel, axis) + side;
            if (next >= 0 && next < kBlockSide) {
                reach_voxel(from.row, from.number, from.voxel + side * stride);
                continue;
            }
            reach_next_block(from, axis, side);
        }
    }
}

/// From a voxel at a block's face to what is on its other side: a voxel, or a run without surface.
void Flood::reach_next_block(const Reached& from, int axis, int side) {
    const std::int32_t x = rows_.at(from.row).blocks[from.number].x + (axis == 0 ? side : 0);
    const RowPlace row = axis == 0 ? from.row : beside(from.row, axis, side);
    const auto at = rows_.find(row);
    if (at == rows_.end()) return;
    const auto& there = at->second.blocks;
    const auto block = std::lower_bound(there.begin(), there.end(), x,
                                        [](const Block& b, std::int32_t wanted) { return b.x < wanted; });
    const auto number = static_cast<std::size_t>(block - there.begin());
    if (block != there.end() && block->x == x) {
        reach_voxel(row, number, from.voxel - side * kStride[static_cast<std::size_t>(axis)] * (kBlockSide - 1));
    } else {
        reach_run(row, number);
    }
}

Flood::State Flood::state(const RowPlace& home, std::size_t number, const std::array<int, 3>& voxel) const {
    std::array<int, 3> block{};
    int at = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        block[axis] = voxel[axis] < 0 ? -1 : voxel[axis] / kBlockSide;
        at += (voxel[axis] - kBlockSide * block[axis]) * kStride[axis];
    }
    const auto state_in = [at](const Block& b) {
        const auto bit = static_cast<std::size_t>(at);
        return b.crossed[bit] ? State::Crossed : (b.outside[bit] ? State::Outside : State::Enclosed);
    };
    if (block == std::array<int, 3>{}) return state_in(rows_.at(home).blocks[number]);
    const std::int32_t x = rows_.at(home).blocks[number].x + block[0];
    const auto row = rows_.find({home.first + block[1], home.second + block[2]});
    if (row == rows_.end()) return State::Outside;
    const auto& there = row->second.blocks;
    const auto found = std::lower_bound(there.begin(), there.end(), x,
                                        [](const Block& b, std::int32_t wanted) { return b.x < wanted; });
    if (found != there.end() && found->x == x) return state_in(*found);
    const auto run = static_cast<std::size_t>(found - there.begin());
    return row->second.run_is_outside[run] != 0 ? State::Outside : State::Enclosed;
}

/// Whether a touched voxel has enclosed ones beside it and none outside: the wall of a cavity.
bool Flood::is_inner_wall(const RowPlace& place, std::size_t number, int voxel) const {
    bool enclosed = false;
    for (int n = 0; n < 27; ++n) {
        const State there = state(
            place, number,
            {coordinate(voxel, 0) + n / 9 - 1, coordinate(voxel, 1) + n / 3 % 3 - 1, coordinate(voxel, 2) + n % 3 - 1});
        if (there == State::Outside) return false;
        enclosed |= there == State::Enclosed;
    }
    return enclosed;
}

/// The ends of rows, and their sides where no surface is beside them.
void Flood::reach_from_far() {
    for (auto& [place, row] : rows_) {
        reach_run(place, 0);
        reach_run(place, row.blocks.size());
        for (const auto& [axis, side] : {std::pair{1, -1}, std::pair{1, 1}, std::pair{2, -1}, std::pair{2, 1}}) {
            if (rows_.contains(beside(place, axis, side))) continue;
            for (std::size_t i = 0; i < row.blocks.size(); ++i) {
                reach_run(place, i);
                reach_face(place, i, axis, side);
            }
        }
    }
}

/// To everything that can be reached from what was.
void Flood::spread() {
    while (!edge_.empty()) {
        const Reached from = edge_.back();
        edge_.pop_back();
        if (from.voxel < 0) {
            spread_run(from);
        } else {
            spread_voxel(from);
        }
    }
}

/// Voxels of a block that were not reached, with the walls of cavities.
Flood::Mask Flood::enclosed_in(const RowPlace& place, const Row& row, std::size_t number) const {
    const Block& block = row.blocks[number];
    Mask inside = ~(block.crossed | block.outside);
    for (int voxel = 0; voxel < kBlockVoxels; ++voxel) {
        const auto at = static_cast<std::size_t>(voxel);
        if (block.crossed[at] && is_inner_wall(place, number, voxel)) inside.set(at);
    }
    return inside;
}

std::vector<Flood::Enclosed> Flood::enclosed() {
    reach_from_far();
    spread();
    std::vector<Enclosed> found;
    for (const auto& [place, row] : rows_) {
        for (std::size_t i = 0; i < row.blocks.size(); ++i) {
            const auto [begin, end] = run_range(row.blocks, i);
            if (begin < end && row.run_is_outside[i] == 0)
                found.push_back({place.first, place.second, begin, end, Mask().set()});
            const Mask inside = enclosed_in(place, row, i);
            const std::int32_t x = row.blocks[i].x;
            if (inside.any()) found.push_back({place.first, place.second, x, x + 1, inside});
        }
    }
    return found;
}

}  // namespace fluovox
