#include "fluovox/volume/shadow_grid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace fluovox {
namespace {

constexpr std::size_t kLinesAround = 4;
constexpr int kMiddle = 42;  // the voxel (2, 2, 2) of a block

int along(Voxel v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

Voxel in_block(int place) {
    return {place >> 4, (place >> 2) & 3, place & 3};
}

// The voxels of a block that lie in one of its four slices across an axis.
std::uint64_t slice_of_block(int axis, int slice) {
    std::uint64_t mask = 0;
    for (int i = 0; i < 64; ++i) {
        if (along(in_block(i), axis) == slice) mask |= std::uint64_t{1} << static_cast<unsigned>(i);
    }
    return mask;
}

int longest_axis(Vec3 v) {
    const Vec3 size{std::abs(v.x), std::abs(v.y), std::abs(v.z)};
    if (size.x >= size.y && size.x >= size.z) return 0;
    return size.y >= size.z ? 1 : 2;
}

// exp(-depth) in steps of 1/255, by steps of the depth that are as fine.
class ShareTable {
public:
    ShareTable() {
        for (std::size_t i = 0; i < shares_.size(); ++i) {
            const double depth = (static_cast<double>(i) + 0.5) / static_cast<double>(kSteps);
            shares_[i] = static_cast<std::uint8_t>(std::lround(255 * std::exp(-depth)));
        }
    }
    std::uint8_t operator()(float depth) const {
        return depth < kMost ? shares_[static_cast<std::size_t>(depth * kSteps)] : 0;
    }

private:
    static constexpr float kSteps = 256;
    static constexpr float kMost = 7;
    std::array<std::uint8_t, static_cast<std::size_t>(kSteps* kMost)> shares_{};
};

}  // namespace

// Goes with the light through the slices of voxels across the axis along which it runs most.
class ShadowGrid::Sweep {
public:
    /// `travel`: the way of the light, in voxels per um.
    Sweep(ShadowGrid& shadows, Vec3 travel, double coefficient)
        : shadows_(&shadows),
          grid_(shadows.grid_),
          axis_(longest_axis(travel)),
          u_(axis_ == 0 ? 1 : 0),
          v_(axis_ == 2 ? 1 : 2),
          forward_(travel[axis_] > 0),
          slope_u_(travel[u_] / travel[axis_]),
          slope_v_(travel[v_] / travel[axis_]),
          step_depth_(static_cast<float>(coefficient / std::abs(travel[axis_]))),
          lines_u_(place_lines(u_, slope_u_)),
          lines_v_(place_lines(v_, slope_v_)) {
        depths_.assign(lines_u_.count * lines_v_.count, 0.0F);
        for (int s = 0; s < SparseGrid::kBlockSize; ++s)
            slices_[static_cast<std::size_t>(s)] = slice_of_block(axis_, s);
    }

    void run() {
        find_bricks();
        const int slices = SparseGrid::kBrickSize * along(grid_->brick_count_, axis_);
        for (int n = 0; n < slices; ++n)
            take_slice(forward_ ? n : slices - 1 - n);
    }

private:
    static constexpr std::size_t kMostSpots = 1024;

    struct Placed {
        std::uint32_t brick = 0;
        int u = 0, v = 0;  // of its corner, in voxels of the box
    };
    struct Shade {
        std::size_t line = 0;  // the first of the four around a voxel
        float depth = 0;       // that it adds
    };

    struct Lines {
        double first = 0;  // where it meets the first slice
        std::size_t count = 0;
    };

    // Those that meet the box, and some around them.
    Lines place_lines(int axis, double slope) const {
        constexpr int kSize = SparseGrid::kBrickSize;
        const double shift = slope * kSize * along(grid_->brick_count_, axis_);
        const double across = kSize * along(grid_->brick_count_, axis);
        return {std::min(0.0, -shift) - 1, static_cast<std::size_t>(across + std::abs(shift)) + kLinesAround};
    }

    void find_bricks() {
        const Voxel n = grid_->brick_count_;
        const BrickDirectory& directory = grid_->directory_;
        by_layer_.resize(static_cast<std::size_t>(along(n, axis_)));
        for (int i = 0; i < n.x; ++i) {
            for (int j = 0; j < n.y; ++j) {
                const std::size_t column = grid_->brick_place(i, j, 0);
                const std::size_t end = column + static_cast<std::size_t>(n.z);
                for (std::size_t place = directory.next_filled(column, end); place < end;
                     place = directory.next_filled(place + 1, end)) {
                    const Voxel at{i, j, static_cast<int>(place - column)};
                    by_layer_[static_cast<std::size_t>(along(at, axis_))].push_back(
                        {directory.brick(place), SparseGrid::kBrickSize * along(at, u_),
                         SparseGrid::kBrickSize * along(at, v_)});
                }
            }
        }
    }

