#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace fluovox {

/// Goes along a ray through a SparseGrid and gives its stretches with an upper bound of the trilinear field on each;
/// stretches where the field is zero are skipped, empty nodes in one step. Bounds are as fine as pays: where little
/// would happen even at the bound of a node, or of the whole grid, that is one stretch.
/// Amanatides & Woo, Eurographics 1987, on two levels.
class MajorantWalk {
public:
    struct Segment {
        double begin = 0, end = 0;  ///< micrometres along the ray
        double bound = 0;           ///< the field is at most this there
    };

    /// `coefficient`: what the field is multiplied with to give collisions per micrometre. Infinite: always the finest
    /// bounds.
    MajorantWalk(const SparseGrid& grid, const Ray& ray, Interval span,
                 double coefficient = std::numeric_limits<double>::infinity())
        : grid_(&grid),
          coefficient_(coefficient),
          origin_(grid.index_from_world().point(ray.origin)),
          direction_(grid.index_from_world().direction(ray.direction)),
          t_(span.begin),
          end_(span.end) {
        for (int axis = 0; axis < 3; ++axis)
            inverse_[axis] = 1 / direction_[axis];
        const Interval box = occupied_box();
        enter_ = std::max(t_, box.begin);
        leave_ = std::min(end_, box.end);
        if (!(enter_ < leave_)) enter_ = leave_ = end_;
        if (grid_->background() > 0) return;
        t_ = enter_;
        end_ = leave_;
    }

    /// The next stretch with a positive bound, in order along the ray; false at the end.
    bool next(Segment& segment) {
        while (t_ < end_) {
            if (t_ < enter_) {
                segment = {t_, enter_, grid_->background()};
                t_ = enter_;
                return true;
            }
            if (t_ >= leave_) {
                segment = {t_, end_, grid_->background()};
                t_ = end_;
                return grid_->background() > 0;
            }
            if (!outer_started_ && is_shallow(grid_->max(), leave_)) {
                segment = {t_, leave_, grid_->max()};
                t_ = leave_;
                return true;
            }
            if (!in_node_ && !start_node(segment)) continue;
            if (!in_node_) return true;
            if (next_cell(segment)) return true;
        }
        return false;
    }

    /// Index-space position at `t` along the ray, for SparseGrid::tap.
    Vec3 index_at(double t) const { return origin_ + t * direction_; }

private:
    // Cells of one size along the ray.
    struct Steps {
        std::array<int, 3> cell{}, step{};
        std::array<double, 3> next{}, delta{};

        double exit() const { return std::min({next[0], next[1], next[2]}); }
        void advance() {
            const std::size_t axis = next[0] < next[1] ? (next[0] < next[2] ? 0U : 2U) : (next[1] < next[2] ? 1U : 2U);
            cell[axis] += step[axis];
            next[axis] += delta[axis];
        }
    };

    // Expected collisions below which finer bounds cost more than they save.
    static constexpr double kFew = 0.5;

    bool is_shallow(double bound, double end) const { return coefficient_ * bound * (end - t_) < kFew; }

