#pragma once

#include "fluovox/core/vec.h"

#include <cstdint>

namespace fluovox {

/// Integer position of a voxel. Its centre is at the same index-space coordinates.
struct Voxel {
    int x = 0, y = 0, z = 0;
};

/// An index-space position in steps of 2^-18 voxels; |coordinates| < 2^31.
class FixedPoint {
public:
    static constexpr unsigned kBits = 18;  ///< of the fraction

    explicit FixedPoint(Vec3 position) : x_(fixed(position.x)), y_(fixed(position.y)), z_(fixed(position.z)) {}

    /// One of the eight voxels around it, drawn with the trilinear weights by the lowest 54 of some random bits.
    Voxel rounded(std::uint64_t bits) const {
        constexpr std::uint64_t kFraction = (1U << kBits) - 1;
        const auto up = [](std::int64_t at, std::uint64_t drawn) {
            return static_cast<int>((at + static_cast<std::int64_t>(drawn & kFraction)) >> kBits);
        };
        return {up(x_, bits), up(y_, bits >> kBits), up(z_, bits >> (2 * kBits))};
    }

    /// Which of the eight parts of space that meet at a voxel's centre it lies in: 4, 2 and 1 for the upper halves
    /// along x, y and z.
    unsigned octant(Voxel middle) const {
        const auto above = [](std::int64_t at, int plane) { return at >= std::int64_t{plane} * (1 << kBits); };
        return (above(x_, middle.x) ? 4U : 0U) | (above(y_, middle.y) ? 2U : 0U) | (above(z_, middle.z) ? 1U : 0U);
    }

private:
    // The conversion rounds towards zero, so it is made of a positive number.
    static std::int64_t fixed(double at) {
        constexpr double kOne = 1U << kBits;
        constexpr double kMost = 0x1.0p31;
        constexpr std::int64_t kShifted = std::int64_t{1} << (31 + kBits);
        return static_cast<std::int64_t>(at * kOne + kMost * kOne) - kShifted;
    }

    std::int64_t x_, y_, z_;
};

}  // namespace fluovox