    // First all voxels read what lies before them, then all add what they are.
    void take_slice(int slice) {
        const double u = -slope_u_ * slice - lines_u_.first;
        const double v = -slope_v_ * slice - lines_v_.first;
        line_u_ = static_cast<int>(u);
        line_v_ = static_cast<int>(v);
        const auto fu = static_cast<float>(u - line_u_);
        const auto fv = static_cast<float>(v - line_v_);
        weights_ = {(1 - fu) * (1 - fv), (1 - fu) * fv, fu * (1 - fv), fu * fv};
        shades_.clear();
        for (const Placed& placed : by_layer_[static_cast<std::size_t>(slice / SparseGrid::kBrickSize)]) {
            for (unsigned block = 0; block < 8; ++block) {
                const Voxel corner{static_cast<int>(block & 4U), static_cast<int>((block & 2U) << 1U),
                                   static_cast<int>((block & 1U) << 2U)};
                if (along(corner, axis_) != (slice & 4)) continue;
                shade_block(placed, block, corner, slice & 3);
            }
        }
        keep_spots(slice);
        for (const Shade& shade : shades_) {
            float* line = &depths_[shade.line];
            line[0] += weights_[0] * shade.depth;
            line[1] += weights_[1] * shade.depth;
            line[lines_v_.count] += weights_[2] * shade.depth;
            line[lines_v_.count + 1] += weights_[3] * shade.depth;
        }
    }

    void shade_block(const Placed& placed, unsigned block, Voxel corner, int slice) {
        const SparseGrid::Brick& brick = grid_->bricks_[placed.brick];
        const std::uint16_t child = brick.child[block];
        const int u = placed.u + along(corner, u_) + line_u_;
        const int v = placed.v + along(corner, v_) + line_v_;
        const std::uint64_t sliced = slices_[static_cast<std::size_t>(slice)];
        if (child >= SparseGrid::kConstants) {
            const float value = grid_->constants_[child - SparseGrid::kConstants];
            if (value <= 0) return;
            for (std::uint64_t left = sliced; left != 0; left &= left - 1) {
                const int place = std::countr_zero(left);
                const float depth = depth_at(place, u, v, value);
                if (place == kMiddle) shadows_->of_blocks_[8 * std::size_t{placed.brick} + block] = share_(depth);
            }
            return;
        }
        const std::size_t first = std::size_t{brick.base} + child;
        std::uint64_t mask = 0;
        std::memcpy(&mask, &grid_->codes_[first], sizeof(mask));
        for (std::uint64_t left = mask & sliced; left != 0; left &= left - 1) {
            const std::uint64_t below = (left & (0 - left)) - 1;
            const std::size_t code = first + 4 + static_cast<std::size_t>(SparseGrid::count_bits(mask & below));
            shadows_->shares_[code] =
                share_(depth_at(std::countr_zero(left), u, v, brick.decoded(grid_->codes_[code])));
        }
    }

    // Every so many voxels one is kept; when those are too many, every second of them.
    void keep_spots(int slice) {
        std::vector<Voxel>& spots = shadows_->spots_;
        for (; next_spot_ < seen_ + shades_.size(); next_spot_ += between_spots_) {
            const std::size_t line = shades_[next_spot_ - seen_].line;
            std::array<int, 3> at{};
            at[static_cast<std::size_t>(axis_)] = slice;
            at[static_cast<std::size_t>(u_)] = static_cast<int>(line / lines_v_.count) - line_u_;
            at[static_cast<std::size_t>(v_)] = static_cast<int>(line % lines_v_.count) - line_v_;
            const Voxel low = grid_->occupied_min_;
            spots.push_back({low.x + at[0], low.y + at[1], low.z + at[2]});
            if (spots.size() < kMostSpots) continue;
            for (std::size_t i = 0; 2 * i < kMostSpots; ++i)
                spots[i] = spots[2 * i];
            spots.resize(kMostSpots / 2);
            between_spots_ *= 2;
        }
        seen_ += shades_.size();
    }

    // The optical depth at a voxel of the block there; what it adds is noted.
    float depth_at(int place, int u, int v, float value) {
        const Voxel voxel = in_block(place);
        const std::size_t first = static_cast<std::size_t>(u + along(voxel, u_)) * lines_v_.count +
                                  static_cast<std::size_t>(v + along(voxel, v_));
        const float* line = &depths_[first];
        const float before = weights_[0] * line[0] + weights_[1] * line[1] + weights_[2] * line[lines_v_.count] +
                             weights_[3] * line[lines_v_.count + 1];
        const float own = step_depth_ * value;
        shades_.push_back({first, own});
        return before + 0.5F * own;
    }

