#include "fluovox/spectral/spectrum.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace fluovox {
namespace {

// Every wavelength at which either is tabulated.
std::vector<double> merged_knots(const Spectrum& a, const Spectrum& b) {
    std::vector<double> knots = a.wavelengths_nm();
    knots.insert(knots.end(), b.wavelengths_nm().begin(), b.wavelengths_nm().end());
    std::sort(knots.begin(), knots.end());
    knots.erase(std::unique(knots.begin(), knots.end()), knots.end());
    return knots;
}

}  // namespace

Spectrum::Spectrum(std::vector<double> wavelengths_nm, std::vector<double> values)
    : wavelengths_nm_(std::move(wavelengths_nm)), values_(std::move(values)) {
    if (wavelengths_nm_.size() != values_.size() || values_.size() < 2) {
        throw std::invalid_argument("a spectrum needs at least two wavelengths and one value for each");
    }
    cumulative_.assign(values_.size(), 0);
    for (std::size_t i = 0; i < values_.size(); ++i) {
        if (!std::isfinite(values_[i]) || !std::isfinite(wavelengths_nm_[i])) {
            throw std::invalid_argument("a spectrum's numbers must be finite");
        }
        if (i == 0) continue;
        const double step = wavelengths_nm_[i] - wavelengths_nm_[i - 1];
        if (!(step > 0)) throw std::invalid_argument("a spectrum's wavelengths must increase");
        cumulative_[i] = cumulative_[i - 1] + 0.5 * step * (values_[i] + values_[i - 1]);
        slopes_.push_back((values_[i] - values_[i - 1]) / step);
    }
    // A few times as many stretches as knots, so that looking one up seldom takes a step.
    const std::size_t stretches = 4 * values_.size();
    stretches_per_nm_ = static_cast<double>(stretches) / (last_nm() - first_nm());
    for (std::size_t s = 0; s <= stretches; ++s) {
        const double start = first_nm() + static_cast<double>(s) / stretches_per_nm_;
        const auto above = std::upper_bound(wavelengths_nm_.begin(), wavelengths_nm_.end() - 1, start);
        first_knot_.push_back(static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(above - wavelengths_nm_.begin(), 1)));
    }
}

std::size_t Spectrum::knot_above(double wavelength_nm) const {
    const auto stretch = static_cast<std::size_t>((wavelength_nm - first_nm()) * stretches_per_nm_);
    std::size_t i = first_knot_[std::min(stretch, first_knot_.size() - 1)];
    // Rounding may have chosen the next stretch.
    while (i > 1 && wavelengths_nm_[i - 1] > wavelength_nm)
        --i;
    while (i + 1 < wavelengths_nm_.size() && wavelengths_nm_[i] <= wavelength_nm)
        ++i;
    return i;
}

Spectrum Spectrum::box(double from_nm, double to_nm, double value) {
    return {{from_nm, to_nm}, {value, value}};
}

double Spectrum::operator()(double wavelength_nm) const {
    if (empty() || !(wavelength_nm >= first_nm()) || wavelength_nm > last_nm()) return 0;
    const std::size_t i = knot_above(wavelength_nm);
    // From the nearer knot, so that the value at each is the one tabulated.
    const double after = wavelength_nm - wavelengths_nm_[i - 1];
    const double before = wavelengths_nm_[i] - wavelength_nm;
    return after <= before ? values_[i - 1] + after * slopes_[i - 1] : values_[i] - before * slopes_[i - 1];
}

Lanes Spectrum::operator()(const Lanes& wavelengths_nm) const {
    Lanes values(wavelengths_nm.count());
    for (int k = 0; k < values.count(); ++k)
        values[k] = (*this)(wavelengths_nm[k]);
    return values;
}

double Spectrum::integral(double from_nm, double to_nm) const {
    if (empty() || !(to_nm > from_nm)) return 0;
    const auto up_to = [this](double nm) {
        if (nm <= first_nm()) return 0.0;
        if (nm >= last_nm()) return integral();
        const auto above = std::upper_bound(wavelengths_nm_.begin(), wavelengths_nm_.end(), nm);
        const auto i = static_cast<std::size_t>(above - wavelengths_nm_.begin()) - 1;
        return cumulative_[i] + 0.5 * (nm - wavelengths_nm_[i]) * (values_[i] + (*this)(nm));
    };
    return up_to(to_nm) - up_to(from_nm);
}

