#pragma once

#include "fluovox/core/vec.h"

#include <algorithm>
#include <limits>

namespace fluovox {

/// Axis-aligned box; empty (min > max) until something is added.
struct Bounds {
    Vec3 min = {kFar, kFar, kFar};
    Vec3 max = {-kFar, -kFar, -kFar};

    static constexpr double kFar = std::numeric_limits<double>::infinity();

    constexpr bool empty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
    constexpr Vec3 size() const { return max - min; }
    constexpr Vec3 center() const { return 0.5 * (min + max); }
    constexpr void add(Vec3 p) {
        for (int axis = 0; axis < 3; ++axis) {
            min[axis] = std::min(min[axis], p[axis]);
            max[axis] = std::max(max[axis], p[axis]);
        }
    }
    constexpr void add(const Bounds& other) {
        if (other.empty()) return;
        add(other.min);
        add(other.max);
    }
    constexpr bool contains(Vec3 p) const {
        return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z && p.z <= max.z;
    }
};

}  // namespace fluovox