    ShadowGrid* shadows_;
    const SparseGrid* grid_;
    int axis_, u_, v_;
    bool forward_;
    double slope_u_, slope_v_;  // of the light, per slice
    float step_depth_;          // optical depth from slice to slice, per unit of value
    Lines lines_u_, lines_v_;
    std::vector<float> depths_;       // of the lines, up to the slice
    int line_u_ = 0, line_v_ = 0;     // of the slice: the line before its first voxel
    std::array<float, 4> weights_{};  // and those of a voxel's four lines
    std::vector<Shade> shades_;
    std::size_t seen_ = 0, next_spot_ = 0, between_spots_ = 1;  // voxels
    std::array<std::uint64_t, 4> slices_{};
    std::vector<std::vector<Placed>> by_layer_;
    ShareTable share_;
};

ShadowGrid::ShadowGrid(const SparseGrid& grid, Vec3 to_light, double coefficient)
    : grid_(&grid), shares_(grid.codes_.size()), of_blocks_(8 * grid.bricks_.size()) {
    const auto& rows = grid.world_from_index().rows;
    const Vec3 travel = -to_light;
    deeper_ = coefficient * (travel.x * rows[0] + travel.y * rows[1] + travel.z * rows[2]);
    Sweep(*this, grid.index_from_world().direction(travel), coefficient).run();
}

double ShadowGrid::most_lines(const SparseGrid& grid) {
    const Voxel n = grid.brick_count_;
    const auto lines = [](int along, int axis) { return SparseGrid::kBrickSize * (1.0 * along + axis) + kLinesAround; };
    const auto across = [&](int along, int u, int v) { return lines(along, u) * lines(along, v); };
    return std::max({across(n.x, n.y, n.z), across(n.y, n.x, n.z), across(n.z, n.x, n.y)});
}

ShadowGrid::Place ShadowGrid::find(Vec3 world_um, Voxel voxel) const {
    const Vec3 index = grid_->index_from_world().point(world_um);
    Shaded near = look({floor_to_int(index.x + 0.5), floor_to_int(index.y + 0.5), floor_to_int(index.z + 0.5)});
    if (near.value <= 0) near = look(voxel);
    // exp(-x), as good as is needed.
    const double x = static_cast<double>(near.value) *
                     dot(deeper_, Vec3{index.x - near.at.x, index.y - near.at.y, index.z - near.at.z});
    const double even = 1 + x * x * (1.0 / 12);
    __builtin_prefetch(near.level);
    return {near.level, (even - 0.5 * x) / (even + 0.5 * x)};
}

ShadowGrid::Shaded ShadowGrid::look(Voxel voxel) const {
    const Voxel low = grid_->occupied_min_;
    const int x = voxel.x - low.x;
    const int y = voxel.y - low.y;
    const int z = voxel.z - low.z;
    const Voxel n = grid_->brick_count_;
    if (static_cast<unsigned>(x >> 3) >= static_cast<unsigned>(n.x) ||
        static_cast<unsigned>(y >> 3) >= static_cast<unsigned>(n.y) ||
        static_cast<unsigned>(z >> 3) >= static_cast<unsigned>(n.z))
        return {};
    const std::size_t place = grid_->brick_place(x >> 3, y >> 3, z >> 3);
    if (!grid_->directory_.has(place)) return {};
    const std::size_t b = grid_->directory_.brick(place);
    const SparseGrid::Brick& brick = grid_->bricks_[b];
    const auto block = static_cast<std::size_t>((x & 4) | ((y & 4) >> 1) | ((z & 4) >> 2));
    const std::uint16_t child = brick.child[block];
    if (child >= SparseGrid::kConstants) {
        const float value = grid_->constants_[child - SparseGrid::kConstants];
        const Voxel middle{(voxel.x & ~3) + 2, (voxel.y & ~3) + 2, (voxel.z & ~3) + 2};
        return {value, &of_blocks_[8 * b + block], middle};
    }
    const std::size_t first = std::size_t{brick.base} + child;
    std::uint64_t mask = 0;
    std::memcpy(&mask, &grid_->codes_[first], sizeof(mask));
    const std::uint64_t bit = std::uint64_t{1} << static_cast<unsigned>(((x & 3) << 4) | ((y & 3) << 2) | (z & 3));
    if ((mask & bit) == 0) return {};
    const std::size_t code = first + 4 + static_cast<std::size_t>(SparseGrid::count_bits(mask & (bit - 1)));
    return {brick.decoded(grid_->codes_[code]), &shares_[code], voxel};
}

}  // namespace fluovox
