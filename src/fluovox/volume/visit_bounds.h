#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/majorant_walk.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace fluovox {

/// Where a stretch of a walk lies in the grid: look-ups there need not start at the root.
class BoundPlace {
public:
    BoundPlace(const SparseGrid& grid, const Vec3& origin, const Vec3& direction, const SparseGrid::Brick* brick,
               Voxel first)
        : grid_(&grid), origin_(&origin), direction_(&direction), brick_(brick), first_(first) {}

    /// SparseGrid::tap at `t` on that stretch.
    double operator()(double t, Vec3 u) const {
        const Voxel voxel = SparseGrid::tapped_voxel(*origin_ + t * *direction_, u);
        const auto beyond = static_cast<unsigned>((voxel.x - first_.x) | (voxel.y - first_.y) | (voxel.z - first_.z));
        if (brick_ != nullptr && beyond < SparseGrid::kBrickSize)
            return static_cast<double>(grid_->value_in(*brick_, voxel));
        return static_cast<double>(grid_->value(voxel));
    }

private:
    const SparseGrid* grid_;
    const Vec3 *origin_, *direction_;
    const SparseGrid::Brick* brick_;
    Voxel first_;
};

/// One axis of a ray in index space: where it meets the planes of the grid. The same plane gives the same place on
/// every level, to the last bit, so that cells of one level end where those of another do.
struct RayAxis {
    double origin = 0, direction = 0;
    double inverse = 0, offset = 0;
    int step = 1;

    RayAxis(double o, double d) : origin(o), direction(d), step(d > 0 ? 1 : -1) {
        inverse = d == 0 ? 0 : 1 / d;
        offset = d == 0 ? std::numeric_limits<double>::infinity() : -o * inverse;
    }
    double meets(int plane) const { return plane * inverse + offset; }
    /// Cell of `size` voxels that holds the ray at t.
    int cell(double t, double inverse_size) const { return floor_to_int((origin + t * direction) * inverse_size); }
    /// First voxel behind the cell of `size` voxels.
    int exit_plane(int cell, int size) const { return (cell + (step > 0 ? 1 : 0)) * size; }
    /// The same stretch between two planes, in order; without direction all or nothing.
    Interval between(int low, int high) const {
        if (direction == 0) {
            return origin >= low && origin < high
                       ? Interval{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}
                       : Interval{0, 0};
        }
        const double a = meets(low);
        const double b = meets(high);
        return {std::min(a, b), std::max(a, b)};
    }
};

