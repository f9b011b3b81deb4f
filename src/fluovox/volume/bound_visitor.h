#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace fluovox {

/// One axis of a ray in index space: where it meets the planes of the grid.
struct RayAxis {
    double origin = 0, direction = 0;
    double inverse = 0, offset = 0;
    int step = 1;

    RayAxis(double o, double d) : origin(o), direction(d), step(d < 0 ? -1 : 1) {
        constexpr double kLeast = 1e-100;  // planes that the ray runs along are met too far away to matter
        inverse = 1 / (std::abs(d) < kLeast ? step * kLeast : d);
        offset = -o * inverse;
    }
    double meets(double plane) const { return plane * inverse + offset; }
    /// Brick that holds the ray at t.
    int brick(double t) const { return floor_to_int((origin + t * direction) * (1.0 / SparseGrid::kBrickSize)); }
    /// The stretch between two planes.
    Interval between(int low, int high) const {
        const double a = meets(low);
        const double b = meets(high);
        return {std::min(a, b), std::max(a, b)};
    }
};

/// Leads a tracking (see grid_tracking.h) along a ray through a grid that has a directory of bricks. As MajorantWalk,
/// for the inner loops: stretches are bricks of 8^3 with the level of their bound (Amanatides & Woo, Eurographics
/// 1987), read from one byte each. Of the tentative collisions with that bound, those are kept that a block of 4^3 has,
/// by its share of the bound (thinning: Lewis & Shedler, Nav. Res. Logist. Q. 26 (1979) 403), which leaves just those
/// with the bounds of the blocks. Where there would be many in a brick, its blocks are walked instead.
class BoundVisitor {
public:
    BoundVisitor(const SparseGrid& grid, const Ray& ray, Interval span, double coefficient)
        : grid_(&grid),
          coefficient_(coefficient),
          origin_(grid.index_from_world().point(ray.origin)),
          direction_(grid.index_from_world().direction(ray.direction)),
          x_(origin_.x, direction_.x),
          y_(origin_.y, direction_.y),
          z_(origin_.z, direction_.z) {
        const Interval in_x = x_.between(grid.occupied_min_.x, grid.occupied_max_.x);
        const Interval in_y = y_.between(grid.occupied_min_.y, grid.occupied_max_.y);
        const Interval in_z = z_.between(grid.occupied_min_.z, grid.occupied_max_.z);
        begin_ = std::max(std::max(span.begin, in_x.begin), std::max(in_y.begin, in_z.begin));
        leave_ = std::min(std::min(span.end, in_x.end), std::min(in_y.end, in_z.end));
    }

    template <class Tracking>
    void run(Tracking& tracking) const {
        if (!(begin_ < leave_)) return;
        if (coefficient_ * grid_->max() * (leave_ - begin_) < kFew) {
            tracking.look(begin_, leave_, grid_->max(), [&] { return tap({}, nullptr, Thinning::None); });
            return;
        }
        through_bricks(tracking);
    }

private:
    // Tentative collisions worth the steps through the blocks of a brick, or through all of the grid.
    static constexpr double kFew = 0.12;
    // Where a brick has more than these, thinning them takes longer than walking its blocks.
    static constexpr double kMany = 2;
    static constexpr double kSize = SparseGrid::kBrickSize;

    enum class Thinning { None, ByBlocks };

    // Look-ups in the brick of a stretch need not start at the root.
    struct Tap {
        const SparseGrid* grid;
        const Vec3 *origin, *direction;
        Voxel first;
        const SparseGrid::Brick* brick;
        Thinning thinning;

        FixedPoint at(double t) const { return FixedPoint(*origin + t * *direction); }

        // Uses the 8 highest bits; a value takes the lowest 54.
        double local_bound(const FixedPoint& place, double bound, std::uint64_t bits) const {
            if (thinning == Thinning::None) return bound;
            constexpr int kHalf = SparseGrid::kBlockSize;
            const unsigned share = brick->bounds[place.octant({first.x + kHalf, first.y + kHalf, first.z + kHalf})];
            if (share == 0 || (bits >> 56U) > share) return 0;
            return bound * ((share + 1) * (1.0 / 256));
        }

        double value(const FixedPoint& place, std::uint64_t bits) const {
            const Voxel voxel = place.rounded(bits);
            const auto beyond = static_cast<unsigned>((voxel.x - first.x) | (voxel.y - first.y) | (voxel.z - first.z));
            if (brick != nullptr && beyond < SparseGrid::kBrickSize)
                return static_cast<double>(grid->value_in(*brick, voxel));
            return static_cast<double>(grid->value(voxel));
        }
    };

    Tap tap(Voxel first, const SparseGrid::Brick* brick, Thinning thinning) const {
        return {grid_, &origin_, &direction_, first, brick, thinning};
    }

    // First voxel of the brick that is left through this plane.
    static int first_voxel(const RayAxis& axis, double exit_plane) {
        return static_cast<int>(exit_plane) - (axis.step > 0 ? SparseGrid::kBrickSize : 0);
    }

