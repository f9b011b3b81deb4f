#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/transport/roulette.h"
#include "fluovox/volume/fixed_point.h"

#include <cmath>
#include <cstdint>
#include <limits>

namespace fluovox {

/// What tracking met; summed over threads.
struct TrackingCounts {
    std::int64_t real_collisions = 0;    ///< scatterings and conversions
    std::int64_t null_collisions = 0;    ///< tentative ones (by the local bound) of free flights that were not real
    std::int64_t shadow_collisions = 0;  ///< tentative ones of transmittances
    std::int64_t grid_lookups = 0;
    std::int64_t bound_violations = 0;  ///< a value above its bound: must stay zero

    TrackingCounts& operator+=(const TrackingCounts& other);
};

// Tracking of one coefficient (per um and unit of the grid, positive) through one grid, stretch by stretch. A `Tap`
// gives stochastic taps of the grid: at(t) is a place; local_bound(place, bound, bits) the bound there, or 0 with the
// probability that a tentative collision with `bound` is none with that; value(place, bits), of voxel(place, bits).

/// One tap where the grid is at most `bound`, counted.
template <class Tap, class Place>
double counted_tap(const Tap& tap, const Place& place, double bound, std::uint64_t bits, TrackingCounts& counts) {
    ++counts.grid_lookups;
    const double value = tap.value(place, bits);
    if (value > bound) ++counts.bound_violations;
    return value;
}

/// A real collision with a grid.
struct GridCollision {
    double t_um = std::numeric_limits<double>::infinity();
    Voxel voxel;  ///< whose value was taken; only where a BoundVisitor leads
};

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

    /// Infinitely far away when there was none.
    const GridCollision& found() const { return found_; }

    /// Optical depth by the bounds to the next tentative collision.
    double rest() const { return depth_.rest(); }
    void set_rest(double rest) { depth_ = ExponentialDistance(rest); }

    /// The same once the next tentative collision is known to be there.
    template <class Tap>
    bool look_inside(double t, double end, double bound, const Tap& tap) {
        const double majorant = coefficient_ * bound;
        do {
            t += depth_.rest() / majorant;
            const auto place = tap.at(t);
            const std::uint64_t bits = rng_->bits();
            const double local = tap.local_bound(place, bound, bits);
            if (local > 0) {
                const double value = counted_tap(tap, place, local, bits, *counts_);
                if (value > 0 && rng_->uniform() * local < value) {
                    found_ = {t, tap.voxel(place, bits)};
                    return true;
                }
                ++counts_->null_collisions;
            }
            depth_ = ExponentialDistance(*rng_);
        } while (depth_.ends_within(majorant * (end - t)));
        return false;
    }

private:
    double coefficient_;
    Rng* rng_;
    TrackingCounts* counts_;
    ExponentialDistance depth_;
    GridCollision found_;
};

/// Unbiased estimate of the share of light that gets through: ratio tracking (Novak et al., ACM Trans. Graph. 33 (2014)
/// 179). Where less than `dim` is left, that or nothing goes on, by roulette; with 1 all or nothing gets through, and
/// the walk ends where a flight would (delta tracking).
class RatioTracking {
public:
    RatioTracking(double coefficient, double dim, Rng& rng, TrackingCounts& counts)
        : coefficient_(coefficient), dim_(dim), rng_(&rng), counts_(&counts), depth_(rng) {}

    /// Takes a stretch on which the grid is at most `bound`; true when nothing is left.
    template <class MakeTap>
    bool look(double begin, double end, double bound, const MakeTap& make_tap) {
        const double majorant = coefficient_ * bound;
        if (!depth_.ends_within(majorant * (end - begin))) return false;
        return look_inside(begin, end, bound, make_tap());
    }

    double left() const { return left_; }

    /// Optical depth by the bounds to the next tentative collision.
    double rest() const { return depth_.rest(); }
    void set_rest(double rest) { depth_ = ExponentialDistance(rest); }

    /// The same once the next tentative collision is known to be there.
    template <class Tap>
    bool look_inside(double t, double end, double bound, const Tap& tap) {
        if (!std::isfinite(end)) {  // background for ever
            left_ = 0;
            return true;
        }
        const double majorant = coefficient_ * bound;
        do {
            t += depth_.rest() / majorant;
            depth_ = ExponentialDistance(*rng_);
            const auto place = tap.at(t);
            const std::uint64_t bits = rng_->bits();
            const double local = tap.local_bound(place, bound, bits);
            if (local <= 0) continue;
            ++counts_->shadow_collisions;
            const double value = counted_tap(tap, place, local, bits, *counts_);
            if (value <= 0) continue;
            left_ *= 1 - value / local;
            if (survives(left_, dim_, *rng_)) continue;
            left_ = 0;
            return true;
        } while (depth_.ends_within(majorant * (end - t)));
        return false;
    }

private:
    double coefficient_, dim_;
    Rng* rng_;
    TrackingCounts* counts_;
    ExponentialDistance depth_;
    double left_ = 1;
};

}  // namespace fluovox
