#pragma once

#include "fluovox/spectral/lanes.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {

/// A function of wavelength given at increasing wavelengths; linear between them, zero outside.
/// Its own density is what it draws from, so its values must not be negative when `sample` is used.
class Spectrum {
public:
    /// Zero everywhere.
    Spectrum() = default;
    /// `wavelengths_nm` strictly increasing, as many as `values`, at least two, all finite; throws
    /// std::invalid_argument.
    Spectrum(std::vector<double> wavelengths_nm, std::vector<double> values);
    /// The same value from `from_nm` to `to_nm`.
    static Spectrum box(double from_nm, double to_nm, double value);

    double operator()(double wavelength_nm) const;
    Lanes operator()(const Lanes& wavelengths_nm) const;

    /// Integral over all wavelengths, in units of the values times nanometres.
    double integral() const { return cumulative_.empty() ? 0 : cumulative_.back(); }
    /// Integral between two wavelengths.
    double integral(double from_nm, double to_nm) const;

    /// Draws a wavelength with density value / integral; `u` in [0, 1). The integral must be positive.
    double sample(double u) const;
    /// Density of `sample`, per nanometre.
    double pdf(double wavelength_nm) const;

    bool empty() const { return wavelengths_nm_.empty(); }
    double first_nm() const { return wavelengths_nm_.empty() ? 0 : wavelengths_nm_.front(); }
    double last_nm() const { return wavelengths_nm_.empty() ? 0 : wavelengths_nm_.back(); }
    double max() const;
    /// Wavelength of the highest value.
    double peak_nm() const;
    /// Every value times `factor`.
    Spectrum scaled(double factor) const;

    const std::vector<double>& wavelengths_nm() const { return wavelengths_nm_; }
    const std::vector<double>& values() const { return values_; }

private:
    /// Index of the first knot above a wavelength within the table; the last knot at its end.
    std::size_t knot_above(double wavelength_nm) const;

    std::vector<double> wavelengths_nm_;
    std::vector<double> values_;
    std::vector<double> slopes_;             // between each knot and the next
    std::vector<double> cumulative_;         // integral from the first wavelength up to each
    std::vector<std::uint32_t> first_knot_;  // for each equal stretch of the range, the first knot above its start
    double stretches_per_nm_ = 0;
};

/// Values multiplied at every wavelength either of them is tabulated at; linear between these.
/// (The exact product is a parabola there: use `integral_of_product` for integrals.)
Spectrum product(const Spectrum& a, const Spectrum& b);

/// Like `product`, but positive wherever a(x) b(x) is, also between knots: a table to draw wavelengths from.
Spectrum sampling_product(const Spectrum& a, const Spectrum& b);

/// Values added at every wavelength either of them is tabulated at; exact except at a jump at an end.
Spectrum sum(const Spectrum& a, const Spectrum& b);

/// Exact integral of a times b over all wavelengths.
double integral_of_product(const Spectrum& a, const Spectrum& b);

}  // namespace fluovox
