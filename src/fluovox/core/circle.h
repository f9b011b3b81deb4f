#pragma once

#include <initializer_list>

namespace fluovox {

/// A point of the unit circle.
struct CirclePoint {
    double cos = 1, sin = 0;
};

/// The point at `turns` of a full turn, from 0 to 1; right to about 1e-15. Without branches or calls, as random turns
/// would mislead the processor: series of a quarter of the angle, doubled twice.
constexpr CirclePoint on_circle(double turns) {
    constexpr double kPi = 3.141592653589793238;
    const double y = (0.5 * kPi) * (turns - 0.5);  // at most pi / 4 either way
    const double z = y * y;
    double s = 0;
    for (const double term : {-1.0 / 1307674368000, 1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880, -1.0 / 5040,
                              1.0 / 120, -1.0 / 6, 1.0 / 1})
        s = s * z + term;
    s *= y;
    double c = 0;
    for (const double term : {1.0 / 20922789888000, -1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320,
                              -1.0 / 720, 1.0 / 24, -1.0 / 2, 1.0 / 1})
        c = c * z + term;
    const double cos_half = 1 - 2 * s * s;
    const double sin_half = 2 * s * c;
    return {2 * sin_half * sin_half - 1, -2 * sin_half * cos_half};
}

}  // namespace fluovox
