#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/ray_axis.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <cstdint>

namespace fluovox {

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
          origin_(grid.to_bricks_.point(ray.origin)),
          direction_(grid.to_bricks_.direction(ray.direction)),
          x_(origin_.x, direction_.x),
          y_(origin_.y, direction_.y),
          z_(origin_.z, direction_.z) {
        const Interval in_x = x_.within(grid.to_bricks_.count.x);
        const Interval in_y = y_.within(grid.to_bricks_.count.y);
        const Interval in_z = z_.within(grid.to_bricks_.count.z);
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
        if (direction_.x == 0 && direction_.y == 0) {
            through_column(tracking);
        } else {
            through_bricks(tracking);
        }
    }

private:
    // Tentative collisions worth the steps through the grid.
    static constexpr double kFew = 0.12;
    // Where a brick has more than these, and so many would be thinned out, walking its blocks is quicker.
    static constexpr double kMany = 2;
    static constexpr double kThinnedOut = 1;

    enum class Thinning { None, ByBlocks };

    // Look-ups in the brick of a stretch need not start at the root.
    struct Tap {
        static constexpr int kSize = SparseGrid::kBrickSize;

        const SparseGrid* grid;
        const Vec3 *origin, *direction;
        Voxel first;  // brick of the stretch, or that at the corner of the box
        const SparseGrid::Brick* brick;
        Thinning thinning;

        FixedPoint at(double t) const { return FixedPoint::from_brick(*origin + t * *direction, first); }

        // Uses the 8 highest bits; a value takes the lowest 54.
        double local_bound(const FixedPoint& place, double bound, std::uint64_t bits) const {
            if (thinning == Thinning::None) return bound;
            const unsigned share = brick->bounds[place.block()];
            if (share == 0 || (bits >> 56U) > share) return 0;
            return bound * ((share + 1) * (1.0 / 256));
        }

        double value(const FixedPoint& place, std::uint64_t bits) const {
            const Voxel voxel = place.rounded(bits);
            if (brick != nullptr && static_cast<unsigned>(voxel.x | voxel.y | voxel.z) < kSize)
                return static_cast<double>(grid->value_in(*brick, voxel));
            return static_cast<double>(grid->value_in_box(in_box(voxel)));
        }

        /// The voxel of that value.
        Voxel voxel(const FixedPoint& place, std::uint64_t bits) const {
            const Voxel from_corner = in_box(place.rounded(bits));
            const Voxel corner = grid->occupied_min_;
            return {corner.x + from_corner.x, corner.y + from_corner.y, corner.z + from_corner.z};
        }

        // What GridIntegral asks for, in voxels counted from the corner of the box of bricks.
        Vec3 origin_in_voxels() const { return kSize * *origin; }
        Vec3 voxels_per_um() const { return kSize * *direction; }
        /// Of a corner of the cell between eight voxels: 4, 2 and 1 for the upper ones along x, y and z.
        float value(Voxel low, unsigned corner) const {
            const Voxel voxel{low.x + static_cast<int>(corner >> 2U), low.y + static_cast<int>((corner >> 1U) & 1U),
                              low.z + static_cast<int>(corner & 1U)};
            const Voxel from_first{voxel.x - kSize * first.x, voxel.y - kSize * first.y, voxel.z - kSize * first.z};
            if (brick != nullptr && static_cast<unsigned>(from_first.x | from_first.y | from_first.z) < kSize)
                return grid->value_in(*brick, from_first);
            return grid->value_in_box(voxel);
        }

        Voxel in_box(Voxel from_first) const {
            return {kSize * first.x + from_first.x, kSize * first.y + from_first.y, kSize * first.z + from_first.z};
        }
    };

    Tap tap(Voxel first, const SparseGrid::Brick* brick, Thinning thinning) const {
        return {grid_, &origin_, &direction_, first, brick, thinning};
    }

    // Along z, as many cameras look: the levels of a column lie in order, and empty bricks are passed by fours.
    template <class Tracking>
    void through_column(Tracking& tracking) const {
        const BrickDirectory& directory = grid_->directory_;
        const Voxel n = grid_->brick_count_;
        const int i = x_.brick(begin_, n.x);
        const int j = y_.brick(begin_, n.y);
        const std::size_t column = grid_->brick_place(i, j, 0);
        const auto first_from = [&](int k) {  // on the way; one too many where there is none
            const auto at = column + static_cast<std::size_t>(k);
            if (z_.up != 0)
                return static_cast<int>(directory.next_filled(at, column + static_cast<std::size_t>(n.z)) - column);
            return static_cast<int>(directory.last_filled(column, at + 1) - column) - 1;
        };
        double t = begin_;
        double rest = tracking.rest();
        for (int k = first_from(z_.brick(t, n.z)); k >= 0 && k < n.z; k = first_from(k)) {
            t = std::max(t, z_.meets(k + 1 - z_.up));
            if (t >= leave_) break;
            const double end = std::min(z_.meets(k + z_.up), leave_);
            const std::size_t place = column + static_cast<std::size_t>(k);
            const double bound = grid_->levels_[directory.level(place)];
            const double depth = coefficient_ * bound * (end - t);
            if (depth > std::min(rest, kMany)) {
                tracking.set_rest(rest);
                if (look_in_brick(tracking, place, {t, end}, bound, {i, j, k})) return;
                rest = tracking.rest();
            } else {
                rest -= depth;
            }
            k += z_.sign;
        }
        tracking.set_rest(rest);
    }

