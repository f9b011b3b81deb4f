#include "fluovox/spectral/color.h"

#include "fluovox/core/csv.h"
#include "fluovox/core/embedded_text.h"

#include <algorithm>
#include <cmath>

namespace fluovox {
namespace {

struct Observer {
    Spectrum x, y, z;
};

const Observer& standard_observer() {
    static const Observer observer = [] {
        constexpr const char* kTable = "spectral/data/cie1931_2deg.csv";
        const CsvTable table = parse_csv(embedded_text(kTable), kTable);
        const auto& nm = table.column("wavelength_nm");
        return Observer{{nm, table.column("x")}, {nm, table.column("y")}, {nm, table.column("z")}};
    }();
    return observer;
}

double luminance(const Rgb& c) {
    return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
}

}  // namespace

Xyz cie_1931(double wavelength_nm) {
    const Observer& eye = standard_observer();
    return {eye.x(wavelength_nm), eye.y(wavelength_nm), eye.z(wavelength_nm)};
}

Xyz to_xyz(const Spectrum& power_per_nm) {
    const Observer& eye = standard_observer();
    return {integral_of_product(power_per_nm, eye.x), integral_of_product(power_per_nm, eye.y),
            integral_of_product(power_per_nm, eye.z)};
}

Rgb linear_srgb(const Xyz& c) {
    return {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z, -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
            0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

Rgb into_gamut(const Rgb& linear) {
    const double lowest = std::min({linear.r, linear.g, linear.b});
    const double y = luminance(linear);
    if (lowest >= 0) return linear;
    if (!(y > 0)) return {};
    // On the way from the colour (0) to the grey of its luminance (1), where the lowest component gets to zero.
    const double share = lowest / (lowest - y);
    const auto mixed = [&](double component) { return std::max(0.0, component + share * (y - component)); };
    return {mixed(linear.r), mixed(linear.g), mixed(linear.b)};
}

double srgb_encoded(double linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double srgb_decoded(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Rgb display_color(double wavelength_nm) {
    // Beyond these the tables hold little but rounding, and the hue no longer changes.
    const Rgb linear = linear_srgb(cie_1931(std::clamp(wavelength_nm, 390.0, 730.0)));
    // Some of the white that would bring the colour into the gamut: all of it is pale, none makes one flat green.
    const double white = 0.2 * std::max(0.0, -std::min({linear.r, linear.g, linear.b}));
    const auto lifted = [&](double component) { return std::max(0.0, component + white); };
    const Rgb clipped = {lifted(linear.r), lifted(linear.g), lifted(linear.b)};
    const double strongest = std::max({clipped.r, clipped.g, clipped.b});
    constexpr double kDimmest = 0.25;
    const double inward_nm = std::min(wavelength_nm - 350, 780 - wavelength_nm);
    const double strength = std::clamp(inward_nm / 80, kDimmest, 1.0) / strongest;
    return {srgb_encoded(strength * clipped.r), srgb_encoded(strength * clipped.g), srgb_encoded(strength * clipped.b)};
}

}  // namespace fluovox
