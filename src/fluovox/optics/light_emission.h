#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/optics/light.h"

namespace fluovox {

/// A ray as the light sends it out: every one stands for the same share of its photons. Sheets and beams start in the
/// plane through their position, rectangles on themselves; uniform light comes in through the faces of `around`.
Ray sample_emission(const Light& light, const Bounds& around, Rng& rng);

/// Photons per second that leave the light, over its whole spectrum; of uniform light those that come in through the
/// faces of `around` (infinite when that is).
double emitted_photons(const Light& light, const Bounds& around);

/// Wavelength of one of these photons.
double sample_emitted_wavelength(const Light& light, Rng& rng);

}  // namespace fluovox
