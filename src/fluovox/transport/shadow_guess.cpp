#include "fluovox/transport/shadow_guess.h"

#include "fluovox/core/rng.h"
#include "fluovox/volume/grid_integral.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {

ShadowGuess::ShadowGuess(const SparseGrid& grid, Vec3 to_light, double coefficient)
    : shadows_(grid, to_light, coefficient) {
    find_chances(grid, to_light, coefficient);
}

std::size_t ShadowGuess::bin_of(double share) {
    return std::min(kBins - 1, static_cast<std::size_t>(kBins * std::sqrt(share)));
}

// The variance that corrections add per ray to the light is least where their chance is in proportion to the error; the
// factor is about the best for grids that were measured, and it matters little.
void ShadowGuess::find_chances(const SparseGrid& grid, Vec3 to_light, double coefficient) {
    constexpr double kPerError = 0.6;
    constexpr double kLeast = 1.0 / 256;
    constexpr double kOthers = 4;  // a bin's own error counts as that of so many voxels does
    struct Errors {
        double squares = 0, count = 0;

        void add(double error) {
            squares += error * error;
            ++count;
        }
    };
    Errors all;
    std::array<Errors, kBins> bins;
    Rng rng(0x736861646f77, 0, 0);
    const auto aside = [&] { return rng.uniform() - 0.5; };
    for (const Voxel& spot : shadows_.spots()) {
        const Vec3 index{spot.x + aside(), spot.y + aside(), spot.z + aside()};
        const Vec3 world = grid.world_from_index().point(index);
        const double guess = shadows_.guess(world, spot);
        const double truth = std::exp(-coefficient * integral_along(grid, {world, to_light}));
        bins[bin_of(guess)].add(truth - guess);
        all.add(truth - guess);
    }
    const double usual = all.count > 0 ? all.squares / all.count : 1;
    for (std::size_t i = 0; i < kBins; ++i) {
        const double square = (bins[i].squares + kOthers * usual) / (bins[i].count + kOthers);
        chances_[i] = std::clamp(kPerError * std::sqrt(square), kLeast, 1.0);
    }
}

}  // namespace fluovox
