#pragma once

#include "fluovox/spectral/spectrum.h"

#include <array>

namespace fluovox {

/// CIE 1931 tristimulus values (2 degree observer).
struct Xyz {
    double x = 0, y = 0, z = 0;
};

/// Red, green, blue with the primaries and the white (D65) of sRGB; linear unless said otherwise.
struct Rgb {
    double r = 0, g = 0, b = 0;

    constexpr bool operator==(const Rgb&) const = default;
};

/// Colour matching functions at a wavelength; zero outside 360 to 830 nm.
Xyz cie_1931(double wavelength_nm);

/// Tristimulus values of a spectral power distribution (per nm): integrals with the colour matching functions,
/// without the factor 683 lm/W.
Xyz to_xyz(const Spectrum& power_per_nm);

/// Linear sRGB; out-of-gamut colours have negative components. IEC 61966-2-1:1999.
Rgb linear_srgb(const Xyz& color);

/// The same colour with no negative component, at the same luminance: as much white as needed is mixed in. Light with
/// y > 0 stays visible. Colours of no light are black.
Rgb into_gamut(const Rgb& linear);

/// sRGB's transfer function: linear 0..1 to encoded 0..1, clamped. IEC 61966-2-1:1999.
double srgb_encoded(double linear);

/// The inverse of `srgb_encoded`, for 0..1.
double srgb_decoded(double encoded);

/// A saturated display colour (encoded sRGB, 0..1) that stands for a wavelength in plots: the hue of its
/// light, at full strength in the visible, dimmed towards and beyond its ends, never black.
Rgb display_color(double wavelength_nm);

}  // namespace fluovox
