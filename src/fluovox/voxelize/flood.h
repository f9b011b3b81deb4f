#pragma once

#include "fluovox/voxelize/voxel_tile.h"

#include <array>
#include <bitset>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace fluovox {

/// Which voxels a surface keeps from outside: all that cannot be reached from far away over faces of voxels that the
/// surface does not touch. Memory follows the surface: between its blocks there are only runs.
class Flood {
public:
    using Mask = std::bitset<kBlockVoxels>;

    /// Voxels of a block, or all of a run of blocks along x.
    struct Enclosed {
        std::int32_t y = 0, z = 0;        ///< in blocks
        std::int32_t begin = 0, end = 0;  ///< in blocks along x
        Mask voxels;                      ///< of a single block; of a run all are set
    };

    /// Notes the blocks of a tile that the surface touches.
    void add(const TileTask& task, const TileResult& result);

    /// Everything enclosed, with the walls of cavities.
    std::vector<Enclosed> enclosed();

private:
    struct Block {
        std::int32_t x = 0;
        Mask crossed;
        Mask outside;
    };
    /// A row of blocks along x: those with surface, and whether the runs before, between and after them are outside.
    struct Row {
        std::vector<Block> blocks;
        std::vector<std::uint8_t> run_is_outside;
    };
    using RowPlace = std::pair<std::int32_t, std::int32_t>;
    /// A run (voxel < 0), or a voxel of a block.
    struct Reached {
        RowPlace row;
        std::size_t number = 0;
        int voxel = -1;
    };

    void reach_run(const RowPlace& place, std::size_t run);
    void reach_voxel(const RowPlace& place, std::size_t number, int voxel);
    void reach_face(const RowPlace& place, std::size_t block, int axis, int side);
    void spread_run(const Reached& from);
    void spread_voxel(const Reached& from);
    void reach_next_block(const Reached& from, int axis, int side);
    void reach_beside(const RowPlace& place, std::int32_t begin, std::int32_t end, int axis, int side);
    enum class State { Crossed, Outside, Enclosed };
    /// Of a voxel near block `number` of a row, by its place from that block's corner.
    State state(const RowPlace& home, std::size_t number, const std::array<int, 3>& voxel) const;
    bool is_inner_wall(const RowPlace& place, std::size_t number, int voxel) const;
    Mask enclosed_in(const RowPlace& place, const Row& row, std::size_t number) const;
    void reach_from_far();
    void spread();

    std::map<RowPlace, Row> rows_;
    std::vector<Reached> edge_;
};

}  // namespace fluovox
