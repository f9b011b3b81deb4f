#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/spectral/lanes.h"

namespace fluovox {

/// What a path may be worth before it is cut short. More, as absorption would have it, is a little quicker where light
/// comes back to where it came from, and many times slower where it comes through.
inline constexpr double kFaintPath = 0.05;

inline double worth(double weight) {
    return weight;
}
inline double worth(const Lanes& weights) {
    return weights.max();
}
inline void make_worth(double& weight, double value) {
    weight = value;  // just that
}
inline void make_worth(Lanes& weights, double value) {
    weights *= value / weights.max();
}

/// Russian roulette where something is worth less than `faint` (in its largest lane): false when it ends, and else it
/// is worth that, and stands for those that ended. The expectation stays. Arvo & Kirk, SIGGRAPH 1990, p. 63.
template <class Weight>
bool survives(Weight& weight, double faint, Rng& rng) {
    const double left = worth(weight);
    if (left >= faint) return true;
    if (rng.uniform() * faint >= left) return false;
    make_worth(weight, faint);
    return true;
}

}  // namespace fluovox
