#include "fluovox/transport/shadow_guess.h"

#include "fluovox/core/rng.h"
#include "fluovox/volume/grid_integral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace fluovox {

ShadowGuess::ShadowGuess(const SparseGrid& grid, Vec3 to_light, double coefficient)
    : shadows_(grid, to_light, coefficient) {
    find_chances(grid, to_light, coefficient);
}

// What corrections add to the noise, for so many of them, is least where their chance is in proportion to the error.
// For what they take of the time, the factor is about the best for the grids that were measured.
void ShadowGuess::find_chances(const SparseGrid& grid, Vec3 to_light, double coefficient) {
    constexpr double kPerError = 0.25;  // where all light gets through
    constexpr double kLeast = 1.0 / 256;
    constexpr double kOthers = 4;            // a bin's own error counts as that of so many voxels does
    constexpr double kShareOfUsual = 0.125;  // no bin is thought to be better than that
    constexpr std::size_t kBins = 16;
    struct Squares {
        double sum = 0, count = 0;

        void add(double value) {
            sum += value * value;
            ++count;
        }
        double mean() const { return count > 0 ? sum / count : 1; }
    };
    const auto bin_of = [](std::size_t level) {  // narrow ones where little gets through
        return static_cast<std::size_t>(std::sqrt(static_cast<double>(level)));
    };
    Squares light;
    Squares errors;
    std::array<Squares, kBins> by_bin;
    Rng rng(0x736861646f77, 0, 0);
    const auto aside = [&] { return rng.uniform() - 0.5; };
    for (const Voxel& spot : shadows_.spots()) {
        const Vec3 place{spot.x + aside(), spot.y + aside(), spot.z + aside()};
        const Vec3 world = grid.world_from_index().point(place);
        const ShadowGrid::Guess guess = ShadowGrid::guess(shadows_.find(world, spot));
        const double truth = std::exp(-coefficient * integral_along(grid, {world, to_light}));
        light.add(truth);
        errors.add(truth - guess.share);
        by_bin[bin_of(guess.level)].add(truth - guess.share);
    }
    const double usual = errors.mean();
    const double per_error = kPerError / std::sqrt(std::max(light.mean(), 1e-6));
    for (std::size_t level = 0; level < chances_.size(); ++level) {
        const Squares& bin = by_bin[bin_of(level)];
        const double square = (bin.sum + kOthers * usual) / (bin.count + kOthers);
        const double error = std::sqrt(std::max(square, kShareOfUsual * kShareOfUsual * usual));
        chances_[level] = std::clamp(per_error * error, kLeast, 1.0);
    }
}

}  // namespace fluovox
