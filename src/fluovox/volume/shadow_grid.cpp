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
        for (int place = 0; place < 64; ++place) {
            const Voxel voxel = in_block(place);
            places_[static_cast<std::size_t>(place)] = {line_at(along(voxel, u_), along(voxel, v_)),
                                                        static_cast<std::size_t>(along(voxel, axis_))};
        }
    }

    void run() {
        find_bricks();
        const int layers = along(grid_->brick_count_, axis_);
        for (int n = 0; n < layers; ++n)
            take_layer(forward_ ? n : layers - 1 - n);
    }

private:
    static constexpr std::size_t kMostSpots = 1024;

    struct Placed {
        std::uint32_t brick = 0;
        int u = 0, v = 0;  // of its corner, in voxels of the box
    };
    // A voxel that is not zero.
    struct Filled {
        std::uint32_t line = 0;         // the first of the four around it, in a slice where lines start at its corner
        float depth = 0;                // that it adds
        std::uint8_t* level = nullptr;  // where its share of light goes; or null
    };
    struct Place {
        std::uint32_t line = 0;  // from the corner of the block
        std::size_t slice = 0;
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
        by_layer_.resize(static_cast<std::size_t>(along(n, axis_)));
        std::uint32_t brick = 0;  // they lie as their places do
        for (Voxel at; at.x < n.x; ++at.x) {
            for (at.y = 0; at.y < n.y; ++at.y) {
                for (at.z = 0; at.z < n.z; ++at.z) {
                    if (!grid_->directory_.has(grid_->directory_.place(at))) continue;
                    by_layer_[static_cast<std::size_t>(along(at, axis_))].push_back(
                        {brick, SparseGrid::kBrickSize * along(at, u_), SparseGrid::kBrickSize * along(at, v_)});
                    ++brick;
                }
            }
        }
    }

    void take_layer(int layer) {
        for (std::vector<Filled>& slice : slices_)
            slice.clear();
        for (const Placed& placed : by_layer_[static_cast<std::size_t>(layer)]) {
            for (unsigned block = 0; block < 8; ++block)
                take_block(placed, block);
        }
        constexpr int kSlices = SparseGrid::kBrickSize;
        for (int n = 0; n < kSlices; ++n)
            shade_slice(kSlices * layer + (forward_ ? n : kSlices - 1 - n));
    }

    // Sorts its voxels into slices.
    void take_block(const Placed& placed, unsigned block) {
        const SparseGrid::Brick& brick = grid_->bricks_[placed.brick];
        const std::uint16_t child = brick.child[block];
        const Voxel corner{static_cast<int>(block & 4U), static_cast<int>((block & 2U) << 1U),
                           static_cast<int>((block & 1U) << 2U)};
        const std::uint32_t line = line_at(placed.u + along(corner, u_), placed.v + along(corner, v_));
        std::vector<Filled>* const slices = &slices_[static_cast<std::size_t>(along(corner, axis_))];
        const auto take = [&](int n, float value, std::uint8_t* level) {
            const Place& place = places_[static_cast<std::size_t>(n)];
            slices[place.slice].push_back({line + place.line, step_depth_ * value, level});
        };
        if (child >= SparseGrid::kConstants) {
            const float value = grid_->constants_[child - SparseGrid::kConstants];
            if (value <= 0) return;
            std::uint8_t* const level = &shadows_->of_blocks_[8 * std::size_t{placed.brick} + block];
            for (int n = 0; n < 64; ++n)
                take(n, value, n == kMiddle ? level : nullptr);
            return;
        }
        std::size_t code = std::size_t{brick.base} + child;
        std::uint64_t mask = 0;
        std::memcpy(&mask, &grid_->codes_[code], sizeof(mask));
        code += 4;
        for (; mask != 0; mask &= mask - 1, ++code)
            take(std::countr_zero(mask), brick.decoded(grid_->codes_[code]), &shadows_->shares_[code]);
    }

    // First all voxels read what lies before them, then all add what they are.
    void shade_slice(int slice) {
        const double u = -slope_u_ * slice - lines_u_.first;
        const double v = -slope_v_ * slice - lines_v_.first;
        const int line_u = static_cast<int>(u);
        const int line_v = static_cast<int>(v);
        const auto fu = static_cast<float>(u - line_u);
        const auto fv = static_cast<float>(v - line_v);
        const std::array<float, 4> weights = {(1 - fu) * (1 - fv), (1 - fu) * fv, fu * (1 - fv), fu * fv};
        float* const lines = &depths_[line_at(line_u, line_v)];
        const std::size_t next = lines_v_.count;
        const std::vector<Filled>& filled = slices_[static_cast<std::size_t>(slice % SparseGrid::kBrickSize)];
        for (const Filled& voxel : filled) {
            if (voxel.level == nullptr) continue;
            const float* line = lines + voxel.line;
            const float before =
                weights[0] * line[0] + weights[1] * line[1] + weights[2] * line[next] + weights[3] * line[next + 1];
            *voxel.level = share_(before + 0.5F * voxel.depth);
        }
        keep_spots(slice, filled);
        for (const Filled& voxel : filled) {
            float* line = lines + voxel.line;
            line[0] += weights[0] * voxel.depth;
            line[1] += weights[1] * voxel.depth;
            line[next] += weights[2] * voxel.depth;
            line[next + 1] += weights[3] * voxel.depth;
        }
    }

    std::uint32_t line_at(int u, int v) const {
        return static_cast<std::uint32_t>(static_cast<std::size_t>(u) * lines_v_.count + static_cast<std::size_t>(v));
    }

    // Every so many voxels one is kept; when those are too many, every second of them.
    void keep_spots(int slice, const std::vector<Filled>& filled) {
        std::vector<Voxel>& spots = shadows_->spots_;
        for (; next_spot_ < seen_ + filled.size(); next_spot_ += between_spots_) {
            const std::uint32_t line = filled[next_spot_ - seen_].line;
            std::array<int, 3> at{};
            at[static_cast<std::size_t>(axis_)] = slice;
            at[static_cast<std::size_t>(u_)] = static_cast<int>(line / lines_v_.count);
            at[static_cast<std::size_t>(v_)] = static_cast<int>(line % lines_v_.count);
            const Voxel low = grid_->occupied_min_;
            spots.push_back({low.x + at[0], low.y + at[1], low.z + at[2]});
            if (spots.size() < kMostSpots) continue;
            for (std::size_t i = 0; 2 * i < kMostSpots; ++i)
                spots[i] = spots[2 * i];
            spots.resize(kMostSpots / 2);
            between_spots_ *= 2;
        }
        seen_ += filled.size();
    }

    ShadowGrid* shadows_;
    const SparseGrid* grid_;
    int axis_, u_, v_;
    bool forward_;
    double slope_u_, slope_v_;  // of the light, per slice
    float step_depth_;          // optical depth from slice to slice, per unit of value
    Lines lines_u_, lines_v_;
    std::vector<float> depths_;  // of the lines, up to the slice
    std::array<Place, 64> places_{};
    std::array<std::vector<Filled>, SparseGrid::kBrickSize> slices_;  // of the layer
    std::size_t seen_ = 0, next_spot_ = 0, between_spots_ = 1;        // voxels
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
    const std::size_t place = grid_->directory_.place({x >> 3, y >> 3, z >> 3});
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
    const std::size_t code = first + 4 + static_cast<std::size_t>(count_bits(mask & (bit - 1)));
    return {brick.decoded(grid_->codes_[code]), &shares_[code], voxel};
}

}  // namespace fluovox