    template <class Tracking>
    void through_bricks(Tracking& tracking) const {
        const Voxel n = grid_->brick_count_;
        double t = begin_;
        const double leave = leave_;
        const int i = x_.brick(t, n.x);
        const int j = y_.brick(t, n.y);
        const int k = z_.brick(t, n.z);
        const auto in_column = static_cast<std::ptrdiff_t>(grid_->places_in_column_);
        auto place = static_cast<std::ptrdiff_t>(grid_->brick_place(i, j, k));
        const std::ptrdiff_t places_x = x_.sign * n.y * in_column;
        const std::ptrdiff_t places_y = y_.sign * in_column;
        const std::ptrdiff_t places_z = z_.sign;
        // The planes through which the brick is left. What they are met at is worked out afresh each time: so the last
        // ones are met just where the box ends.
        double plane_x = i + x_.up;
        double plane_y = j + y_.up;
        double plane_z = k + z_.up;
        const double step_x = x_.sign;
        const double step_y = y_.sign;
        const double step_z = z_.sign;
        double next_x = x_.meets(plane_x);
        double next_y = y_.meets(plane_y);
        double next_z = z_.meets(plane_z);
        const BrickDirectory& directory = grid_->directory_;
        const BoundLevels& bounds = grid_->levels_;
        const double coefficient = coefficient_;
        double rest = tracking.rest();
        for (;;) {
            const double exit = std::min(next_x, std::min(next_y, next_z));
            const double end = std::min(exit, leave);
            const double bound = bounds[directory.level(static_cast<std::size_t>(place))];
            const double depth = coefficient * bound * (end - t);
            if (depth > std::min(rest, kMany)) [[unlikely]] {
                tracking.set_rest(rest);
                const Voxel first{x_.brick_before(plane_x), y_.brick_before(plane_y), z_.brick_before(plane_z)};
                if (look_in_brick(tracking, static_cast<std::size_t>(place), {t, end}, bound, first)) return;
                rest = tracking.rest();
            } else {
                rest -= depth;
            }
            if (end >= leave) break;
            t = end;
            if (next_x <= exit) {
                plane_x += step_x;
                next_x = x_.meets(plane_x);
                place += places_x;
            } else if (next_y <= exit) {
                plane_y += step_y;
                next_y = y_.meets(plane_y);
                place += places_y;
            } else {
                plane_z += step_z;
                next_z = z_.meets(plane_z);
                place += places_z;
            }
        }
        tracking.set_rest(rest);
    }

    // On a stretch through the brick at `first`; true when the tracking ends there.
    template <class Tracking>
    bool look_in_brick(Tracking& tracking, std::size_t place, Interval span, double bound, Voxel first) const {
        const SparseGrid::Brick& brick = grid_->bricks_[grid_->directory_.brick(place)];
        const double depth = coefficient_ * bound * (span.end - span.begin);
        if (depth <= kMany)
            return tracking.look_inside(span.begin, span.end, bound, tap(first, &brick, Thinning::ByBlocks));
        if (depth * brick.excess < 255 * kThinnedOut)
            return tracking.look(span.begin, span.end, bound, [&] { return tap(first, &brick, Thinning::ByBlocks); });
        const auto in_brick = [&] { return tap(first, &brick, Thinning::None); };
        return through_blocks(brick, span, first, [&](double begin, double end, double bound_of_block) {
            return tracking.look(begin, end, bound_of_block, in_brick);
        });
    }

    // The blocks on a stretch through a brick, from the one that rays in this direction meet first.
    template <class Visit>
    bool through_blocks(const SparseGrid::Brick& brick, Interval span, Voxel first, const Visit& visit) const {
        double t = span.begin;
        const double end = span.end;
        double half_x = x_.meets(first.x + 0.5);
        double half_y = y_.meets(first.y + 0.5);
        double half_z = z_.meets(first.z + 0.5);
        unsigned block = 7U - static_cast<unsigned>(4 * x_.up + 2 * y_.up + z_.up);
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
