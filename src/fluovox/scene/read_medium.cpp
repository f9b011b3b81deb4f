#include "fluovox/core/text.h"
#include "fluovox/medium/dye_library.h"
#include "fluovox/scene/read_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <set>
#include <stdexcept>

namespace fluovox {
namespace {

// A unit ("uM"), or an amount of it ("8 nm"), as one number in the dimension's own unit.
double read_unit(const SceneTable& table, std::string_view key, Dimension dimension) {
    std::string text = table.text(key);
    const bool has_number = !text.empty() && (std::isdigit(static_cast<unsigned char>(text[0])) != 0 || text[0] == '.');
    try {
        const double size = parse_quantity(has_number ? text : "1 " + text, dimension);
        if (size > 0) return size;
    } catch (const std::invalid_argument&) {  // NOLINT(bugprone-empty-catch): the complaint below knows the key
    }
    table.fail(key, fmt::format("must be a unit of {}, for example \"{}\"", dimension_name(dimension),
                                example_quantity(dimension, 1).substr(2)));
}

SlabRegion read_slab(const SceneTable& slab) {
    slab.allow_only({"axis", "min", "max"});
    SlabRegion region;
    region.axis = static_cast<int>(slab.choice("axis", {"x", "y", "z"}));
    if (!slab.has("min") && !slab.has("max")) slab.fail("needs min or max, or both");
    region.min = slab.quantity_or("min", Dimension::Length, -std::numeric_limits<double>::infinity());
    region.max = slab.quantity_or("max", Dimension::Length, std::numeric_limits<double>::infinity());
    if (!(region.min < region.max)) slab.fail("max", "must be above min");
    return region;
}

BoxRegion read_box(const SceneTable& box) {
    box.allow_only({"min", "max"});
    const BoxRegion region = {box.point("min"), box.point("max")};
    for (int axis = 0; axis < 3; ++axis) {
        if (!(region.min[axis] < region.max[axis])) {
            box.fail("max", fmt::format("must be above min along {}", "xyz"[axis]));
        }
    }
    return region;
}

CylinderRegion read_cylinder(const SceneTable& cylinder) {
    cylinder.allow_only({"from", "to", "radius"});
    const CylinderRegion region = {cylinder.point("from"), cylinder.point("to"),
                                   cylinder.quantity("radius", Dimension::Length, NumberRange::positive())};
    if (region.from == region.to) cylinder.fail("to", "must differ from from");
    return region;
}

GridReference read_grid(const SceneTable& medium, const ReadContext& context, bool is_dye) {
    if (medium.is_text("grid")) {
        medium.fail("grid",
                    "must be a table, for example grid = { file = " + std::string("\"") + medium.text("grid") + "\" }");
    }
    const SceneTable table = medium.table("grid");
    table.allow_only({"file", "name", "unit", "length_unit", "scale"});
    GridReference grid;
    grid.where = table.where();
    grid.file = resolve_path(table, "file", context);
    grid.written = table.text("file");
    grid.name = table.text_or("name", "");
    if (table.has("unit")) {
        if (!is_dye) {
            table.fail("unit",
                       "does not belong here: the grid of a host is a plain number that multiplies its "
                       "coefficients (scale does the same)");
        }
        grid.uM_per_value = read_unit(table, "unit", Dimension::Concentration);
    }
    if (table.has("length_unit")) grid.um_per_length = read_unit(table, "length_unit", Dimension::Length);
    grid.scale = table.number_or("scale", 1, NumberRange::not_negative());
    return grid;
}

DyeMatch read_dye(const SceneTable& medium, const ReadContext& context) {
    try {
        return resolve_dye(medium.text("dye"), context.folder, medium.where("dye"));
    } catch (const InputError& e) {
        throw InputError(medium.place("dye") + ": " + e.what());
    }
}

void read_dye_medium(const SceneTable& table, MediumDescription& medium, ReadContext& context) {
    for (const char* key : {"scattering", "absorption", "anisotropy", "phase_function"}) {
        if (table.has(key)) {
            table.fail(key, "does not belong to a dye: give the host a [[medium]] of its own; media add up");
        }
    }
    DyeMatch match = read_dye(table, context);
    if (!match.remark.empty()) context.remarks.push_back(table.path("dye") + ": " + match.remark);
    medium.name = match.dye.name;
    medium.dye = std::move(match.dye);
    if (table.has("grid")) {
        if (table.has("concentration")) {
            table.fail("concentration",
                       "does not go with grid, whose values are the concentrations; "
                       "grid.scale multiplies them");
        }
        return;
    }
    if (!table.has("region")) table.fail("needs grid = { file = ... } or region = ... with concentration");
    if (!table.has("concentration"))
        table.fail("concentration",
                   "is missing: a dye in a region needs one, for example "
                   "\"10 uM\"");
    constexpr double kAbsurd_uM = 1e5;
    constexpr double kImpossible_uM = 1e9;  // denser than any matter
    medium.concentration_uM = table.quantity("concentration", Dimension::Concentration, NumberRange::not_negative());
    if (medium.concentration_uM > kImpossible_uM) table.fail("concentration", "is denser than any matter");
    if (medium.concentration_uM > kAbsurd_uM) {
        context.warnings.push_back(
            fmt::format("{} = \"{}\" is more than 0.1 mol/L, which dyes hardly reach: is the unit right?",
                        table.path("concentration"), table.text("concentration")));
    }
}

void read_host_medium(const SceneTable& table, MediumDescription& medium, ReadContext& context) {
    if (table.has("concentration")) table.fail("concentration", "does not belong to a host, which has no dye");
    const bool has_coefficient = table.has("scattering") || table.has("absorption");
    if (!has_coefficient && !table.has("refractive_index")) {
        table.fail(
            "is neither a dye nor a host: it needs dye = \"EGFP\", or scattering = \"20 /mm\" and/or "
            "absorption = \"0.02 /mm\"");
    }
    medium.scattering = read_coefficient(table, "scattering", context);
    medium.absorption = read_coefficient(table, "absorption", context);
    medium.phase = read_phase(table, context);
    if (!table.has("grid") && !table.has("region")) {
        table.fail("region", "is missing: it says where the medium is (region = \"everywhere\" for all space)");
    }
}

MediumDescription read_medium(const SceneTable& table, ReadContext& context) {
    table.allow_only({"dye", "grid", "concentration", "region", "scattering", "absorption", "anisotropy",
                      "phase_function", "name", "refractive_index", "exclusive"});
    MediumDescription medium;
    medium.where = table.where();
    if (table.has("grid") && table.has("region")) table.fail("region", "and grid exclude each other: keep one");
    const bool is_dye = table.has("dye");
    if (is_dye) {
        read_dye_medium(table, medium, context);
    } else {
        read_host_medium(table, medium, context);
    }
    if (table.has("grid")) medium.grid = read_grid(table, context, is_dye);
    if (table.has("region")) medium.region = read_region(table);
    if (table.has("exclusive") && !table.has("region"))
        table.fail("exclusive", "is a property of a region, not of a grid");
    if (table.has("refractive_index")) medium.refractive_index = table.number("refractive_index", {.min = 1, .max = 5});
    medium.exclusive = table.flag_or("exclusive", false);
    return medium;
}

// Names end up in grids, layers and JSON keys, where a dot separates.
std::string read_name(const SceneTable& table) {
    std::string name = table.text("name");
    const auto bad = [](unsigned char c) { return c < ' ' || c == 0x7F || c == '.'; };
    if (name.empty() || std::any_of(name.begin(), name.end(), bad)) {
        table.fail("name", "must be a short text without dots and control characters");
    }
    return name;
}

double read_per_um(const SceneTable& table, std::string_view key) {
    constexpr double kImpossible_per_um = 1000;  // once in a nanometre, the size of a molecule
    const double per_um = table.quantity(key, Dimension::PerLength, NumberRange::not_negative());
    if (per_um > kImpossible_per_um) table.fail(key, "is more than matter can do: it must be 1000 /um or less");
    return per_um;
}

}  // namespace

Region read_region(const SceneTable& medium) {
    constexpr const char* kCure =
        "must be \"everywhere\" or one of { box = ... }, { sphere = ... }, { cylinder = ... }, { slab = ... }";
    if (medium.is_text("region")) {
        if (medium.text("region") != "everywhere") medium.fail("region", kCure);
        return Everywhere{};
    }
    if (!medium.is_table("region")) medium.fail("region", kCure);
    const SceneTable region = medium.table("region");
    region.allow_only({"box", "sphere", "cylinder", "slab"});
    constexpr std::array kShapes = {"box", "sphere", "cylinder", "slab"};
    if (std::count_if(kShapes.begin(), kShapes.end(), [&](const char* key) { return region.has(key); }) != 1) {
        region.fail(kCure);
    }
    if (region.has("box")) return read_box(region.table("box"));
    if (region.has("cylinder")) return read_cylinder(region.table("cylinder"));
    if (region.has("slab")) return read_slab(region.table("slab"));
    const SceneTable sphere = region.table("sphere");
    sphere.allow_only({"center", "radius"});
    return SphereRegion{sphere.point("center"), sphere.quantity("radius", Dimension::Length, NumberRange::positive())};
}

Coefficient read_coefficient(const SceneTable& medium, std::string_view key, const ReadContext& context) {
    if (!medium.has(key)) return 0.0;
    if (!medium.is_table(key)) return read_per_um(medium, key);
    const SceneTable table = medium.table(key);
    if (table.has("file")) {
        table.allow_only({"file", "unit"});
        if (!table.has("unit")) table.fail("unit", "is missing: the unit of the values, for example \"/cm\"");
        const double per_um = read_unit(table, "unit", Dimension::PerLength);
        return load_table(table, "file", context, NumberRange::not_negative()).scaled(per_um);
    }
    if (table.has("table")) {
        table.allow_only({"table", "unit"});
        return read_numbers(table, NumberRange::not_negative()).scaled(read_unit(table, "unit", Dimension::PerLength));
    }
    table.allow_only({"at", "value", "exponent", "file", "table", "unit"});
    return PowerLaw{.at_nm = table.quantity("at", Dimension::Wavelength, kWavelengthRange_nm),
                    .value_per_um = read_per_um(table, "value"),
                    .exponent = table.number("exponent", {.min = -20, .max = 20})};
}

std::vector<MediumDescription> read_media(const SceneTable& root, ReadContext& context) {
    std::vector<MediumDescription> media;
    std::set<std::string> given;
    int hosts = 0;
    for (const SceneTable& table : root.tables("medium")) {
        media.push_back(read_medium(table, context));
        MediumDescription& medium = media.back();
        if (!medium.dye) medium.name = fmt::format("host{}", ++hosts);
        if (!table.has("name")) continue;
        medium.name = read_name(table);
        if (!given.insert(medium.name).second) table.fail("name", "is the name of an earlier medium");
    }
    return media;
}

}  // namespace fluovox
