#include "fluovox/medium/dye.h"

#include <numbers>

namespace fluovox {

namespace {

constexpr double kCm_per_um = 1e-4, kMol_per_umol = 1e-6;

}  // namespace

double absorption_per_um_per_uM(const Dye& dye, double wavelength_nm) {
    return std::numbers::ln10 * dye.molar_absorption_per_M_cm(wavelength_nm) * kMol_per_umol * kCm_per_um;
}

Lanes absorption_per_um_per_uM(const Dye& dye, const Lanes& wavelengths_nm) {
    return kCm_per_um * (kMol_per_umol * (std::numbers::ln10 * dye.molar_absorption_per_M_cm(wavelengths_nm)));
}

}  // namespace fluovox
