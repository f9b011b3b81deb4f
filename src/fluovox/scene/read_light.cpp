#include "fluovox/scene/read_scene.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace fluovox {
namespace {

// Vectors closer to parallel than this have no perpendicular part worth the name.
constexpr double kParallel = 1e-6;

/// `key` without its part along the unit vector `axis`, at unit length.
Vec3 read_perpendicular(const SceneTable& table, std::string_view key, Vec3 axis, const char* axis_name) {
    const Vec3 vector = table.direction(key);
    const Vec3 across = vector - dot(vector, axis) * axis;
    if (length(across) < kParallel) table.fail(key, fmt::format("must not be parallel to {}", axis_name));
    return normalized(across);
}

BeamProfile read_profile(const SceneTable& table) {
    if (!table.has("profile")) return BeamProfile::Gaussian;
    return table.choice("profile", {"gaussian", "box"}) == 0 ? BeamProfile::Gaussian : BeamProfile::Box;
}

/// The laser line of a light that needs one for its width.
double read_line_nm(const SceneTable& table) {
    if (!table.has("wavelength")) table.fail("wavelength", "is missing: the width of a focused light follows from it");
    return table.quantity("wavelength", Dimension::Wavelength, kWavelengthRange_nm);
}

/// The sine of the cone of a light whose waist has a half width `waist_um` (to 1/e^2), by one of the keys that say it.
/// Gaussian beams: w0 = wavelength / (pi NA), zR = pi w0^2 n / wavelength = w0 / tan(theta). Siegman, Lasers (1986),
/// chapter 17.
double read_cone(const SceneTable& table, double waist_um) {
    const int ways = static_cast<int>(table.has("numerical_aperture")) + static_cast<int>(table.has("rayleigh_range")) +
                     static_cast<int>(table.flag_or("diffraction", false));
    const double index = table.number_or("immersion_index", 1, {.min = 1, .max = 4});
    if (table.has("numerical_aperture") && ways == 1)
        return table.number("numerical_aperture", NumberRange::not_negative()) / index;
    if (ways == 0) return 0;
    if (ways > 1) table.fail("gives the cone twice: numerical_aperture, rayleigh_range or diffraction");
    if (!(waist_um > 0)) table.fail("needs a waist above 0 to have a Rayleigh range");
    if (table.has("rayleigh_range")) {
        const double range_um = table.quantity("rayleigh_range", Dimension::Length, NumberRange::positive());
        return waist_um / std::hypot(waist_um, range_um);
    }
    const double sine = 1e-3 * read_line_nm(table) / (std::numbers::pi * waist_um * index);
    if (sine >= 1) table.fail("diffraction", "cannot make a waist this thin: it is below wavelength / pi");
    return sine;
}

/// Half width of the waist that light of the table's wavelength has behind its numerical aperture.
double diffraction_waist_um(const SceneTable& table) {
    const double aperture = table.number("numerical_aperture", NumberRange::positive());
    return 1e-3 * read_line_nm(table) / (std::numbers::pi * aperture);
}

/// What sheets and beams share: how they are focused, `waist`, and how that goes with the profile.
template <class Focused>
void read_focusing(const SceneTable& table, Focused& light, double waist_um) {
    light.profile = read_profile(table);
    light.numerical_aperture = read_cone(table, waist_um);
    if (light.numerical_aperture > 0 && light.profile == BeamProfile::Box) {
        table.fail("profile", "does not go with numerical_aperture: a focused light is gaussian");
    }
    light.waist = table.has("waist") ? table.point("waist") : light.position;
}

SheetLight read_sheet(const SceneTable& table, ReadContext& context) {
    table.allow_only({"kind", "wavelength", "spectrum", "power", "position", "direction", "normal", "width",
                      "thickness", "profile", "two_sided", "numerical_aperture", "waist", "immersion_index",
                      "rayleigh_range", "diffraction", "pivot_deg"});
    SheetLight sheet;
    sheet.position = table.point("position");
    sheet.direction = table.direction("direction");
    sheet.normal = read_perpendicular(table, "normal", sheet.direction, "direction");
    sheet.width_um = table.quantity("width", Dimension::Length, NumberRange::not_negative());
    if (!table.has("thickness") && table.has("numerical_aperture")) {
        sheet.thickness_um = 2 * diffraction_waist_um(table);
    } else {
        sheet.thickness_um = table.quantity("thickness", Dimension::Length, NumberRange::not_negative());
    }
    sheet.two_sided = table.flag_or("two_sided", false);
    read_focusing(table, sheet, 0.5 * sheet.thickness_um);
    if (table.has("pivot_deg")) {
        sheet.pivots_rad = table.numbers("pivot_deg", {.min = -60, .max = 60});
        for (double& angle : sheet.pivots_rad)
            angle *= std::numbers::pi / 180;
    }
    if (table.has("waist") && sheet.numerical_aperture == 0 && !sheet.two_sided && sheet.pivots_rad.empty()) {
        table.fail("waist",
                   "does nothing to a collimated sheet: give numerical_aperture, rayleigh_range, two_sided or "
                   "pivot_deg as well");
    }
    if (sheet.two_sided && !table.has("waist")) {
        context.warnings.push_back(table.path() +
                                   ": a two-sided sheet is mirrored about its waist, which is its position here: "
                                   "set waist to the middle of the specimen");
    }
    return sheet;
}

BeamLight read_beam(const SceneTable& table) {
    table.allow_only({"kind", "wavelength", "spectrum", "power", "position", "direction", "radius", "profile",
                      "numerical_aperture", "waist", "immersion_index", "rayleigh_range", "diffraction", "scan"});
    BeamLight beam;
    beam.position = table.point("position");
    beam.direction = table.direction("direction");
    if (!table.has("radius") && table.has("numerical_aperture")) {
        beam.radius_um = diffraction_waist_um(table);
    } else {
        beam.radius_um = table.quantity("radius", Dimension::Length, NumberRange::not_negative());
    }
    read_focusing(table, beam, beam.radius_um);
    if (table.has("waist") && beam.numerical_aperture == 0) {
        table.fail("waist", "does nothing to a collimated beam: give numerical_aperture as well");
    }
    return beam;
}

/// The sheet that a beam draws while it is scanned: its average over time. The beam's cone in the plane of the sheet,
/// and the sheet's edges (soft over a beam's width), are left out.
SheetLight scanned(const SceneTable& table, const BeamLight& beam) {
    const SceneTable scan = table.table("scan");
    scan.allow_only({"along", "width"});
    if (beam.profile != BeamProfile::Gaussian) table.fail("profile", "must be gaussian where the beam is scanned");
    SheetLight sheet;
    sheet.position = beam.position;
    sheet.direction = beam.direction;
    sheet.normal = cross(beam.direction, read_perpendicular(scan, "along", beam.direction, "direction"));
    sheet.width_um = scan.quantity("width", Dimension::Length, NumberRange::positive());
    sheet.thickness_um = 2 * beam.radius_um;
    sheet.numerical_aperture = beam.numerical_aperture;
    sheet.waist = beam.waist;
    return sheet;
}

PointLight read_point(const SceneTable& table) {
    table.allow_only({"kind", "wavelength", "spectrum", "power", "position"});
    return {table.point("position")};
}

RectangleLight read_rectangle(const SceneTable& table) {
    table.allow_only({"kind", "wavelength", "spectrum", "power", "center", "normal", "up", "size"});
    RectangleLight light;
    light.center = table.point("center");
    light.normal = table.direction("normal");
    light.up = read_perpendicular(table, "up", light.normal, "normal");
    const std::vector<double> size = table.quantities("size", Dimension::Length, 2, NumberRange::positive());
    light.width_um = size[0];
    light.height_um = size[1];
    return light;
}

UniformLight read_uniform(const SceneTable& table) {
    if (table.has("power")) table.fail("power", "does not belong to a uniform light: it has radiance instead");
    table.allow_only({"kind", "wavelength", "spectrum", "radiance"});
    return {table.quantity("radiance", Dimension::Radiance, NumberRange::positive())};
}

/// `table_is` said by a comment line of the lamp file itself; empty when there is none.
std::string table_is_of(const std::string& text) {
    constexpr std::string_view kKey = "table_is";
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        const std::string line = text.substr(begin, end - begin);
        begin = end + 1;
        const std::size_t key = line.find(kKey);
        if (key == std::string::npos || line.find_first_not_of(" \t") != line.find('#')) continue;
        std::string value;
        for (const char c : line.substr(key + kKey.size())) {
            if (std::isalpha(static_cast<unsigned char>(c)) != 0) value += c;
        }
        return value;
    }
    return {};
}

