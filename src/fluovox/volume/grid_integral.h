#pragma once

#include "fluovox/core/vec.h"
#include "fluovox/volume/fixed_point.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>

namespace fluovox {

/// The integral of a trilinear field along a ray, in units of its value times micrometres: exact but for rounding, as
/// between voxel centres the field is a polynomial of third degree, for which two points of Gauss do. BoundVisitor
/// leads it as it leads a tracking.
class GridIntegral {
public:
    /// It may end once it is `enough`.
    explicit GridIntegral(double enough) : enough_(enough) {}

    /// Adds a ray from its origin to the end of the grid, which must have a directory of bricks and no background.
    void add(const SparseGrid& grid, const Ray& ray);

    double total() const { return total_; }
    /// Where it ended, if for being enough; in micrometres along the ray.
    double end() const { return end_; }
    std::int64_t lookups() const { return cell_.lookups; }  ///< of voxels

    // What BoundVisitor asks of a tracking.
    static double rest() { return 0; }
    void set_rest(double /*rest*/) {}
    template <class MakeTap>
    bool look(double begin, double end, double bound, const MakeTap& make_tap) {
        return look_inside(begin, end, bound, make_tap());
    }
    template <class Tap>
    bool look_inside(double begin, double end, double bound, const Tap& tap);

private:
    // Along one axis: to the first plane through voxel centres, and from one to the next.
    struct Planes {
        double next = std::numeric_limits<double>::infinity(), step = next;
        bool up = true;

        Planes(double begin, double above, double speed) {
            if (speed == 0) return;
            step = 1 / std::abs(speed);
            up = speed > 0;
            next = begin + (up ? 1 - above : above) * step;
        }
    };

    // The voxels at the corners of a cell between them. Bits 4, 2 and 1 of an index: the upper ones along x, y and z.
    struct Cell {
        Voxel low;  // counted as the tap counts
        std::array<float, 8> values{};
        std::int64_t lookups = 0;

        template <class Tap>
        void move_to(Voxel voxel, const Tap& tap);
        template <unsigned kAxis, class Tap>
        void step(bool up, const Tap& tap);
        bool is_empty() const {
            return values[0] + values[1] + values[2] + values[3] + values[4] + values[5] + values[6] + values[7] <= 0;
        }
        double at(Vec3 place) const;
    };

    static constexpr Voxel kNone{std::numeric_limits<int>::min() / 2, 0, 0};  // no cell is so far out

    double enough_;
    double total_ = 0;
    double end_ = 0;
    Cell cell_{kNone, {}, 0};  // the last one
};

/// All of it.
double integral_along(const SparseGrid& grid, const Ray& ray);

template <class Tap>
bool GridIntegral::look_inside(double begin, double end, double /*bound*/, const Tap& tap) {
    const Vec3 origin = tap.origin_in_voxels();
    const Vec3 speed = tap.voxels_per_um();
    const Vec3 from = origin + begin * speed;
    const Vec3 base{std::floor(from.x), std::floor(from.y), std::floor(from.z)};
    Planes x(begin, from.x - base.x, speed.x);
    Planes y(begin, from.y - base.y, speed.y);
    Planes z(begin, from.z - base.z, speed.z);
    Cell cell = cell_;
    cell.move_to({static_cast<int>(base.x), static_cast<int>(base.y), static_cast<int>(base.z)}, tap);
    double t = begin;
    for (;;) {
        const double exit = std::min(end, std::min(x.next, std::min(y.next, z.next)));
        if (exit > t && !cell.is_empty()) {
            const double half = 0.5 * (exit - t);
            const Vec3 low{1.0 * cell.low.x, 1.0 * cell.low.y, 1.0 * cell.low.z};
            const Vec3 middle = origin + (t + half) * speed - low;
            const Vec3 aside = half * std::numbers::inv_sqrt3 * speed;
            total_ += half * (cell.at(middle - aside) + cell.at(middle + aside));
        }
        if (exit >= end) break;
        t = exit;
        if (x.next <= exit) {
            x.next += x.step;
            cell.step<4>(x.up, tap);
        } else if (y.next <= exit) {
            y.next += y.step;
            cell.step<2>(y.up, tap);
        } else {
            z.next += z.step;
            cell.step<1>(z.up, tap);
        }
    }
    cell_ = cell;
    end_ = end;
    return total_ >= enough_;
}

// Mostly it is the same cell, or the next one along an axis.
template <class Tap>
void GridIntegral::Cell::move_to(Voxel voxel, const Tap& tap) {
    const Voxel apart{voxel.x - low.x, voxel.y - low.y, voxel.z - low.z};
    const int steps = std::abs(apart.x) + std::abs(apart.y) + std::abs(apart.z);
    if (steps > 1) {
        low = voxel;
        for (unsigned i = 0; i < 8; ++i)
            values[i] = tap.value(low, i);
        lookups += 8;
    } else if (apart.x != 0) {
        step<4>(apart.x > 0, tap);
    } else if (apart.y != 0) {
        step<2>(apart.y > 0, tap);
    } else if (apart.z != 0) {
        step<1>(apart.z > 0, tap);
    }
}

// Along the axis of that bit: half of the corners are known.
template <unsigned kAxis, class Tap>
void GridIntegral::Cell::step(bool up, const Tap& tap) {
    int& along = kAxis == 4 ? low.x : kAxis == 2 ? low.y : low.z;
    along += up ? 1 : -1;
    constexpr unsigned kOne = kAxis == 1 ? 2 : 1;
    constexpr unsigned kOther = kAxis == 4 ? 2 : 4;
    for (const unsigned corner : {0U, kOne, kOther, kOne | kOther}) {
        const unsigned fresh = up ? corner | kAxis : corner;
        values[fresh ^ kAxis] = values[fresh];
        values[fresh] = tap.value(low, fresh);
    }
    lookups += 4;
}

// At a place from its low corner.
inline double GridIntegral::Cell::at(Vec3 place) const {
    const auto mix = [](double a, double b, double share) { return a + share * (b - a); };
    const auto along_z = [&](std::size_t i) {
        return mix(static_cast<double>(values[i]), static_cast<double>(values[i + 1]), place.z);
    };
    return mix(mix(along_z(0), along_z(2), place.y), mix(along_z(4), along_z(6), place.y), place.x);
}

}  // namespace fluovox
