#pragma once

#include "fluovox/core/vec.h"
#include "fluovox/transport/photon_space.h"

#include <cstdint>

namespace fluovox {

/// A packet of photons on its way from a light. Its weight is a share of the one photon launched.
struct Photon {
    Ray ray;
    double wavelength_nm = 0;
    double weight = 1;
    double start_weight = 1;  ///< when it was launched or re-emitted
    Inside inside = 0;
    int order = 0;                         ///< conversions so far
    int dye = -1;                          ///< that re-emitted it last
    std::int64_t scatterings = 0;          ///< since launched or re-emitted
    std::int64_t earlier_scatterings = 0;  ///< before
    bool from_outside = false;             ///< launched where there is no refractive index
    int refractions = 0;                   ///< refracting surfaces met since launched or re-emitted
    bool reflected = false;                ///< at the first of them
};

/// How a photon left.
enum class Escape { Specular, Ballistic, Scattered };

inline Escape escape_of(const Photon& photon) {
    if (photon.scatterings > 0) return Escape::Scattered;
    const bool specular = photon.order == 0 && photon.from_outside && photon.refractions == 1 && photon.reflected;
    return specular ? Escape::Specular : Escape::Ballistic;
}

/// A straight stretch on which constant media absorb evenly, or a point.
struct Flight {
    Ray ray;               ///< from its beginning
    double length_um = 0;  ///< may be infinite
    double weight = 0;     ///< at its beginning
    double lost = 0;       ///< of the weight, along it
    double absorption_per_um = 0;
};

/// Limits that keep a run bounded; what they cost is counted as cut.
struct PhotonLimits {
    std::int64_t scatterings = 1000000;
    bool scatterings_are_physical = false;  ///< asked for by the scene
    int orders = 1;
    /// What dyes absorb and give back is a small part of what is sought: no pains are taken over it.
    bool minor_conversions = false;
    double majorant_factor = 1;  ///< of the bounds of grids; above one only costs time
};

}  // namespace fluovox