/// As MajorantWalk, for the inner loops of tracking: calls `visit(begin, end, bound, tap)` for each stretch with a
/// positive bound, in order, until it returns true; `tap(t, u)` looks up a place on it. For a background of zero. Finer
/// bounds are taken where they save more tentative collisions than they cost steps.
template <class Visit>
void visit_bounds(const SparseGrid& grid, const Ray& ray, Interval span, double coefficient, Visit visit) {
    constexpr double kFew = 0.25;         // tentative collisions that are worth the steps through a node
    constexpr double kFewInBrick = 0.12;  // or through a brick
    const Vec3 origin = grid.index_from_world().point(ray.origin);
    const Vec3 direction = grid.index_from_world().direction(ray.direction);
    const RayAxis x(origin.x, direction.x);
    const RayAxis y(origin.y, direction.y);
    const RayAxis z(origin.z, direction.z);
    const Interval in_x = x.between(grid.occupied_min_.x, grid.occupied_max_.x);
    const Interval in_y = y.between(grid.occupied_min_.y, grid.occupied_max_.y);
    const Interval in_z = z.between(grid.occupied_min_.z, grid.occupied_max_.z);
    double t = std::max(std::max(span.begin, in_x.begin), std::max(in_y.begin, in_z.begin));
    const double leave = std::min(std::min(span.end, in_x.end), std::min(in_y.end, in_z.end));
    if (!(t < leave)) return;
    const BoundPlace anywhere(grid, origin, direction, nullptr, {});
    if (coefficient * grid.max() * (leave - t) < kFew) {
        visit(t, leave, grid.max(), anywhere);
        return;
    }

    int i = x.cell(t, 1.0 / SparseGrid::kNodeSize);
    int j = y.cell(t, 1.0 / SparseGrid::kNodeSize);
    int k = z.cell(t, 1.0 / SparseGrid::kNodeSize);
    double next_x = x.meets(x.exit_plane(i, SparseGrid::kNodeSize));
    double next_y = y.meets(y.exit_plane(j, SparseGrid::kNodeSize));
    double next_z = z.meets(z.exit_plane(k, SparseGrid::kNodeSize));
    for (;;) {
        const double exit = std::min(next_x, std::min(next_y, next_z));
        const double node_end = std::min(exit, leave);
        const std::int32_t index = t < node_end ? grid.node_at(i, j, k) : -1;
        if (index >= 0) {
            const SparseGrid::Node& node = grid.nodes_[static_cast<std::size_t>(index)];
            if (coefficient * static_cast<double>(node.excess) * (node_end - t) < kFew) {
                if (node.bound > 0 && visit(t, node_end, static_cast<double>(node.bound), anywhere)) return;
            } else {
                int bi = std::clamp(x.cell(t, 1.0 / SparseGrid::kBrickSize), 4 * i, 4 * i + 3);
                int bj = std::clamp(y.cell(t, 1.0 / SparseGrid::kBrickSize), 4 * j, 4 * j + 3);
                int bk = std::clamp(z.cell(t, 1.0 / SparseGrid::kBrickSize), 4 * k, 4 * k + 3);
                double brick_x = x.meets(x.exit_plane(bi, SparseGrid::kBrickSize));
                double brick_y = y.meets(y.exit_plane(bj, SparseGrid::kBrickSize));
                double brick_z = z.meets(z.exit_plane(bk, SparseGrid::kBrickSize));
                for (;;) {
                    const double brick_exit = std::min(brick_x, std::min(brick_y, brick_z));
                    const double end = std::min(brick_exit, node_end);
                    const auto bit = static_cast<unsigned>(((bi & 3) << 4) | ((bj & 3) << 2) | (bk & 3));
                    if (((node.mask >> bit) & 1U) != 0 && t < end) {
                        const std::uint64_t before = node.mask & ((std::uint64_t{1} << bit) - 1);
                        const SparseGrid::Brick& brick =
                            grid.bricks_[node.first + static_cast<unsigned>(SparseGrid::count_bits(before))];
                        const Voxel first{8 * bi, 8 * bj, 8 * bk};
                        const BoundPlace place(grid, origin, direction, &brick, first);
                        double half_x = end;
                        double half_y = end;
                        double half_z = end;
                        unsigned block = 8;  // the whole brick
                        if (coefficient * static_cast<double>(brick.excess) * (end - t) >= kFewInBrick) {
                            block = 0;
                            const auto halve = [&](const RayAxis& axis, int plane, unsigned upper, double& half) {
                                const double at = axis.meets(plane);
                                const bool behind = axis.direction == 0 ? axis.origin >= plane : t >= at;
                                if (!behind) half = std::min(at, end);
                                block |= behind == (axis.step > 0 || axis.direction == 0) ? upper : 0U;
                            };
                            halve(x, first.x + 4, 4, half_x);
                            halve(y, first.y + 4, 2, half_y);
                            halve(z, first.z + 4, 1, half_z);
                        }
                        while (t < end) {
                            const double part = std::min(half_x, std::min(half_y, half_z));
                            const double bound =
                                block == 8 ? static_cast<double>(brick.bound) : SparseGrid::bound_of(brick, block);
                            if (bound > 0 && visit(t, part, bound, place)) return;
                            t = part;
                            if (half_x == part && part < end) block ^= 4U, half_x = end;
                            if (half_y == part && part < end) block ^= 2U, half_y = end;
                            if (half_z == part && part < end) block ^= 1U, half_z = end;
                        }
                    }
                    t = std::max(t, end);
                    if (end >= node_end) break;
                    if (brick_x <= brick_exit) {
                        bi += x.step;
                        brick_x = x.meets(x.exit_plane(bi, SparseGrid::kBrickSize));
                    } else if (brick_y <= brick_exit) {
                        bj += y.step;
                        brick_y = y.meets(y.exit_plane(bj, SparseGrid::kBrickSize));
                    } else {
                        bk += z.step;
                        brick_z = z.meets(z.exit_plane(bk, SparseGrid::kBrickSize));
                    }
                }
            }
        }
        t = std::max(t, node_end);
        if (node_end >= leave) return;
        if (next_x <= exit) {
            i += x.step;
            next_x = x.meets(x.exit_plane(i, SparseGrid::kNodeSize));
        } else if (next_y <= exit) {
            j += y.step;
            next_y = y.meets(y.exit_plane(j, SparseGrid::kNodeSize));
        } else {
            k += z.step;
            next_z = z.meets(z.exit_plane(k, SparseGrid::kNodeSize));
        }
    }
}

}  // namespace fluovox
