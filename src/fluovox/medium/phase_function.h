#pragma once

#include "fluovox/core/circle.h"
#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/spectral/spectrum.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <variant>
#include <vector>

namespace fluovox {

/// Henyey-Greenstein phase function, per steradian, of the cosine between the direction of flight before and after;
/// -1 < g < 1 is the mean cosine. Henyey & Greenstein, Astrophys. J. 93 (1941) 70.
inline double henyey_greenstein(double cosine, double g) {
    if (g == 0) return 1 / (4 * std::numbers::pi);
    const double d = 1 + g * g - 2 * g * cosine;
    return (1 - g * g) / (4 * std::numbers::pi * d * std::sqrt(d));
}

/// A cosine with that density; `u` uniform in [0, 1). The usual inversion multiplied out, so that nothing cancels
/// for small g.
inline double sample_henyey_greenstein_cosine(double g, double u) {
    const double x = 2 * u - 1;
    const double numerator = x + 0.5 * g * (x * x + 3) + g * g * x + 0.5 * g * g * g * (x * x - 1);
    return std::clamp(numerator / ((1 + g * x) * (1 + g * x)), -1.0, 1.0);
}

/// The unit vector at that cosine and an azimuth (`u` uniform in [0, 1)) around `axis`.
inline Vec3 turned(Vec3 axis, double cosine, double u) {
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const CirclePoint azimuth = on_circle(u);
    return Frame::around(axis).to_world({sine * azimuth.cos, sine * azimuth.sin, cosine});
}

/// Forward and backward lobes: `weight` henyey_greenstein(g1) + (1 - weight) henyey_greenstein(g2).
struct TwoTermHenyeyGreenstein {
    double g1 = 0, g2 = 0, weight = 1;
};

struct HenyeyGreenstein {
    double g = 0;  ///< 0: isotropic
};

/// Of particles much smaller than the wavelength: 3 (1 + cosine^2) / (16 pi).
struct Rayleigh {};

/// Any phase function: linear in the cosine between the rows of a table.
class PhaseTable {
public:
    /// `cosines` strictly increasing from -1 to 1; `values` of any scale, none negative; scaled so that the integral
    /// over all directions is one. Throws std::invalid_argument, also where that integral is zero or not finite.
    PhaseTable(std::vector<double> cosines, std::vector<double> values);

    double operator()(double cosine) const { return per_sr_(cosine); }
    double sample_cosine(double u) const { return per_sr_.sample(u); }
    double mean_cosine() const;
    /// Integral over all directions of the values as given.
    double given_integral() const { return given_integral_; }
    const std::vector<double>& cosines() const { return per_sr_.wavelengths_nm(); }
    const std::vector<double>& values_per_sr() const { return per_sr_.values(); }

private:
    Spectrum per_sr_;  // a function that is linear between its rows and can be drawn from, here of the cosine
    double given_integral_ = 1;
};

/// How light is scattered: a density per steradian of the cosine between the flight before and after.
using PhaseFunction = std::variant<HenyeyGreenstein, TwoTermHenyeyGreenstein, Rayleigh, PhaseTable>;

// The less common kinds.
double other_phase_per_sr(const PhaseFunction& phase, double cosine);
double sample_other_cosine(const PhaseFunction& phase, double u);

/// The phase function at a cosine, per steradian.
inline double phase_per_sr(const PhaseFunction& phase, double cosine) {
    const auto* usual = std::get_if<HenyeyGreenstein>(&phase);
    return usual != nullptr ? henyey_greenstein(cosine, usual->g) : other_phase_per_sr(phase, cosine);
}

/// A cosine with that density; `u` uniform in [0, 1).
inline double sample_phase_cosine(const PhaseFunction& phase, double u) {
    const auto* usual = std::get_if<HenyeyGreenstein>(&phase);
    return usual != nullptr ? sample_henyey_greenstein_cosine(usual->g, u) : sample_other_cosine(phase, u);
}

/// Its mean cosine, the anisotropy g.
double mean_cosine(const PhaseFunction& phase);

/// True where every direction is as likely.
inline bool is_isotropic(const PhaseFunction& phase) {
    const auto* usual = std::get_if<HenyeyGreenstein>(&phase);
    return usual != nullptr && usual->g == 0;
}

/// A direction uniform over the sphere, in steps of 2^-31; by rejection (Marsaglia, Ann. Math. Stat. 43 (1972) 645).
inline Vec3 sample_isotropic(Rng& rng) {
    for (;;) {
        const std::uint64_t drawn = rng.bits();
        const double x = 0x1.0p-31 * static_cast<double>(static_cast<std::int32_t>(drawn >> 32U));
        const double y = 0x1.0p-31 * static_cast<double>(static_cast<std::int32_t>(drawn));
        const double s = x * x + y * y;
        if (s >= 1) continue;
        const double r = 2 * std::sqrt(1 - s);
        return {r * x, r * y, 1 - 2 * s};
    }
}

/// The same by two numbers uniform in [0, 1).
inline Vec3 sample_isotropic(double u1, double u2) {
    const double cosine = 1 - 2 * u1;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const CirclePoint azimuth = on_circle(u2);
    return {sine * azimuth.cos, sine * azimuth.sin, cosine};
}

}  // namespace fluovox