    template <class Tracking>
    void through_bricks(Tracking& tracking) const {
        const Voxel low{grid_->occupied_min_.x / 8, grid_->occupied_min_.y / 8, grid_->occupied_min_.z / 8};
        const Voxel n = grid_->brick_count_;
        double t = begin_;
        const double leave = leave_;
        const int i = std::clamp(x_.brick(t), low.x, low.x + n.x - 1);
        const int j = std::clamp(y_.brick(t), low.y, low.y + n.y - 1);
        const int k = std::clamp(z_.brick(t), low.z, low.z + n.z - 1);
        std::ptrdiff_t slot = (static_cast<std::ptrdiff_t>(i - low.x) * n.y + (j - low.y)) * n.z + (k - low.z);
        const std::ptrdiff_t slots_x = static_cast<std::ptrdiff_t>(x_.step) * n.y * n.z;
        const std::ptrdiff_t slots_y = static_cast<std::ptrdiff_t>(y_.step) * n.z;
        const std::ptrdiff_t slots_z = z_.step;
        // The planes through which the brick is left. What they are met at is worked out afresh each time: so the last
        // ones are met just where the box ends.
        double plane_x = kSize * (i + (x_.step > 0 ? 1 : 0));
        double plane_y = kSize * (j + (y_.step > 0 ? 1 : 0));
        double plane_z = kSize * (k + (z_.step > 0 ? 1 : 0));
        const double step_x = kSize * x_.step;
        const double step_y = kSize * y_.step;
        const double step_z = kSize * z_.step;
        double next_x = x_.meets(plane_x);
        double next_y = y_.meets(plane_y);
        double next_z = z_.meets(plane_z);
        const std::uint8_t* levels = grid_->directory_.levels();
        const BoundLevels& bounds = grid_->levels_;
        const double coefficient = coefficient_;
        double rest = tracking.rest();
        for (;;) {
            const double exit = std::min(next_x, std::min(next_y, next_z));
            const double end = std::min(exit, leave);
            const double bound = bounds[levels[slot]];
            const double depth = coefficient * bound * (end - t);
            if (depth > std::min(rest, kMany)) [[unlikely]] {
                tracking.set_rest(rest);
                const Voxel first{first_voxel(x_, plane_x), first_voxel(y_, plane_y), first_voxel(z_, plane_z)};
                if (look_in_brick(tracking, slot, {t, end}, bound, first)) return;
                rest = tracking.rest();
            } else {
                rest -= depth;
            }
            if (end >= leave) break;
            t = end;
            if (next_x <= exit) {
                plane_x += step_x;
                next_x = x_.meets(plane_x);
                slot += slots_x;
            } else if (next_y <= exit) {
                plane_y += step_y;
                next_y = y_.meets(plane_y);
                slot += slots_y;
            } else {
                plane_z += step_z;
                next_z = z_.meets(plane_z);
                slot += slots_z;
            }
        }
        tracking.set_rest(rest);
    }

    // On a stretch through the brick that starts at the voxel `first`; true when the tracking ends there.
    template <class Tracking>
    bool look_in_brick(Tracking& tracking, std::ptrdiff_t slot, Interval span, double bound, Voxel first) const {
        const SparseGrid::Brick& brick = grid_->bricks_[grid_->directory_.brick(static_cast<std::size_t>(slot))];
        const double depth = coefficient_ * bound * (span.end - span.begin);
        if (depth <= kMany)
            return tracking.look_inside(span.begin, span.end, bound, tap(first, &brick, Thinning::ByBlocks));
        const auto in_brick = [&] { return tap(first, &brick, Thinning::None); };
        if (depth * brick.excess < 255 * kFew) return tracking.look(span.begin, span.end, bound, in_brick);
        return through_blocks(brick, span, first, [&](double begin, double end, double bound_of_block) {
            return tracking.look(begin, end, bound_of_block, in_brick);
        });
    }

    // The blocks on a stretch through a brick, from the one that rays in this direction meet first.
    template <class Visit>
    bool through_blocks(const SparseGrid::Brick& brick, Interval span, Voxel first, const Visit& visit) const {
        constexpr int kHalf = SparseGrid::kBlockSize;
        double t = span.begin;
        const double end = span.end;
        double half_x = x_.meets(first.x + kHalf);
        double half_y = y_.meets(first.y + kHalf);
        double half_z = z_.meets(first.z + kHalf);
        unsigned block = (x_.step < 0 ? 4U : 0U) | (y_.step < 0 ? 2U : 0U) | (z_.step < 0 ? 1U : 0U);
        if (t >= half_x) block ^= 4U, half_x = end;
        if (t >= half_y) block ^= 2U, half_y = end;
        if (t >= half_z) block ^= 1U, half_z = end;
        for (;;) {
            const double part = std::min(end, std::min(half_x, std::min(half_y, half_z)));
            const double bound = SparseGrid::bound_of(brick, block);
            if (bound > 0 && visit(t, part, bound)) return true;
            if (part >= end) return false;
            t = part;
            if (half_x <= part) {
                block ^= 4U, half_x = end;
            } else if (half_y <= part) {
                block ^= 2U, half_y = end;
            } else {
                block ^= 1U, half_z = end;
            }
        }
    }

    const SparseGrid* grid_;
    double coefficient_;
    Vec3 origin_, direction_;
    RayAxis x_, y_, z_;
    double begin_ = 0, leave_ = 0;
};

}  // namespace fluovox
