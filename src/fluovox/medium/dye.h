#pragma once

#include "fluovox/spectral/lanes.h"
#include "fluovox/spectral/spectrum.h"

#include <string>

namespace fluovox {

/// One fluorophore: what it absorbs and what it gives back, per unit concentration.
///
/// Kasha's rule is assumed: the shape of the emission doesn't depend on the wavelength absorbed.
struct Dye {
    std::string id;                      ///< short name in lower case, "egfp"
    std::string name;                    ///< as people write it, "EGFP"
    Spectrum molar_absorption_per_M_cm;  ///< decadic, epsilon(lambda)
    Spectrum emission_per_nm;            ///< photons; integrates to one
    double quantum_yield = 0;            ///< photons out per photon in, 0 to 1
    std::string kind;                    ///< "fluorescent protein", "organic dye" ...; may be empty
    std::string source;                  ///< where the numbers come from
    std::string licence;                 ///< terms of the data
    std::string note;                    ///< what to know before trusting the numbers; may be empty
};

/// Absorption coefficient (natural, per micrometre) of `dye` at a concentration of 1 umol/L.
///
/// mu = ln(10) * epsilon * c, with epsilon in 1/(M cm) and 1 cm = 10^4 um.
/// IUPAC Gold Book, "Beer-Lambert law", doi:10.1351/goldbook.B00626.
double absorption_per_um_per_uM(const Dye& dye, double wavelength_nm);
Lanes absorption_per_um_per_uM(const Dye& dye, const Lanes& wavelengths_nm);

}  // namespace fluovox
