#pragma once

#include <cmath>

namespace fluovox {

/// 1 - exp(-depth), without the cost of expm1 where a few terms of its series are as exact.
inline double absorbed_share(double depth) {
    if (depth > 0.03) return -std::expm1(-depth);
    constexpr double kThird = 1.0 / 3;
    constexpr double kFifth = 1.0 / 5;
    constexpr double kSixth = 1.0 / 6;
    constexpr double kSeventh = 1.0 / 7;
    const double inner = 1 - depth * 0.25 * (1 - depth * kFifth * (1 - depth * kSixth * (1 - depth * kSeventh)));
    return depth * (1 - depth * 0.5 * (1 - depth * kThird * inner));
}

/// -log(1 - share), the depth that absorbs this share, likewise.
inline double depth_of_share(double share) {
    if (share > 0.03) return -std::log1p(-share);
    constexpr double kThird = 1.0 / 3;
    constexpr double kFifth = 1.0 / 5;
    constexpr double kSixth = 1.0 / 6;
    return share * (1 + share * (0.5 + share * (kThird + share * (0.25 + share * (kFifth + share * kSixth)))));
}

}  // namespace fluovox
