#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace fluovox {

/// How many wavelengths a path may carry at once.
inline constexpr int kMaxLanes = 8;

/// One number for each wavelength that a path carries. Unused lanes hold zero (or anything harmless).
struct Lanes {
    std::array<double, kMaxLanes> v{};

    static constexpr Lanes all(double value) {
        Lanes lanes;
        lanes.v.fill(value);
        return lanes;
    }
    constexpr double& operator[](int i) { return v[static_cast<std::size_t>(i)]; }
    constexpr double operator[](int i) const { return v[static_cast<std::size_t>(i)]; }

    constexpr Lanes& operator*=(const Lanes& b) {
        for (std::size_t i = 0; i < v.size(); ++i)
            v[i] *= b.v[i];
        return *this;
    }
    constexpr Lanes& operator*=(double s) {
        for (double& x : v)
            x *= s;
        return *this;
    }
    constexpr Lanes& operator+=(const Lanes& b) {
        for (std::size_t i = 0; i < v.size(); ++i)
            v[i] += b.v[i];
        return *this;
    }
    constexpr double max() const { return *std::max_element(v.begin(), v.end()); }
    constexpr double sum() const {
        double total = 0;
        for (const double x : v)
            total += x;
        return total;
    }
};

constexpr Lanes operator*(Lanes a, const Lanes& b) {
    return a *= b;
}
constexpr Lanes operator*(double s, Lanes a) {
    return a *= s;
}
constexpr Lanes operator+(Lanes a, const Lanes& b) {
    return a += b;
}

/// Mean of the first `count` lanes; the others must be zero.
constexpr double mean_of(const Lanes& lanes, int count) {
    return lanes.sum() / count;
}

/// exp(-depth) in the first `count` lanes, to 4e-16 of its value; 0 beyond 708, and in the other lanes. The same bytes
/// on every machine, and a few times faster than a call per lane. Depths may be infinite, not NaN.
Lanes exp_minus(const Lanes& depth, int count);

/// The wavelengths of one path; the first is the hero, which steers it.
/// Wilkie et al., "Hero wavelength spectral sampling", EGSR 2014.
struct Wavelengths {
    int count = 0;
    Lanes nm;
    Lanes pdf_per_nm;  ///< density each was drawn with, or one for a laser line

    /// A single one.
    static Wavelengths one(double wavelength_nm) {
        Wavelengths single;
        single.count = 1;
        single.nm[0] = wavelength_nm;
        single.pdf_per_nm[0] = 1;
        return single;
    }
};

}  // namespace fluovox
