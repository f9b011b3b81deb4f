#pragma once

namespace fluovox {

/// Planck's constant, J s. Exact by definition of the SI (BIPM, SI Brochure, 9th edition, 2019).
inline constexpr double kPlanck_J_s = 6.62607015e-34;
/// Speed of light in vacuum, m/s. Exact by definition of the SI.
inline constexpr double kLightSpeed_m_per_s = 299792458;
/// Avogadro's constant, 1/mol. Exact by definition of the SI.
inline constexpr double kAvogadro_per_mol = 6.02214076e23;

/// Energy of one photon, h c / lambda, in joules.
constexpr double photon_energy_J(double wavelength_nm) {
    return kPlanck_J_s * kLightSpeed_m_per_s / (wavelength_nm * 1e-9);
}

/// Photons per second that carry `power_W` at a wavelength.
constexpr double photons_per_second(double power_W, double wavelength_nm) {
    return power_W / photon_energy_J(wavelength_nm);
}

/// Power in watts of so many photons per second at a wavelength.
constexpr double power_W(double photons_per_s, double wavelength_nm) {
    return photons_per_s * photon_energy_J(wavelength_nm);
}

}  // namespace fluovox
