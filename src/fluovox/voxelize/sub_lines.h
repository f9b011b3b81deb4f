#pragma once

#include "fluovox/voxelize/cap_field.h"
#include "fluovox/voxelize/voxel_tile.h"

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace fluovox {

/// Lines along x in each column of voxels.
constexpr int kSubLines = 64;

/// Where line number `line` of a tile lies across x: columns by y and z, then lines by y and z.
std::pair<double, double> sub_line_place(const TileTask& task, std::size_t line);

/// Lines along x through a tile, 8 x 8 in each column of voxels, shifted at random from column to column; each is cut
/// by the surface into stretches inside and outside. Nothing is done before the first block is asked for.
class SubLines {
public:
    SubLines(const VoxelSurface& surface, const TileTask& task, Solid solid = Solid::Inside)
        : surface_(surface), task_(task), solid_(solid) {}

    /// Fractions of the block's voxels where the surface winds around at least once.
    void fill_block(std::int32_t block, BlockValues& values);

    /// The same by the winding number without the caps that are guesses (inside where it is at least 1/2). Changes
    /// only voxels where they could matter, and returns how many of those have something inside.
    std::uint64_t fill_open_block(std::int32_t block, BlockValues& values);

private:
    static constexpr int kPerSide = 8;
    static constexpr int kPerColumn = kSubLines;

    struct Crossing {
        double x = 0;
        std::int16_t enters = 0;  // +1, or -1 where the line leaves
        bool open_cap = false;
    };
    struct Place {
        double y = 0, z = 0;
    };

    void cut_lines();
    void cut_lines_by(std::uint32_t triangle, std::vector<std::pair<std::uint32_t, Crossing>>& found) const;
    Place place(std::size_t line) const;
    /// Winding number of a line at `x`.
    int winding_at(std::size_t line, double x) const;
    /// Whether the surface, not counting caps that are guesses, crosses a voxel.
    bool crossed(int column, double x) const;
    /// The winding number without those caps, at a place on line `n` of a column.
    double open_winding(int column, int n, double x, const CapField& caps) const;
    float smooth_fraction(int column, int x, const CapField& caps) const;
    float open_fraction(int column, int x, const CapField& caps) const;

    const VoxelSurface& surface_;
    const TileTask& task_;
    Solid solid_;
    bool ready_ = false;
    std::vector<Crossing> crossings_;   // by line, then x
    std::vector<std::uint32_t> first_;  // of each line
};

}  // namespace fluovox