Spectrum read_lamp(const SceneTable& table, const ReadContext& context) {
    table.allow_only({"file", "table_is"});
    std::string text;
    const Spectrum lamp = load_table(table, "file", context, NumberRange::not_negative(), &text);
    std::string table_is = table_is_of(text);
    if (table.has("table_is")) table_is = table.choice("table_is", {"energy", "photons"}) == 0 ? "energy" : "photons";
    if (table_is != "energy" && table_is != "photons") {
        table.fail("table_is",
                   "is missing: say table_is = \"energy\" (power per nm) or \"photons\" (photons per nm), "
                   "here or in a line \"# table_is = energy\" of the file");
    }
    std::vector<double> values = lamp.values();
    if (table_is == "photons") {
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] /= lamp.wavelengths_nm()[i];  // a photon's energy is h c / wavelength
    }
    const Spectrum energy(lamp.wavelengths_nm(), std::move(values));
    if (!(energy.integral() > 0)) table.fail("file", "has no light in it: all its values are 0");
    return energy.scaled(1 / energy.integral());
}

LightSpectrum read_spectrum(const SceneTable& table, const ReadContext& context) {
    LightSpectrum spectrum;
    if (table.has("wavelength") == table.has("spectrum")) {
        table.fail(
            "needs either wavelength = \"488 nm\" (a laser line) or spectrum = { from = ..., to = ... } or "
            "{ file = ... }");
    }
    if (table.has("wavelength")) {
        spectrum.lines = {{table.quantity("wavelength", Dimension::Wavelength, kWavelengthRange_nm), 1}};
        return spectrum;
    }
    const SceneTable given = table.table("spectrum");
    if (given.has("file")) {
        spectrum.energy_per_nm = read_lamp(given, context);
        return spectrum;
    }
    if (given.has("table")) {
        given.allow_only({"table"});
        const Spectrum energy = read_numbers(given, NumberRange::not_negative());
        if (!(energy.integral() > 0)) given.fail("table", "has no light in it: all its values are 0");
        // What is to scale already, to rounding, is kept as it is: the same scene again.
        constexpr double kRounding = 1e-12;
        const bool to_scale = std::abs(energy.integral() - 1) < kRounding;
        spectrum.energy_per_nm = to_scale ? energy : energy.scaled(1 / energy.integral());
        return spectrum;
    }
    given.allow_only({"from", "to", "center", "width", "file", "table_is", "table"});
    if (given.has("table_is")) given.fail("table_is", "goes with file only: a band is flat in power per nm");
    const Band band = read_band(given);
    spectrum.energy_per_nm = Spectrum::box(band.from_nm, band.to_nm, 1 / (band.to_nm - band.from_nm));
    return spectrum;
}

