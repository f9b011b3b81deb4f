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

/// As MajorantWalk, for the inner loops of tracking, in grids that have a directory of bricks: calls
/// `visit(begin, end, bound, tap)` for each stretch with a positive bound, in order, until it returns true; `tap()`
/// gives is SparseGrid::tap on that stretch. Bricks are halved along each axis where that saves more tentative
/// collisions than it costs steps. Amanatides & Woo, Eurographics 1987.
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

    template <class Visit>
    void run(Visit visit) const {
        if (!(begin_ < leave_)) return;
        if (coefficient_ * grid_->max() * (leave_ - begin_) < kFew) {
            visit(begin_, leave_, grid_->max(), [&] { return Tap{grid_, &origin_, &direction_, nullptr, {}}; });
            return;
        }
        through_bricks(visit);
    }

private:
    // Tentative collisions worth the steps through a brick, or through all of the grid.
    static constexpr double kFew = 0.12;
    static constexpr double kSize = SparseGrid::kBrickSize;

    // Look-ups in the brick of a stretch need not start at the root.
    struct Tap {
        const SparseGrid* grid;
        const Vec3 *origin, *direction;
        const SparseGrid::Brick* brick;
        Voxel first;

        double operator()(double t, std::uint64_t bits) const {
            const Voxel voxel = SparseGrid::tapped_voxel(*origin + t * *direction, bits);
            const auto beyond = static_cast<unsigned>((voxel.x - first.x) | (voxel.y - first.y) | (voxel.z - first.z));
            if (brick != nullptr && beyond < SparseGrid::kBrickSize)
                return static_cast<double>(grid->value_in(*brick, voxel));
            return static_cast<double>(grid->value(voxel));
        }
    };

    // First voxel of the brick that is left through this plane.
    static int first_voxel(const RayAxis& axis, double exit_plane) {
        return static_cast<int>(exit_plane) - (axis.step > 0 ? SparseGrid::kBrickSize : 0);
    }

    template <class Visit>
    void through_bricks(Visit& visit) const {
        const Voxel low{grid_->occupied_min_.x / 8, grid_->occupied_min_.y / 8, grid_->occupied_min_.z / 8};
        const Voxel n = grid_->brick_count_;
        const RayAxis x = x_;
        const RayAxis y = y_;
        const RayAxis z = z_;
        double t = begin_;
        const double leave = leave_;
        const int i = std::clamp(x.brick(t), low.x, low.x + n.x - 1);
        const int j = std::clamp(y.brick(t), low.y, low.y + n.y - 1);
        const int k = std::clamp(z.brick(t), low.z, low.z + n.z - 1);
        std::ptrdiff_t slot = (static_cast<std::ptrdiff_t>(i - low.x) * n.y + (j - low.y)) * n.z + (k - low.z);
        const std::ptrdiff_t slots_x = static_cast<std::ptrdiff_t>(x.step) * n.y * n.z;
        const std::ptrdiff_t slots_y = static_cast<std::ptrdiff_t>(y.step) * n.z;
        // The planes through which the brick is left. What they are met at is worked out afresh each time: so the last
        // ones are met just where the box ends.
        double plane_x = kSize * (i + (x.step > 0 ? 1 : 0));
        double plane_y = kSize * (j + (y.step > 0 ? 1 : 0));
        double plane_z = kSize * (k + (z.step > 0 ? 1 : 0));
        const double step_x = kSize * x.step;
        const double step_y = kSize * y.step;
        const double step_z = kSize * z.step;
        const unsigned nearest = (x.step < 0 ? 4U : 0U) | (y.step < 0 ? 2U : 0U) | (z.step < 0 ? 1U : 0U);
        const double width_x = 0.5 * kSize * std::abs(x.inverse);
        const double width_y = 0.5 * kSize * std::abs(y.inverse);
        const double width_z = 0.5 * kSize * std::abs(z.inverse);
        double next_x = x.meets(plane_x);
        double next_y = y.meets(plane_y);
        double next_z = z.meets(plane_z);
        for (;;) {
            const double exit = std::min(next_x, std::min(next_y, next_z));
            const double end = std::min(exit, leave);
            if (grid_->directory_.has(static_cast<std::size_t>(slot)) && t < end) {
                const SparseGrid::Brick& brick =
                    grid_->bricks_[grid_->directory_.brick(static_cast<std::size_t>(slot))];
                const auto tap = [&] {
                    return Tap{grid_, &origin_, &direction_, &brick,
                               Voxel{first_voxel(x, plane_x), first_voxel(y, plane_y), first_voxel(z, plane_z)}};
                };
                if (coefficient_ * static_cast<double>(brick.excess) * (end - t) < kFew) {
                    if (visit(t, end, static_cast<double>(brick.bound), tap)) return;
                } else {
                    const std::array<double, 3> halves = {next_x - width_x, next_y - width_y, next_z - width_z};
                    if (through_blocks(brick, {t, end}, halves, nearest, tap, visit)) return;
                }
            }
            if (end >= leave) return;
            t = std::max(t, end);
            if (next_x <= exit) {
                plane_x += step_x;
                next_x = x.meets(plane_x);
                slot += slots_x;
            } else if (next_y <= exit) {
                plane_y += step_y;
                next_y = y.meets(plane_y);
                slot += slots_y;
            } else {
                plane_z += step_z;
                next_z = z.meets(plane_z);
                slot += z.step;
            }
        }
    }

    // The blocks on a stretch through a brick, from the one that rays in this direction meet first; `halves`: where the
    // planes between them are met.
    template <class MakeTap, class Visit>
    static bool through_blocks(const SparseGrid::Brick& brick, Interval span, std::array<double, 3> halves,
                               unsigned block, const MakeTap& tap, Visit& visit) {
        double t = span.begin;
        const double end = span.end;
        auto [half_x, half_y, half_z] = halves;
        if (t >= half_x) block ^= 4U, half_x = end;
        if (t >= half_y) block ^= 2U, half_y = end;
        if (t >= half_z) block ^= 1U, half_z = end;
        for (;;) {
            const double part = std::min(end, std::min(half_x, std::min(half_y, half_z)));
            const double bound = SparseGrid::bound_of(brick, block);
            if (bound > 0 && visit(t, part, bound, tap)) return true;
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
