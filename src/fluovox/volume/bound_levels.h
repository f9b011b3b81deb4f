#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace fluovox {

/// Upper bounds in one byte: level 255 is the largest value, each one below is 2^(1/16) times less, the last one is 0.
class BoundLevels {
public:
    BoundLevels() = default;
    explicit BoundLevels(float largest) {
        for (std::size_t level = 1; level < kLevels; ++level) {
            const double below = static_cast<double>(kLevels - 1 - level) / kPerOctave;
            bounds_[level] = static_cast<double>(static_cast<float>(static_cast<double>(largest) * std::exp2(-below)));
        }
    }

    /// The lowest level that is not below `value`, which is at most the largest.
    std::uint8_t level_of(float value) const {
        if (!(value > 0)) return 0;
        const auto wanted = static_cast<double>(value);
        const auto* const level = std::lower_bound(bounds_.begin() + 1, bounds_.end() - 1, wanted);
        return static_cast<std::uint8_t>(level - bounds_.begin());
    }

    double operator[](std::size_t level) const { return bounds_[level]; }

private:
    static constexpr std::size_t kLevels = 256;
    static constexpr double kPerOctave = 16;

    std::array<double, kLevels> bounds_{};  // each of them a float
};

}  // namespace fluovox
