#pragma once

#include "fluovox/core/vec.h"

#include <algorithm>
#include <cstdint>

namespace fluovox {

/// Integer position of a voxel. Its centre is at the same index-space coordinates.
struct Voxel {
    int x = 0, y = 0, z = 0;
};

/// An index-space position in steps of 2^-18 voxels. Coordinates beyond +-(2^31 - 2), as in a background for ever,
/// count as these.
class FixedPoint {
public:
    static constexpr unsigned kBits = 18;  ///< of the fraction

    explicit FixedPoint(Vec3 position) : x_(fixed(position.x)), y_(fixed(position.y)), z_(fixed(position.z)) {}

    /// Of a position in bricks of 8^3 voxels, none of its coordinates negative but by rounding; from the corner of the
    /// brick `first` on.
    static FixedPoint from_brick(Vec3 bricks, Voxel first) {
        constexpr double kSteps = 1U << (3 + kBits);
        const auto along = [](double at, int corner) {
            return static_cast<std::int64_t>(at * kSteps) - std::int64_t{corner} * (1 << (3 + kBits));
        };
        return {along(bricks.x, first.x), along(bricks.y, first.y), along(bricks.z, first.z)};
    }

    /// One of the eight voxels around it, drawn with the trilinear weights by the lowest 54 of some random bits.
    Voxel rounded(std::uint64_t bits) const {
        constexpr std::uint64_t kFraction = (1U << kBits) - 1;
        const auto up = [](std::int64_t at, std::uint64_t drawn) {
            return static_cast<int>((at + static_cast<std::int64_t>(drawn & kFraction)) >> kBits);
        };
        return {up(x_, bits), up(y_, bits >> kBits), up(z_, bits >> (2 * kBits))};
    }

    /// Which of the 4^3 cells of a brick it lies in, z fastest, or is nearest to; counted from the corner of the brick.
    unsigned cell() const {
        const auto along = [](std::int64_t at) {
            return static_cast<unsigned>(std::clamp<std::int64_t>(at >> (1 + kBits), 0, 3));
        };
        return along(x_) << 4U | along(y_) << 2U | along(z_);
    }

private:
    FixedPoint(std::int64_t x, std::int64_t y, std::int64_t z) : x_(x), y_(y), z_(z) {}

    // The conversion rounds towards zero, so it is made of a positive number.
    static std::int64_t fixed(double at) {
        constexpr double kOne = 1U << kBits;
        constexpr double kMost = 0x1.0p31;
        constexpr double kFarthest = kMost - 2;  // the next voxel has a number too
        constexpr std::int64_t kShifted = std::int64_t{1} << (31 + kBits);
        return static_cast<std::int64_t>(std::clamp(at, -kFarthest, kFarthest) * kOne + kMost * kOne) - kShifted;
    }

    std::int64_t x_, y_, z_;
};

}  // namespace fluovox
