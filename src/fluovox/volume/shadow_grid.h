#pragma once

#include "fluovox/core/huge_pages.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/fixed_point.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {

/// How much of a collimated light gets through a grid to each of its voxels that are not zero, in steps of 1/255: a
/// good guess for the points around them, not the truth. Optical depths are summed along lines of the light one voxel
/// apart, slice by slice, in one pass over the voxels (as deep shadow maps have it: Lokovic & Veach, SIGGRAPH 2000,
/// 385). Immutable: any number of threads may read it.
class ShadowGrid {
public:
    /// Where a guess comes from: found ahead of time, it need not be waited for.
    struct Place {
        const std::uint8_t* level = nullptr;  ///< the share at a voxel's centre, in 1/255
        double more = 0;                      ///< how much more of the light than that there is
    };
    struct Guess {
        double share = 0;  ///< of the light that gets there, 0 to 1
        std::uint8_t level = 0;
    };

    /// `grid` must have a directory of bricks and no background, and outlive this. `to_light`: unit direction in the
    /// world. `coefficient`: extinction, per um and unit of the grid's value.
    ShadowGrid(const SparseGrid& grid, Vec3 to_light, double coefficient);

    /// It takes at most so many lines to make one, whatever the direction; about 8 bytes each, freed again.
    static double most_lines(const SparseGrid& grid);

    /// Of a point between voxel centres. `voxel`: one around it that is not zero, for where the nearest one is zero.
    Place find(Vec3 world_um, Voxel voxel) const;
    static Guess guess(const Place& place) {
        return {std::min(1.0, (1.0 / 255) * *place.level * place.more), *place.level};
    }

    /// 512 to 1024 of those voxels, evenly from all of the grid; all of them where there are fewer.
    const std::vector<Voxel>& spots() const { return spots_; }
    std::size_t memory_bytes() const { return shares_.size() + of_blocks_.size(); }

private:
    class Sweep;

    // A voxel; its value, 0 where there is nothing; the share of light at the centre of another one in its block.
    struct Shaded {
        float value = 0;
        const std::uint8_t* level = nullptr;
        Voxel at;
    };
    Shaded look(Voxel voxel) const;

    const SparseGrid* grid_;
    Vec3 deeper_;                          // optical depth per unit of value for a voxel's step along each axis
    HugePageVector<std::uint8_t> shares_;  // by the place of the voxel's code
    std::vector<Voxel> spots_;
    std::vector<std::uint8_t> of_blocks_;  // eight per brick: at the middle voxel of constant blocks
};

}  // namespace fluovox