double Spectrum::sample(double u) const {
    const double target = u * integral();
    const auto above = std::upper_bound(cumulative_.begin(), cumulative_.end() - 1, target);
    const auto i = std::max<std::size_t>(static_cast<std::size_t>(above - cumulative_.begin()), 1);
    const double step = wavelengths_nm_[i] - wavelengths_nm_[i - 1];
    const double low = values_[i - 1];
    const double slope = (values_[i] - low) / step;
    const double area = target - cumulative_[i - 1];
    // The root of low x + slope x^2 / 2 = area that lies in the interval, in the form that does not cancel.
    const double root = std::sqrt(std::max(0.0, low * low + 2 * slope * area));
    const double x = low + root > 0 ? 2 * area / (low + root) : 0;
    return wavelengths_nm_[i - 1] + std::clamp(x, 0.0, step);
}

double Spectrum::pdf(double wavelength_nm) const {
    return integral() > 0 ? (*this)(wavelength_nm) / integral() : 0;
}

double Spectrum::max() const {
    return empty() ? 0 : *std::max_element(values_.begin(), values_.end());
}

double Spectrum::peak_nm() const {
    if (empty()) return 0;
    const auto highest = std::max_element(values_.begin(), values_.end());
    return wavelengths_nm_[static_cast<std::size_t>(highest - values_.begin())];
}

Spectrum Spectrum::scaled(double factor) const {
    if (empty()) return {};
    std::vector<double> values = values_;
    for (double& value : values)
        value *= factor;
    return {wavelengths_nm_, std::move(values)};
}

Spectrum product(const Spectrum& a, const Spectrum& b) {
    if (a.empty() || b.empty()) return {};
    const double from = std::max(a.first_nm(), b.first_nm());
    const double to = std::min(a.last_nm(), b.last_nm());
    if (!(to > from)) return {};
    std::vector<double> knots;
    std::vector<double> values;
    for (const double nm : merged_knots(a, b)) {
        if (nm < from || nm > to) continue;
        knots.push_back(nm);
        values.push_back(a(nm) * b(nm));
    }
    return {std::move(knots), std::move(values)};
}

Spectrum sampling_product(const Spectrum& a, const Spectrum& b) {
    const Spectrum coarse = product(a, b);
    if (coarse.empty()) return {};
    // The product of two lines is a parabola: with its middle as one more knot the table is zero only where it is.
    std::vector<double> knots;
    std::vector<double> values;
    const auto& nm = coarse.wavelengths_nm();
    for (std::size_t i = 0; i < nm.size(); ++i) {
        if (i > 0) {
            const double middle = 0.5 * (nm[i - 1] + nm[i]);
            knots.push_back(middle);
            values.push_back(a(middle) * b(middle));
        }
        knots.push_back(nm[i]);
        values.push_back(coarse.values()[i]);
    }
    return {std::move(knots), std::move(values)};
}

Spectrum sum(const Spectrum& a, const Spectrum& b) {
    if (a.empty()) return b;
    if (b.empty()) return a;
    std::vector<double> knots = merged_knots(a, b);
    std::vector<double> values;
    values.reserve(knots.size());
    for (const double nm : knots)
        values.push_back(a(nm) + b(nm));
    return {std::move(knots), std::move(values)};
}

double integral_of_product(const Spectrum& a, const Spectrum& b) {
    const double from = std::max(a.first_nm(), b.first_nm());
    const double to = std::min(a.last_nm(), b.last_nm());
    if (a.empty() || b.empty() || !(to > from)) return 0;
    double total = 0;
    double previous = from;
    for (const double nm : merged_knots(a, b)) {
        if (nm <= from || nm > to) continue;
        const double middle = 0.5 * (previous + nm);  // Simpson's rule is exact for a parabola
        total += (nm - previous) / 6 * (a(previous) * b(previous) + 4 * a(middle) * b(middle) + a(nm) * b(nm));
        previous = nm;
    }
    return total;
}

}  // namespace fluovox
