#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/sparse_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

namespace fluovox {

/// Goes along a ray through a SparseGrid and gives its stretches with an upper bound of the trilinear field on each;
/// stretches where the field is zero are skipped, empty nodes in one step. Bounds are as fine as pays: where little
/// would happen even at the bound of a brick, a node, or the whole grid, that is one stretch.
/// Amanatides & Woo, Eurographics 1987, on two levels; below, the planes that halve a brick.
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
          inverse_{1 / direction_.x, 1 / direction_.y, 1 / direction_.z},
          t_(span.begin),
          end_(span.end) {
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
            switch (level_) {
                case Level::Grid:
                    if (next_outside(segment)) return true;
                    break;
                case Level::Nodes:
                    if (next_node(segment)) return true;
                    break;
                case Level::Bricks:
                    if (next_brick(segment)) return true;
                    break;
                case Level::Blocks:
                    if (next_block(segment)) return true;
                    break;
            }
        }
        return false;
    }

    /// Index-space position at `t` along the ray.
    Vec3 index_at(double t) const { return origin_ + t * direction_; }

    /// SparseGrid::tap at `t`, a place of the last segment.
    double tap(double t, std::uint64_t bits) const {
        const Voxel voxel = FixedPoint(index_at(t)).rounded(bits);
        if (brick_ != nullptr && (voxel.x & ~7) == brick_place_.x && (voxel.y & ~7) == brick_place_.y &&
            (voxel.z & ~7) == brick_place_.z) {
            return static_cast<double>(grid_->value_in(*brick_, voxel));
        }
        return static_cast<double>(grid_->value(voxel));
    }

