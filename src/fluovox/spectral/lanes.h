#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

namespace fluovox {

/// How many wavelengths a path may carry at once. With more, each bin of a fine spectrum gains, but the sum of the bins
/// does not, whose noise is that of the paths: 32 would make the bins of a neuron better by half for a third more time.
inline constexpr int kMaxLanes = 16;

/// One number for each wavelength that a path carries. Only as many as there are are worked on, so that a path of few
/// wavelengths does not pay for many; both sides of an operation have the same number of lanes.
class Lanes {
public:
    constexpr Lanes() : Lanes(0) {}
    /// All with the same value.
    constexpr explicit Lanes(int count, double value = 0) : count_(count) {  // NOLINT(*-member-init): only what is used
        for_blocks([&](std::size_t i) { v_[i] = value; });
    }
    constexpr Lanes(const Lanes& b) : count_(b.count_) {  // NOLINT(*-member-init): only what is used
        for_blocks([&](std::size_t i) { v_[i] = b.v_[i]; });
    }
    constexpr Lanes& operator=(const Lanes& b) {
        count_ = b.count_;
        for_blocks([&](std::size_t i) { v_[i] = b.v_[i]; });
        return *this;
    }
    ~Lanes() = default;

    constexpr int count() const { return count_; }
    constexpr double& operator[](int i) {
        assert(i < count_);
        return v_[static_cast<std::size_t>(i)];
    }
    constexpr double operator[](int i) const {
        assert(i < count_);
        return v_[static_cast<std::size_t>(i)];
    }

    constexpr Lanes& operator*=(const Lanes& b) {
        assert(b.count_ == count_);
        for_blocks([&](std::size_t i) { v_[i] *= b.v_[i]; });
        return *this;
    }
    constexpr Lanes& operator*=(double s) {
        for_blocks([&](std::size_t i) { v_[i] *= s; });
        return *this;
    }
    constexpr Lanes& operator+=(const Lanes& b) {
        assert(b.count_ == count_);
        for_blocks([&](std::size_t i) { v_[i] += b.v_[i]; });
        return *this;
    }
    /// The largest, at least zero.
    constexpr double max() const {
        std::array<double, kBlock> most{};
        std::size_t first = 0;
        for (; first + kBlock <= static_cast<std::size_t>(count_); first += kBlock) {
            for (std::size_t i = 0; i < kBlock; ++i)
                most[i] = std::max(most[i], v_[first + i]);
        }
        for (; first < static_cast<std::size_t>(count_); ++first)
            most[0] = std::max(most[0], v_[first]);
        return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
    }
    constexpr double sum() const {
        double total = 0;
        for (int i = 0; i < count_; ++i)
            total += (*this)[i];
        return total;
    }
    constexpr double mean() const { return sum() / count_; }

private:
    // Whole blocks are worked on, several lanes at once: the last may reach beyond the count, where anything may be.
    static constexpr std::size_t kBlock = 4;
    static_assert(kMaxLanes % kBlock == 0);

    template <class Work>
    constexpr void for_blocks(const Work& work) const {
        for (std::size_t first = 0; first < static_cast<std::size_t>(count_); first += kBlock) {
            for (std::size_t i = first; i < first + kBlock; ++i)
                work(i);
        }
    }

    int count_;
    std::array<double, kMaxLanes> v_;
};

constexpr Lanes operator*(Lanes a, const Lanes& b) {
    a *= b;
    return a;
}
constexpr Lanes operator*(double s, Lanes a) {
    a *= s;
    return a;
}
constexpr Lanes operator+(Lanes a, const Lanes& b) {
    a += b;
    return a;
}

/// exp(-depth) in each lane, to 4e-16 of its value; 0 beyond 708. The same bytes on every machine, and a few times
/// faster than a call per lane. Depths may be infinite, not NaN.
Lanes exp_minus(const Lanes& depth);

/// The wavelengths of one path; the first is the hero, which steers it.
/// Wilkie et al., "Hero wavelength spectral sampling", EGSR 2014.
struct Wavelengths {
    Lanes nm;
    Lanes pdf_per_nm;  ///< density each was drawn with, or one for a laser line

    Wavelengths() = default;
    explicit Wavelengths(int count) : nm(count), pdf_per_nm(count) {}

    int count() const { return nm.count(); }

    /// A single one.
    static Wavelengths one(double wavelength_nm) {
        Wavelengths single(1);
        single.nm[0] = wavelength_nm;
        single.pdf_per_nm[0] = 1;
        return single;
    }
};

}  // namespace fluovox
