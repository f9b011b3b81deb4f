#pragma once

#include "fluovox/core/vec.h"

#include <array>
#include <cstddef>

namespace fluovox {

/// A small convex polygon in space: a triangle cut by planes.
struct Polygon {
    static constexpr std::size_t kMost = 16;
    std::array<Vec3, kMost> corners;
    std::size_t size = 0;

    void add(const Vec3& corner) { corners[size++] = corner; }
    double low(int axis) const {
        double least = corners[0][axis];
        for (std::size_t i = 1; i < size; ++i)
            least = corners[i][axis] < least ? corners[i][axis] : least;
        return least;
    }
    double high(int axis) const {
        double most = corners[0][axis];
        for (std::size_t i = 1; i < size; ++i)
            most = corners[i][axis] > most ? corners[i][axis] : most;
        return most;
    }
};

/// Cuts a polygon by the plane `coordinate[axis] == at` into what is below and what is above. A part may be empty.
inline void split(const Polygon& polygon, int axis, double at, Polygon& below, Polygon& above) {
    below.size = 0;
    above.size = 0;
    for (std::size_t i = 0; i < polygon.size; ++i) {
        const Vec3& a = polygon.corners[i];
        const Vec3& b = polygon.corners[i + 1 == polygon.size ? 0 : i + 1];
        const double da = a[axis] - at;
        const double db = b[axis] - at;
        if (da <= 0) below.add(a);
        if (da >= 0) above.add(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            Vec3 cut = a + (da / (da - db)) * (b - a);
            cut[axis] = at;
            below.add(cut);
            above.add(cut);
        }
    }
}

}  // namespace fluovox