    // Cells of `size` voxels from the one that holds the ray at `t`. Rounding at a face may put that one step outside
    // `low`..`high`: it is put back before the distance to its exit is known, or every later cell would be the next
    // one.
    Steps steps_at(double t, int size, const std::array<int, 3>& low, const std::array<int, 3>& high) const {
        Steps steps;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const double d = direction_[axis];
            steps.cell[a] = std::clamp(static_cast<int>(std::floor((origin_[axis] + t * d) / size)), low[a], high[a]);
            steps.step[a] = d > 0 ? 1 : -1;
            if (d == 0) {
                steps.next[a] = steps.delta[a] = std::numeric_limits<double>::infinity();
                continue;
            }
            steps.delta[a] = size * std::abs(inverse_[axis]);
            steps.next[a] = ((steps.cell[a] + (d > 0 ? 1 : 0)) * size - origin_[axis]) * inverse_[axis];
        }
        return steps;
    }

    // Where the ray is inside the box of all cells with a positive bound.
    Interval occupied_box() const {
        Interval box{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
        const std::array<int, 3> low = {grid_->occupied_min_.x, grid_->occupied_min_.y, grid_->occupied_min_.z};
        const std::array<int, 3> high = {grid_->occupied_max_.x, grid_->occupied_max_.y, grid_->occupied_max_.z};
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            if (direction_[axis] == 0) {
                if (origin_[axis] < low[a] || origin_[axis] >= high[a]) return {0, 0};
                continue;
            }
            const double t0 = (low[a] - origin_[axis]) * inverse_[axis];
            const double t1 = (high[a] - origin_[axis]) * inverse_[axis];
            box = {std::max(box.begin, std::min(t0, t1)), std::min(box.end, std::max(t0, t1))};
        }
        return box;
    }

    // Steps into the node at t_. True when there is something to do in it: its cells (then in_node_), or one constant
    // stretch, put in `segment`. False when it was skipped.
    bool start_node(Segment& segment) {
        if (!outer_started_) {
            const Voxel low = grid_->node_min_;
            const Voxel n = grid_->node_count_;
            outer_ = steps_at(t_, SparseGrid::kNodeSize, {low.x, low.y, low.z},
                              {low.x + n.x - 1, low.y + n.y - 1, low.z + n.z - 1});
            outer_started_ = true;
        }
        const double node_end = std::min(outer_.exit(), leave_);
        // At the far face rounding may leave a last sliver outside.
        const int i = std::clamp(outer_.cell[0] - grid_->node_min_.x, 0, grid_->node_count_.x - 1);
        const int j = std::clamp(outer_.cell[1] - grid_->node_min_.y, 0, grid_->node_count_.y - 1);
        const int k = std::clamp(outer_.cell[2] - grid_->node_min_.z, 0, grid_->node_count_.z - 1);
        const std::size_t slot = grid_->node_slot(i, j, k);
        const double bound = static_cast<double>(grid_->node_bounds_[slot]);
        const std::int32_t node = grid_->nodes_[slot];
        if (node >= 0 && bound > 0 && t_ < node_end && !is_shallow(bound, node_end)) {
            in_node_ = true;
            node_end_ = node_end;
            cells_ = static_cast<std::size_t>(node) * SparseGrid::kCellsPerNode;
            constexpr int kLast = SparseGrid::kCells - 1;
            const std::array<int, 3> base = {(i + grid_->node_min_.x) * SparseGrid::kCells,
                                             (j + grid_->node_min_.y) * SparseGrid::kCells,
                                             (k + grid_->node_min_.z) * SparseGrid::kCells};
            inner_ = steps_at(t_, SparseGrid::kBrickSize, base, {base[0] + kLast, base[1] + kLast, base[2] + kLast});
            for (std::size_t a = 0; a < 3; ++a)
                inner_.cell[a] -= base[a];
            return true;
        }
        segment = {t_, std::max(t_, node_end), bound};
        t_ = segment.end;
        outer_.advance();
        return bound > 0 && segment.end > segment.begin;
    }

    // The next cell of the node with a positive bound; false when the node is left.
    bool next_cell(Segment& segment) {
        while (t_ < node_end_) {
            const double cell_end = std::min(inner_.exit(), node_end_);
            const std::size_t cell =
                cells_ + static_cast<std::size_t>((inner_.cell[0] << 8) | (inner_.cell[1] << 4) | inner_.cell[2]);
            const double bound = static_cast<double>(grid_->cell_bounds_[cell]);
            segment = {t_, cell_end, bound};
            t_ = std::max(t_, cell_end);
            inner_.advance();
            for (int& c : inner_.cell)
                c = std::clamp(c, 0, SparseGrid::kCells - 1);
            if (bound > 0 && segment.end > segment.begin) return true;
        }
        in_node_ = false;
        outer_.advance();
        return false;
    }

    const SparseGrid* grid_;
    double coefficient_;
    Vec3 origin_, direction_, inverse_;
    double t_, end_;
    double enter_ = 0, leave_ = 0, node_end_ = 0;
    bool outer_started_ = false, in_node_ = false;
    std::size_t cells_ = 0;
    Steps outer_, inner_;
};

}  // namespace fluovox
