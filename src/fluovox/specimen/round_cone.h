#pragma once

#include "fluovox/core/vec.h"

#include <algorithm>
#include <cmath>

namespace fluovox {

/// The hull of two spheres: one tapered piece of a cable with round ends. All lengths in micrometres.
struct RoundCone {
    Vec3 begin, end;
    double begin_radius_um = 0, end_radius_um = 0;
    double blend_um = 0;  ///< how far it melts into what it touches
};

/// Signed distance from `position` to the surface, negative inside.
///
/// The hull is the union of the spheres along the axis, so the distance is the least of |p - (a + t d)| - r(t). With
/// the slope s = dr/dt, x along the axis and y across it, that is convex in t and least at t = x + y s / sqrt(1 - s^2).
inline double signed_distance_um(const RoundCone& cone, Vec3 position) {
    const Vec3 axis = cone.end - cone.begin;
    const Vec3 from_begin = position - cone.begin;
    const double along = length(axis);
    const double taper = cone.end_radius_um - cone.begin_radius_um;
    if (along <= std::abs(taper)) {  // one sphere holds the other
        return std::min(length(from_begin) - cone.begin_radius_um, length(position - cone.end) - cone.end_radius_um);
    }
    const double slope = taper / along;
    const double x = dot(from_begin, axis) / along;
    const double y = std::sqrt(std::max(0.0, length_squared(from_begin) - x * x));
    const double t = std::clamp(x + y * slope / std::sqrt(1 - slope * slope), 0.0, along);
    return std::hypot(x - t, y) - (cone.begin_radius_um + slope * t);
}

}  // namespace fluovox