LightDescription read_light(const SceneTable& table, ReadContext& context) {
    LightDescription result;
    result.where = table.where();
    if (!table.has("kind")) table.fail("kind", "is missing: sheet, beam, point, rectangle or uniform");
    switch (table.choice("kind", {"sheet", "beam", "point", "rectangle", "uniform"})) {
        case 0:
            result.light.shape = read_sheet(table, context);
            break;
        case 1:
            result.light.shape = read_beam(table);
            if (table.has("scan")) result.light.shape = scanned(table, read_beam(table));
            break;
        case 2:
            result.light.shape = read_point(table);
            break;
        case 3:
            result.light.shape = read_rectangle(table);
            break;
        default:
            result.light.shape = read_uniform(table);
    }
    result.light.spectrum = read_spectrum(table, context);
    const bool is_uniform = std::holds_alternative<UniformLight>(result.light.shape);
    if (!is_uniform) result.light.power_W = table.quantity("power", Dimension::Power, NumberRange::positive());
    return result;
}

}  // namespace

std::vector<LightDescription> read_lights(const SceneTable& root, ReadContext& context) {
    std::vector<LightDescription> lights;
    for (const SceneTable& table : root.tables("light"))
        lights.push_back(read_light(table, context));
    return lights;
}

}  // namespace fluovox