private:
    enum class Level { Grid, Nodes, Bricks, Blocks };

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
    static constexpr double kFewInBrick = 0.2;

    bool is_shallow(double bound, double end, double few) const { return coefficient_ * bound * (end - t_) < few; }

    // Cells of `size` voxels from the one that holds the ray at `t`. Rounding at a face may put that one step outside
    // `low`..`high`: it is put back before the distance to its exit is known, or every later cell would be the next
    // one.
    void start(Steps& steps, double t, int size, const std::array<int, 3>& low, const std::array<int, 3>& high) const {
        const double inverse_size = 1.0 / size;
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const double d = direction_[axis];
            const double place = (origin_[axis] + t * d) * inverse_size;
            steps.cell[a] = std::clamp(floor_to_int(place), low[a], high[a]);
            steps.step[a] = d > 0 ? 1 : -1;
            if (d == 0) {
                steps.next[a] = steps.delta[a] = std::numeric_limits<double>::infinity();
                continue;
            }
            steps.delta[a] = size * std::abs(inverse_[axis]);
            steps.next[a] = ((steps.cell[a] + (d > 0 ? 1 : 0)) * size - origin_[axis]) * inverse_[axis];
        }
    }

    // Where the ray is inside the box of all bricks with a positive bound.
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

    // Before and behind the box of what is occupied, and all of it where little happens there.
    bool next_outside(Segment& segment) {
        brick_ = nullptr;
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
        if (is_shallow(grid_->max(), leave_, kFew)) {
            segment = {t_, leave_, grid_->max()};
            t_ = leave_;
            return true;
        }
        const Voxel low = grid_->node_min_;
        const Voxel n = grid_->node_count_;
        start(nodes_, t_, SparseGrid::kNodeSize, {low.x, low.y, low.z},
              {low.x + n.x - 1, low.y + n.y - 1, low.z + n.z - 1});
        level_ = Level::Nodes;
        return false;
    }

    // Steps over empty nodes to one with something to do in it: its bricks (false then), or one constant stretch.
    bool next_node(Segment& segment) {
        const double background = grid_->background();
        while (t_ < leave_) {
            const double end = std::min(nodes_.exit(), leave_);
            const std::int32_t index = grid_->node_at(nodes_.cell[0], nodes_.cell[1], nodes_.cell[2]);
            if (index < 0) {
                segment = {t_, end, background};
                t_ = std::max(t_, end);
                nodes_.advance();
                if (background > 0 && segment.end > segment.begin) return brick_ = nullptr, true;
                continue;
            }
            const SparseGrid::Node& node = grid_->nodes_[static_cast<std::size_t>(index)];
            const double bound = std::max(static_cast<double>(node.bound), background);
            if (t_ < end && !is_shallow(bound, end, kFew)) {
                node_ = &node;
                node_end_ = end;
                const std::array<int, 3> low = {4 * nodes_.cell[0], 4 * nodes_.cell[1], 4 * nodes_.cell[2]};
                start(bricks_, t_, SparseGrid::kBrickSize, low, {low[0] + 3, low[1] + 3, low[2] + 3});
                level_ = Level::Bricks;
                return false;
            }
            segment = {t_, std::max(t_, end), bound};
            t_ = segment.end;
            nodes_.advance();
            if (bound > 0 && segment.end > segment.begin) return brick_ = nullptr, true;
        }
        level_ = Level::Grid;
        return false;
    }

    // The next brick of the node with a positive bound: as one stretch, or by its blocks (false then).
    bool next_brick(Segment& segment) {
        const double background = grid_->background();
        while (t_ < node_end_) {
            const double end = std::min(bricks_.exit(), node_end_);
            const std::array<int, 3> cell = bricks_.cell;
            const SparseGrid::Brick* brick = grid_->brick_of(*node_, cell[0] & 3, cell[1] & 3, cell[2] & 3);
            const double bound = brick == nullptr ? background : static_cast<double>(brick->bound);
            const double begin = t_;
            const bool whole = bound == 0 || brick == nullptr || is_shallow(bound, end, kFewInBrick);
            bricks_.advance();
            for (std::size_t a = 0; a < 3; ++a)  // rounding at the node's far face may leave a last sliver outside
                bricks_.cell[a] = std::clamp(bricks_.cell[a], 4 * nodes_.cell[a], 4 * nodes_.cell[a] + 3);
            if (bound > 0 && end > begin) {
                brick_ = brick;
                brick_place_ = {8 * cell[0], 8 * cell[1], 8 * cell[2]};
                if (!whole) {
                    start_blocks(end);
                    return false;
                }
                segment = {begin, end, bound};
                t_ = end;
                return true;
            }
            t_ = std::max(t_, end);
        }
        level_ = Level::Nodes;
        nodes_.advance();
        return false;
    }

    void start_blocks(double end) {
        level_ = Level::Blocks;
        brick_end_ = end;
        const std::array<int, 3> place = {brick_place_.x, brick_place_.y, brick_place_.z};
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const double distance = place[a] + SparseGrid::kBlockSize - origin_[axis];
            if (direction_[axis] == 0) {  // always on one side
                halving_[a] = -std::numeric_limits<double>::infinity();
                upper_[a] = distance > 0 ? 0 : 1;
            } else {
                halving_[a] = distance * inverse_[axis];
                upper_[a] = direction_[axis] > 0 ? 1 : 0;
            }
        }
    }

    bool next_block(Segment& segment) {
        while (t_ < brick_end_) {
            // On which side of each plane, and which one comes next.
            double end = brick_end_;
            unsigned block = 0;
            for (std::size_t a = 0; a < 3; ++a) {
                const bool behind = t_ >= halving_[a];
                block = 2 * block + static_cast<unsigned>(behind ? upper_[a] : 1 - upper_[a]);
                if (!behind) end = std::min(end, halving_[a]);
            }
            segment = {t_, end, grid_->outline_of(*brick_).bound(block, static_cast<double>(brick_->bound))};
            t_ = end;
            if (segment.bound > 0) return true;
        }
        level_ = Level::Bricks;
        return false;
    }

    const SparseGrid* grid_;
    double coefficient_;
    Vec3 origin_, direction_, inverse_;
    double t_, end_;
    double enter_ = 0, leave_ = 0, node_end_ = 0, brick_end_ = 0;
    Level level_ = Level::Grid;
    const SparseGrid::Node* node_ = nullptr;
    const SparseGrid::Brick* brick_ = nullptr;  // that holds the last segment, where it is in one
    Voxel brick_place_;
    Steps nodes_, bricks_;
    std::array<double, 3> halving_{};  // where the ray meets the planes that halve the brick
    std::array<int, 3> upper_{};       // half of the brick behind that
};

}  // namespace fluovox
