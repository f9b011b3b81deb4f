#pragma once

#include "fluovox/core/vec.h"

#include <cmath>
#include <numbers>

namespace fluovox {

/// Henyey-Greenstein phase function, per steradian, of the cosine between the direction of flight before and after;
/// -1 < g < 1 is the mean cosine. Henyey & Greenstein, Astrophys. J. 93 (1941) 70.
inline double henyey_greenstein(double cosine, double g) {
    const double d = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * std::numbers::pi * d * std::sqrt(d));
}

/// A cosine with that density; `u` uniform in [0, 1). The usual inversion multiplied out, so that nothing cancels
/// for small g.
inline double sample_henyey_greenstein_cosine(double g, double u) {
    const double x = 2 * u - 1;
    const double numerator = x + 0.5 * g * (x * x + 3) + g * g * x + 0.5 * g * g * g * (x * x - 1);
    return std::fmin(1, std::fmax(-1, numerator / ((1 + g * x) * (1 + g * x))));
}

/// The unit vector at that cosine and an azimuth (`u` uniform in [0, 1)) around `axis`.
inline Vec3 turned(Vec3 axis, double cosine, double u) {
    const double sine = std::sqrt(std::fmax(0, 1 - cosine * cosine));
    const double azimuth = 2 * std::numbers::pi * u;
    return Frame::around(axis).to_world({sine * std::cos(azimuth), sine * std::sin(azimuth), cosine});
}

/// A direction uniform over the sphere.
inline Vec3 sample_isotropic(double u1, double u2) {
    return turned({0, 0, 1}, 1 - 2 * u1, u2);
}

}  // namespace fluovox
