#pragma once

#include "fluovox/medium/coefficient.h"
#include "fluovox/spectral/spectrum.h"

#include <optional>
#include <string_view>
#include <vector>

namespace fluovox {

/// Natural absorption of pure water, 1/um, 300 to 1000 nm (0 outside). Segelstein 1981; below about 500 nm newer
/// measurements are several times lower, which matters only over metres.
double water_absorption_per_um(double wavelength_nm);

/// Refractive index of water at 20 C, 300 to 1000 nm (the nearest end outside). Daimon and Masumura,
/// Appl. Opt. 46 (2007) 3811.
double water_refractive_index(double wavelength_nm);

/// Decadic molar extinction of haemoglobin, 1/(M cm) of the tetramer (64500 g/mol), 250 to 1000 nm. S. Prahl, Oregon
/// Medical Laser Center.
const Spectrum& oxyhaemoglobin_per_M_cm();
const Spectrum& deoxyhaemoglobin_per_M_cm();

/// Natural absorption of whole blood, 1/um: ln(10) eps x / 64500 with x grams of haemoglobin per litre of which the
/// share `saturation` carries oxygen. Prahl, as above.
double blood_absorption_per_um(double wavelength_nm, double saturation, double haemoglobin_g_per_L = 150);

/// The scattering of a tissue as its literature gives it.
struct TissueScattering {
    std::string_view name;  ///< "brain"
    PowerLaw reduced;       ///< mu_s' = mu_s (1 - g)
    std::string_view source;
};

/// The tissues known, by name.
const std::vector<TissueScattering>& tissues();

/// Reduced scattering coefficient mu_s' of a tissue, without regard to case; nothing for an unknown name.
std::optional<PowerLaw> tissue_scattering(std::string_view name);

/// mu_s = mu_s' / (1 - g), for a phase function of anisotropy `g` below 1.
PowerLaw scattering_from_reduced(const PowerLaw& reduced, double g);

}  // namespace fluovox
