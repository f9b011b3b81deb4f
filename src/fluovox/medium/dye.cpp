#include "fluovox/medium/dye.h"

#include <numbers>

namespace fluovox {

double absorption_per_um_per_uM(const Dye& dye, double wavelength_nm) {
    constexpr double cm_per_um = 1e-4;
    constexpr double mol_per_umol = 1e-6;
    return std::numbers::ln10 * dye.molar_absorption_per_M_cm(wavelength_nm) * mol_per_umol * cm_per_um;
}

}  // namespace fluovox
