#pragma once

#include "fluovox/core/interval.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace fluovox {

/// One axis of a ray, in bricks from the corner of a box: where it meets the planes between them.
struct RayAxis {
    double origin = 0, direction = 0;
    double inverse = 0, offset = 0;
    // 1 and 1 where the planes ahead are the upper ones, else 0 and -1: numbers, as conditions would mislead the
    // processor.
    int up = 1, sign = 1;

    RayAxis(double o, double d)
        : origin(o),
          direction(d),
          inverse(1 / (d + std::copysign(kLeast, d))),
          offset(-o * inverse),
          up(1 - static_cast<int>(std::bit_cast<std::uint64_t>(d) >> 63U)),
          sign(2 * up - 1) {}

    double meets(double plane) const { return plane * inverse + offset; }
    /// Brick that holds the ray at t, of so many.
    int brick(double t, int count) const { return std::clamp(static_cast<int>(origin + t * direction), 0, count - 1); }
    /// The same, but for one that is left before t, as rounding or a ray in the plane between two may have it: then the
    /// next one.
    int first_brick(double t, int count) const {
        const int at = brick(t, count);
        return meets(at + up) < t ? std::clamp(at + sign, 0, count - 1) : at;
    }
    /// The brick that is left through a plane.
    int brick_before(double plane) const { return static_cast<int>(plane) - up; }
    /// The stretch in a box of so many bricks.
    Interval within(double count) const {
        const double a = meets(0);
        const double b = meets(count);
        return {std::min(a, b), std::max(a, b)};
    }

private:
    static constexpr double kLeast = 1e-100;  // planes that the ray runs along are met too far away to matter
};

}  // namespace fluovox
