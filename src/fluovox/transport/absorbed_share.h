#pragma once

#include <cmath>

namespace fluovox {

/// 1 - exp(-depth), without the cost of expm1 where a few terms of its series are as exact.
inline double absorbed_share(double depth) {
    if (depth > 0.03) return -std::expm1(-depth);
    // By pairs of terms: the processor works them out side by side.
    const double square = depth * depth;
    const double first = 1 - 0.5 * depth;
    const double second = 1.0 / 6 - (1.0 / 24) * depth;
    const double third = 1.0 / 120 - (1.0 / 720) * depth + (1.0 / 5040) * square;
    return depth * (first + square * (second + square * third));
}

/// -log(1 - share), the depth that absorbs this share, likewise.
inline double depth_of_share(double share) {
    if (share > 0.01) return -std::log1p(-share);
    const double square = share * share;
    const double first = 1 + 0.5 * share;
    const double second = 1.0 / 3 + 0.25 * share;
    const double third = 1.0 / 5 + (1.0 / 6) * share;
    const double fourth = 1.0 / 7 + 0.125 * share;
    return share * (first + square * (second + square * (third + square * fourth)));
}

}  // namespace fluovox
