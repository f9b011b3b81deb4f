#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/ray_axis.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace fluovox {

/// Leads a tracking (see grid_tracking.h) along a ray through a grid that has a directory of bricks. As MajorantWalk,
/// for the inner loops: stretches are bricks of 8^3 with the level of their bound. A ray goes from brick to brick
/// (Amanatides & Woo, Eurographics 1987) where many are there, else from column to column. Of the tentative collisions
/// with that bound, those are kept that a block of 4^3 has, by its share of the bound (thinning: Lewis & Shedler, Nav.
/// Res. Logist. Q. 26 (1979) 403), and that lie in a cell of 2^3 in which there is something; which leaves just those
/// with the bounds of the blocks there. Where there would be many in a brick, its cells are walked instead.
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
            tracking.look(begin_, leave_, grid_->max(), [&] { return tap({}, kNone, Thinning::None); });
            return;
        }
        if (grid_->directory_.is_dense() && !(direction_.x == 0 && direction_.y == 0)) {
            through_bricks(tracking);
        } else {
            through_columns(tracking);
        }
    }

private:
    // Tentative collisions worth the steps through the grid.
    static constexpr double kFew = 0.12;
    // Where a brick has more than these, and so many would be thinned out, walking its cells is quicker.
    static constexpr double kMany = 2;
    static constexpr double kThinnedOut = 1;
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    static constexpr int kLastInWord = BrickDirectory::kPlacesInWord - 1;

    enum class Thinning { None, ByCells };

    // Look-ups in the brick of a stretch need not start at the root.
    struct Tap {
        static constexpr int kSize = SparseGrid::kBrickSize;

        const SparseGrid* grid;
        const Vec3 *origin, *direction;
        Voxel first;        // brick of the stretch, or that at the corner of the box
        std::size_t brick;  // or kNone
        Thinning thinning;

        FixedPoint at(double t) const { return FixedPoint::from_brick(*origin + t * *direction, first); }

        // Uses the 8 highest bits; a value takes the lowest 54.
        double local_bound(const FixedPoint& place, double bound, std::uint64_t bits) const {
            if (thinning == Thinning::None) return bound;
            const SparseGrid::Outline& outline = grid->outlines_[brick];
            const unsigned cell = place.cell();
            if (!outline.has(cell)) return 0;
            const unsigned share = outline.bounds[SparseGrid::Outline::block_of(cell)];
            if ((bits >> 56U) > share) return 0;
            return bound * ((share + 1) * (1.0 / 256));
        }

        double value(const FixedPoint& place, std::uint64_t bits) const {
            const Voxel voxel = place.rounded(bits);
            if (is_in_brick(voxel)) return static_cast<double>(grid->value_in(grid->bricks_[brick], voxel));
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
            if (is_in_brick(from_first)) return grid->value_in(grid->bricks_[brick], from_first);
            return grid->value_in_box(voxel);
        }

        bool is_in_brick(Voxel from_first) const {
            return brick != kNone && static_cast<unsigned>(from_first.x | from_first.y | from_first.z) < kSize;
        }
        Voxel in_box(Voxel from_first) const {
            return {kSize * first.x + from_first.x, kSize * first.y + from_first.y, kSize * first.z + from_first.z};
        }
    };

    Tap tap(Voxel first, std::size_t brick, Thinning thinning) const {
        return {grid_, &origin_, &direction_, first, brick, thinning};
    }

    // A ray's way through a column, which it leaves through one of two planes.
    struct Crossing {
        std::ptrdiff_t column = 0;  // its lowest place
        double plane_x = 0, plane_y = 0;
        int from = 0, last = 0;
        Interval span;
    };
    // What a ray meets of a column, as far as one word of the directory tells.
    struct Met {
        std::uint64_t places = 0;
        std::size_t brick = 0;  // at the first of them
        Voxel first;            // place of the word
        Interval span;
    };

    // From column to column along z: empty places are passed by a look at their bits. What is met is only entered when
    // the next is found, so that the memory for it is read meanwhile.
    template <class Tracking>
    void through_columns(Tracking& tracking) const {
        const BrickDirectory& directory = grid_->directory_;
        const Voxel n = grid_->brick_count_;
        const Voxel begin{x_.first_brick(begin_, n.x), y_.first_brick(begin_, n.y), z_.first_brick(begin_, n.z)};
        const auto in_column = static_cast<std::ptrdiff_t>(directory.places_in_column());
        const std::ptrdiff_t places_x = x_.sign * in_column * n.y;
        const std::ptrdiff_t places_y = y_.sign * in_column;
        auto column = static_cast<std::ptrdiff_t>(directory.place({begin.x, begin.y, 0}));
        // The planes through which the column is left. What they are met at is worked out afresh each time: so the last
        // ones are met just where the box ends.
        double plane_x = begin.x + x_.up;
        double plane_y = begin.y + y_.up;
        const double step_x = x_.sign;
        const double step_y = y_.sign;
        double next_x = x_.meets(plane_x);
        double next_y = y_.meets(plane_y);
        const double leave = leave_;
        double t = begin_;
        int k = begin.z;
        double rest = tracking.rest();
        Met met;
        for (;;) {
            const double exit = std::min(next_x, next_y);
            const double end = std::min(exit, leave);
            const int last = z_.brick(end, n.z);
            if (cross_column(tracking, rest, met, {column, plane_x, plane_y, k, last, {t, end}})) return;
            if (exit >= leave) break;
            t = exit;
            k = last;
            // Numbers, not branches, which would mislead the processor.
            const bool is_x = next_x <= next_y;
            plane_x += is_x ? step_x : 0;
            plane_y += is_x ? 0 : step_y;
            next_x = x_.meets(plane_x);
            next_y = y_.meets(plane_y);
            column += is_x ? places_x : places_y;
        }
        if (enter_column(tracking, rest, met)) return;
        tracking.set_rest(rest);
    }

    // Meets what is there between two places of a column. True when the tracking ends.
    template <class Tracking>
    bool cross_column(Tracking& tracking, double& rest, Met& met, const Crossing& way) const {
        for (int k = way.from;;) {  // word by word: most often one
            const int to = z_.up != 0 ? std::min(way.last, k | kLastInWord) : std::max(way.last, k & ~kLastInWord);
            const BrickDirectory::Word& word = grid_->directory_.word(static_cast<std::size_t>(way.column + k));
            const std::uint64_t places = word.occupied & bits_between(k & kLastInWord, to & kLastInWord);
            if (places != 0) [[unlikely]] {
                if (enter_column(tracking, rest, met)) return true;
                met = {places,
                       word.brick(static_cast<unsigned>(first_of(places))),
                       {x_.brick_before(way.plane_x), y_.brick_before(way.plane_y), k & ~kLastInWord},
                       way.span};
                __builtin_prefetch(&grid_->outlines_[met.brick]);
                __builtin_prefetch(&grid_->bricks_[met.brick]);
            }
            if (to == way.last) return false;
            k = to + z_.sign;
        }
    }

    // Bits from one to another, either way.
    static std::uint64_t bits_between(int from, int to) {
        const auto others = static_cast<unsigned>(std::abs(to - from));
        return ((std::uint64_t{2} << others) - 1) << static_cast<unsigned>(std::min(from, to));
    }
    // Of some places in a column.
    int first_of(std::uint64_t places) const {
        return z_.up != 0 ? std::countr_zero(places) : kLastInWord - std::countl_zero(places);
    }

    // True when the tracking ends there.
    template <class Tracking>
    bool enter_column(Tracking& tracking, double& rest, const Met& met) const {
        std::size_t brick = met.brick;
        for (std::uint64_t places = met.places; places != 0; brick += static_cast<std::size_t>(z_.sign)) {
            const int place = first_of(places);
            places ^= std::uint64_t{1} << static_cast<unsigned>(place);
            const int k = met.first.z + place;
            const Interval span{std::max(met.span.begin, z_.meets(k + 1 - z_.up)),
                                std::min(met.span.end, z_.meets(k + z_.up))};
            if (!(span.begin < span.end)) continue;  // rounding may have an edge met in the wrong order
            const double bound = grid_->levels_[grid_->directory_.level(brick)];
            const double depth = coefficient_ * bound * (span.end - span.begin);
            if (depth > std::min(rest, kMany)) {
                tracking.set_rest(rest);
                if (look_in_brick(tracking, brick, span, bound, {met.first.x, met.first.y, k})) return true;
                rest = tracking.rest();
            } else {
                rest -= depth;
            }
        }
        return false;
    }

    template <class Tracking>
    void through_bricks(Tracking& tracking) const {
        const BrickDirectory& directory = grid_->directory_;
        const Voxel n = grid_->brick_count_;
        const Voxel begin{x_.brick(begin_, n.x), y_.brick(begin_, n.y), z_.brick(begin_, n.z)};
        const std::ptrdiff_t in_column = n.z;
        const std::ptrdiff_t places_x = x_.sign * in_column * n.y;
        const std::ptrdiff_t places_y = y_.sign * in_column;
        const std::ptrdiff_t places_z = z_.sign;
        auto place = static_cast<std::ptrdiff_t>(directory.entry_place(begin));
        // The planes through which the brick is left, as in through_columns.
        double plane_x = begin.x + x_.up;
        double plane_y = begin.y + y_.up;
        double plane_z = begin.z + z_.up;
        const double step_x = x_.sign;
        const double step_y = y_.sign;
        const double step_z = z_.sign;
        // A ray in the plane between two bricks may have met it before.
        double next_x = std::max(begin_, x_.meets(plane_x));
        double next_y = std::max(begin_, y_.meets(plane_y));
        double next_z = std::max(begin_, z_.meets(plane_z));
        const BrickDirectory::Entry* const entries = directory.entries();
        const BoundLevels& bounds = grid_->levels_;
        const double coefficient = coefficient_;
        const double leave = leave_;
        double t = begin_;
        double rest = tracking.rest();
        for (;;) {
            const double exit = std::min(next_x, std::min(next_y, next_z));
            const double end = std::min(exit, leave);
            const BrickDirectory::Entry entry = entries[place];
            const double bound = bounds[entry.level];
            const double depth = coefficient * bound * (end - t);
            if (depth > std::min(rest, kMany)) [[unlikely]] {
                const Voxel first{x_.brick_before(plane_x), y_.brick_before(plane_y), z_.brick_before(plane_z)};
                tracking.set_rest(rest);
                if (look_in_brick(tracking, entry.brick, {t, end}, bound, first)) return;
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
    bool look_in_brick(Tracking& tracking, std::size_t brick, Interval span, double bound, Voxel first) const {
        const double depth = coefficient_ * bound * (span.end - span.begin);
        if (depth <= kMany)
            return tracking.look_inside(span.begin, span.end, bound, tap(first, brick, Thinning::ByCells));
        if (depth * grid_->bricks_[brick].excess < 255 * kThinnedOut)
            return tracking.look(span.begin, span.end, bound, [&] { return tap(first, brick, Thinning::ByCells); });
        const auto look = [&](double begin, double end, double bound_there) {
            return tracking.look(begin, end, bound_there, [&] { return tap(first, brick, Thinning::None); });
        };
        const SparseGrid::Outline& outline = grid_->outlines_[brick];
        if (outline.is_full())
            return through_parts<2>(
                span, first, [&](unsigned block) { return outline.bound(block, bound); }, look);
        return through_parts<4>(
            span, first, [&](unsigned cell) { return outline.bound_in_cell(cell, bound); }, look);
    }

    // The parts on a stretch through a brick where their bound is above 0: `kAlong` along each axis, z fastest.
    template <int kAlong, class Bound, class Visit>
    bool through_parts(Interval span, Voxel first, const Bound& bound_of, const Visit& visit) const {
        constexpr double kSide = 1.0 / kAlong;
        const auto part_at = [&](const RayAxis& axis, int corner) {
            const double in_brick = axis.origin + span.begin * axis.direction - corner;
            return std::clamp(static_cast<int>(in_brick * kAlong), 0, kAlong - 1);
        };
        const int i = part_at(x_, first.x);
        const int j = part_at(y_, first.y);
        const int k = part_at(z_, first.z);
        int part = (i * kAlong + j) * kAlong + k;
        // The planes through which the part is left, as in through_bricks.
        double plane_x = first.x + kSide * (i + x_.up);
        double plane_y = first.y + kSide * (j + y_.up);
        double plane_z = first.z + kSide * (k + z_.up);
        double next_x = std::max(span.begin, x_.meets(plane_x));
        double next_y = std::max(span.begin, y_.meets(plane_y));
        double next_z = std::max(span.begin, z_.meets(plane_z));
        for (double t = span.begin;;) {
            const double exit = std::min(next_x, std::min(next_y, next_z));
            const double end = std::min(exit, span.end);
            const double bound = bound_of(static_cast<unsigned>(part) % (kAlong * kAlong * kAlong));
            if (bound > 0 && t < end && visit(t, end, bound)) return true;
            if (exit >= span.end) return false;
            t = exit;
            if (next_x <= exit) {
                plane_x += kSide * x_.sign;
                next_x = x_.meets(plane_x);
                part += kAlong * kAlong * x_.sign;
            } else if (next_y <= exit) {
                plane_y += kSide * y_.sign;
                next_y = y_.meets(plane_y);
                part += kAlong * y_.sign;
            } else {
                plane_z += kSide * z_.sign;
                next_z = z_.meets(plane_z);
                part += z_.sign;
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
