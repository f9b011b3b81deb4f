#pragma once

#include "fluovox/core/rng.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace fluovox {

/// What tracking met; summed over threads.
struct TrackingCounts {
    std::int64_t real_collisions = 0;    ///< scatterings and conversions
    std::int64_t null_collisions = 0;    ///< tentative ones of free flights that were not real
    std::int64_t shadow_collisions = 0;  ///< tentative ones of transmittances
    std::int64_t grid_lookups = 0;
    std::int64_t bound_violations = 0;  ///< a value above its bound: must stay zero

    TrackingCounts& operator+=(const TrackingCounts& other);
};

// Tracking of one coefficient (per um and unit of the grid, positive) through one grid, stretch by stretch. `Tap` gives
// a stochastic tap of the grid: value(t, bits).

/// One tap at `t`, counted.
template <class Tap>
double counted_tap(const Tap& tap, double bound, double t, Rng& rng, TrackingCounts& counts) {
    ++counts.grid_lookups;
    const double value = tap(t, rng.bits());
    if (value > bound) ++counts.bound_violations;
    return value;
}

/// Where the first collision is: delta tracking (Woodcock et al., ANL-7050, 1965).
class CollisionSearch {
public:
    CollisionSearch(double coefficient, Rng& rng, TrackingCounts& counts)
        : coefficient_(coefficient), rng_(&rng), counts_(&counts), depth_(rng) {}

    /// Looks at a stretch on which the grid is at most `bound`; true when the collision is there.
    template <class MakeTap>
    bool look(double begin, double end, double bound, const MakeTap& make_tap) {
        const double majorant = coefficient_ * bound;
        if (!depth_.ends_within(majorant * (end - begin))) return false;
        return look_inside(begin, end, bound, make_tap());
    }

    /// Micrometres along the ray; infinite when there was none.
    double found() const { return found_; }

private:
    // Once the next tentative collision is known to be there.
    template <class Tap>
    bool look_inside(double t, double end, double bound, const Tap& tap) {
        const double majorant = coefficient_ * bound;
        do {
            t += depth_.rest() / majorant;
            const double value = counted_tap(tap, bound, t, *rng_, *counts_);
            if (value > 0 && rng_->uniform() * bound < value) {
                found_ = t;
                return true;
            }
            ++counts_->null_collisions;
            depth_ = ExponentialDistance(*rng_);
        } while (depth_.ends_within(majorant * (end - t)));
        return false;
    }

    double coefficient_;
    Rng* rng_;
    TrackingCounts* counts_;
    ExponentialDistance depth_;
    double found_ = std::numeric_limits<double>::infinity();
};

/// Unbiased estimate of the share of light that gets through: ratio tracking (Novak et al., ACM Trans. Graph. 33 (2014)
/// 179), by roulette where little is left.
class RatioTracking {
public:
    RatioTracking(double coefficient, Rng& rng, TrackingCounts& counts)
        : coefficient_(coefficient), rng_(&rng), counts_(&counts), depth_(rng) {}

    /// Takes a stretch on which the grid is at most `bound`; true when nothing is left.
    template <class MakeTap>
    bool look(double begin, double end, double bound, const MakeTap& make_tap) {
        const double majorant = coefficient_ * bound;
        if (!depth_.ends_within(majorant * (end - begin))) return false;
        return look_inside(begin, end, bound, make_tap());
    }

    double left() const { return left_; }

private:
    template <class Tap>
    bool look_inside(double t, double end, double bound, const Tap& tap) {
        constexpr double kDim = 0.1;
        if (!std::isfinite(end)) {  // background for ever
            left_ = 0;
            return true;
        }
        const double majorant = coefficient_ * bound;
        do {
            t += depth_.rest() / majorant;
            depth_ = ExponentialDistance(*rng_);
            ++counts_->shadow_collisions;
            const double value = counted_tap(tap, bound, t, *rng_, *counts_);
            if (value <= 0) continue;
            left_ *= 1 - value / bound;
            if (left_ >= kDim) continue;
            const bool survives = rng_->uniform() * kDim < left_;
            left_ = survives ? kDim : 0;
            if (!survives) return true;
        } while (depth_.ends_within(majorant * (end - t)));
        return false;
    }

    double coefficient_;
    Rng* rng_;
    TrackingCounts* counts_;
    ExponentialDistance depth_;
    double left_ = 1;
};

}  // namespace fluovox
