#include "fluovox/spectral/lanes.h"

#include <bit>
#include <cmath>
#include <cstdint>

namespace fluovox {
namespace {

// exp(x) for |x| <= ln(2) / 2: its series, up to the term that no longer counts.
double exp_near_zero(double x) {
    double sum = 1.0 / 6227020800;
    for (const double term : {1.0 / 479001600, 1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040,
                              1.0 / 720, 1.0 / 120, 1.0 / 24, 1.0 / 6, 0.5, 1.0, 1.0}) {
        sum = sum * x + term;
    }
    return sum;
}

}  // namespace

// Without branches or calls, so that the compiler takes several lanes at once.
Lanes exp_minus(const Lanes& depth) {
    constexpr double kLog2e = 1.4426950408889634;
    // ln(2) in two parts: multiples of the first are exact.
    constexpr double kLn2High = 0x1.62e42feep-1;
    constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
    constexpr double kLargest = 708;
    // Added to a small number it leaves its nearest integer in the lowest bits.
    constexpr double kRounder = 0x1.8p52;
    Lanes result(depth.count());
    if (depth.count() == 1) {
        result[0] = std::exp(-depth[0]);
        return result;
    }
    for (int i = 0; i < depth.count(); ++i) {
        double x = -depth[i];
        x = x < -kLargest ? -kLargest : x;
        x = x > kLargest ? kLargest : x;
        const double rounded = x * kLog2e + kRounder;
        const double whole = rounded - kRounder;
        const double rest = (x - whole * kLn2High) - whole * kLn2Low;
        const std::uint64_t exponent = (std::bit_cast<std::uint64_t>(rounded) + 1023U) << 52U;
        const double value = exp_near_zero(rest) * std::bit_cast<double>(exponent);
        result[i] = depth[i] > kLargest ? 0 : value;
    }
    return result;
}

}  // namespace fluovox
