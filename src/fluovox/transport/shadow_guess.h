#pragma once

#include "fluovox/core/vec.h"
#include "fluovox/volume/fixed_point.h"
#include "fluovox/volume/shadow_grid.h"
#include "fluovox/volume/sparse_grid.h"

#include <array>
#include <cstddef>

namespace fluovox {

/// A guess of how much of a collimated light gets through a grid to where it scatters, and how seldom that needs to be
/// corrected. With the chance p of a correction, guess + (truth - guess) / p has the expectation of the truth, whatever
/// the guess is (a control variate, its rest by Russian roulette): a good one saves most of the rays to the light, and
/// their noise. A correction may be negative.
class ShadowGuess {
public:
    struct Guess {
        double share = 0;   ///< of the light, 0 to 1
        double chance = 1;  ///< with which it is to be corrected: above 0
    };

    /// `grid`, `to_light`, `coefficient`: see ShadowGrid. A few hundred voxels tell how far guesses are off.
    ShadowGuess(const SparseGrid& grid, Vec3 to_light, double coefficient);

    /// See ShadowGrid.
    ShadowGrid::Place find(Vec3 world_um, Voxel voxel) const { return shadows_.find(world_um, voxel); }
    Guess at(const ShadowGrid::Place& place) const {
        const auto [share, level] = ShadowGrid::guess(place);
        return {share, chances_[level]};
    }

    std::size_t memory_bytes() const { return shadows_.memory_bytes(); }

private:
    void find_chances(const SparseGrid& grid, Vec3 to_light, double coefficient);

    ShadowGrid shadows_;
    std::array<double, 256> chances_{};  // by the level of a guess
};

}  // namespace fluovox
