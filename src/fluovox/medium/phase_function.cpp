#include "fluovox/medium/phase_function.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace fluovox {
namespace {

constexpr double kPi = std::numbers::pi;

// Inverse of the distribution (cosine^3 + 3 cosine + 4) / 8: the one real root of a cubic (Cardano).
double sample_rayleigh_cosine(double u) {
    const double half = 2 - 4 * u;
    const double root = std::cbrt(std::abs(half) + std::sqrt(half * half + 1));
    const double cosine = std::copysign(1 / root - root, half);
    return std::clamp(cosine, -1.0, 1.0);
}

struct PerSr {
    double cosine;
    double operator()(const HenyeyGreenstein& p) const { return henyey_greenstein(cosine, p.g); }
    double operator()(const TwoTermHenyeyGreenstein& p) const {
        return p.weight * henyey_greenstein(cosine, p.g1) + (1 - p.weight) * henyey_greenstein(cosine, p.g2);
    }
    double operator()(const Rayleigh& /*p*/) const { return 3 * (1 + cosine * cosine) / (16 * kPi); }
    double operator()(const PhaseTable& p) const { return p(std::clamp(cosine, -1.0, 1.0)); }
};

struct SampleCosine {
    double u;
    double operator()(const HenyeyGreenstein& p) const { return sample_henyey_greenstein_cosine(p.g, u); }
    double operator()(const TwoTermHenyeyGreenstein& p) const {
        return u < p.weight ? sample_henyey_greenstein_cosine(p.g1, u / p.weight)
                            : sample_henyey_greenstein_cosine(p.g2, (u - p.weight) / (1 - p.weight));
    }
    double operator()(const Rayleigh& /*p*/) const { return sample_rayleigh_cosine(u); }
    double operator()(const PhaseTable& p) const { return p.sample_cosine(u); }
};

struct MeanCosine {
    double operator()(const HenyeyGreenstein& p) const { return p.g; }
    double operator()(const TwoTermHenyeyGreenstein& p) const { return p.weight * p.g1 + (1 - p.weight) * p.g2; }
    double operator()(const Rayleigh& /*p*/) const { return 0; }
    double operator()(const PhaseTable& p) const { return p.mean_cosine(); }
};

}  // namespace

PhaseTable::PhaseTable(std::vector<double> cosines, std::vector<double> values) {
    if (cosines.empty() || cosines.front() != -1 || cosines.back() != 1)
        throw std::invalid_argument("must reach from cosine -1 (180 degrees) to 1 (0 degrees)");
    if (std::any_of(values.begin(), values.end(), [](double v) { return v < 0; }))
        throw std::invalid_argument("has a negative value");
    const Spectrum given(std::move(cosines), std::move(values));
    given_integral_ = 2 * kPi * given.integral();
    if (!(given_integral_ > 0) || !std::isfinite(given_integral_) || !std::isfinite(1 / given_integral_))
        throw std::invalid_argument("cannot be normalised: its integral over all directions is zero or not finite");
    per_sr_ = given.scaled(1 / given_integral_);
}

double PhaseTable::mean_cosine() const {
    const std::vector<double>& x = cosines();
    const std::vector<double>& p = values_per_sr();
    double mean = 0;
    for (std::size_t i = 1; i < x.size(); ++i)
        mean += (x[i] - x[i - 1]) * (p[i - 1] * (2 * x[i - 1] + x[i]) + p[i] * (x[i - 1] + 2 * x[i])) / 6;
    return 2 * kPi * mean;
}

double other_phase_per_sr(const PhaseFunction& phase, double cosine) {
    return std::visit(PerSr{cosine}, phase);
}

double sample_other_cosine(const PhaseFunction& phase, double u) {
    return std::visit(SampleCosine{u}, phase);
}

double mean_cosine(const PhaseFunction& phase) {
    return std::visit(MeanCosine{}, phase);
}

}  // namespace fluovox
