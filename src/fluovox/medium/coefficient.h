#pragma once

#include "fluovox/spectral/lanes.h"
#include "fluovox/spectral/spectrum.h"

#include <cmath>
#include <variant>

namespace fluovox {

/// value * (wavelength / at)^exponent, the usual form of tissue scattering.
/// Jacques, Phys. Med. Biol. 58 (2013) R37, eq. 1.
struct PowerLaw {
    double at_nm = 500;
    double value_per_um = 0;
    double exponent = 0;
};

/// A scattering or absorption coefficient, per micrometre: the same at all wavelengths (a number), a power law,
/// or a table that holds its end values outside.
using Coefficient = std::variant<double, PowerLaw, Spectrum>;

/// `coefficient` at a wavelength, per micrometre.
inline double coefficient_per_um(const Coefficient& coefficient, double wavelength_nm) {
    if (const auto* constant = std::get_if<double>(&coefficient)) return *constant;
    if (const auto* law = std::get_if<PowerLaw>(&coefficient)) {
        return law->value_per_um * std::pow(wavelength_nm / law->at_nm, law->exponent);
    }
    const auto& table = std::get<Spectrum>(coefficient);
    return table(std::fmin(std::fmax(wavelength_nm, table.first_nm()), table.last_nm()));
}

inline Lanes coefficient_per_um(const Coefficient& coefficient, const Lanes& wavelengths_nm) {
    if (const auto* constant = std::get_if<double>(&coefficient)) return Lanes(wavelengths_nm.count(), *constant);
    Lanes values(wavelengths_nm.count());
    for (int k = 0; k < values.count(); ++k)
        values[k] = coefficient_per_um(coefficient, wavelengths_nm[k]);
    return values;
}

/// True for a coefficient that is zero at every wavelength.
inline bool is_zero(const Coefficient& coefficient) {
    if (const auto* constant = std::get_if<double>(&coefficient)) return *constant == 0;
    if (const auto* law = std::get_if<PowerLaw>(&coefficient)) return law->value_per_um == 0;
    return std::get<Spectrum>(coefficient).max() == 0;
}

}  // namespace fluovox
