#include "fluovox/core/quantity.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

namespace fluovox {
namespace {

struct Unit {
    std::string_view name;
    double size;  // in the dimension's own unit
};

struct DimensionInfo {
    std::string_view name;
    std::string_view example_unit;
    std::span<const Unit> units;  // the first is the own unit
};

constexpr std::array kLengths = {Unit{"um", 1}, Unit{"nm", 1e-3}, Unit{"mm", 1e3}, Unit{"cm", 1e4}, Unit{"m", 1e6}};
constexpr std::array kWavelengths = {Unit{"nm", 1}, Unit{"um", 1e3}, Unit{"mm", 1e6}};
constexpr std::array kPowers = {Unit{"W", 1}, Unit{"mW", 1e-3}, Unit{"uW", 1e-6}, Unit{"nW", 1e-9}};
constexpr std::array kConcentrations = {
    Unit{"uM", 1},     Unit{"pM", 1e-6},   Unit{"nM", 1e-3},    Unit{"mM", 1e3},      Unit{"M", 1e6},
    Unit{"umol/L", 1}, Unit{"mol/L", 1e6}, Unit{"mmol/L", 1e3}, Unit{"nmol/L", 1e-3}, Unit{"pmol/L", 1e-6}};
constexpr std::array kCoefficients = {Unit{"/um", 1},   Unit{"/mm", 1e-3},   Unit{"/cm", 1e-4},   Unit{"/m", 1e-6},
                                      Unit{"um^-1", 1}, Unit{"mm^-1", 1e-3}, Unit{"cm^-1", 1e-4}, Unit{"m^-1", 1e-6}};
constexpr std::array kExtinctions = {Unit{"/M/cm", 1}, Unit{"M^-1 cm^-1", 1}};
constexpr std::array kRadiances = {Unit{"W/m2/sr", 1}, Unit{"W m^-2 sr^-1", 1}};
constexpr std::array kAngles = {Unit{"rad", 1}, Unit{"deg", std::numbers::pi / 180}};
constexpr std::array kTimes = {Unit{"s", 1}, Unit{"ms", 1e-3}, Unit{"us", 1e-6}};

DimensionInfo info(Dimension dimension) {
    switch (dimension) {
        case Dimension::Length:
            return {"length", "um", kLengths};
        case Dimension::Wavelength:
            return {"wavelength", "nm", kWavelengths};
        case Dimension::Power:
            return {"power", "mW", kPowers};
        case Dimension::Concentration:
            return {"concentration", "uM", kConcentrations};
        case Dimension::PerLength:
            return {"coefficient", "/mm", kCoefficients};
        case Dimension::Extinction:
            return {"extinction", "/M/cm", kExtinctions};
        case Dimension::Radiance:
            return {"radiance", "W/m2/sr", kRadiances};
        case Dimension::Angle:
            return {"angle", "deg", kAngles};
        case Dimension::Time:
            return {"time", "ms", kTimes};
    }
    return {};
}

// Spaces that text programs put between a number and its unit: blank, tab, the no-break spaces, the thin space.
constexpr std::array<std::string_view, 5> kSpaces = {" ", "\t", "\u00a0", "\u202f", "\u2009"};

std::string_view trimmed(std::string_view text) {
    const auto trim_once = [&text] {
        for (const std::string_view space : kSpaces) {
            if (text.starts_with(space)) return text.remove_prefix(space.size()), true;
            if (text.ends_with(space)) return text.remove_suffix(space.size()), true;
        }
        return false;
    };
    while (trim_once()) {
    }
    return text;
}

// The micro sign and the Greek letter are both written for u.
std::string with_plain_micro(std::string_view unit) {
    std::string plain(unit);
    for (const std::string_view micro : {"\u00b5", "\u03bc"}) {
        if (const auto at = plain.find(micro); at != std::string::npos) plain.replace(at, micro.size(), "u");
    }
    return plain;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
        text.replace(at, from.size(), to);
}

// As the tables above have it: "1/mm", "mm-1" and "mm\u207b\u00b9" are all "mm^-1" or "/mm".
std::string plain_unit(std::string_view unit) {
    std::string plain = with_plain_micro(unit);
    if (plain.starts_with("1/")) plain.erase(0, 1);
    replace_all(plain, "\u207b", "-");
    replace_all(plain, "\u00b9", "1");
    replace_all(plain, "\u00b2", "2");
    if (plain.find('^') == std::string::npos) replace_all(plain, "-", "^-");
    replace_all(plain, "\u00b7", " ");
    replace_all(plain, ".", " ");
    return plain;
}

// What dimension a unit belongs to, for "that is a power".
std::string_view dimension_of_unit(std::string_view unit) {
    for (const auto other : {Dimension::Length, Dimension::Power, Dimension::Concentration, Dimension::PerLength,
                             Dimension::Extinction, Dimension::Radiance, Dimension::Angle, Dimension::Time}) {
        for (const Unit& candidate : info(other).units) {
            if (candidate.name == unit) return info(other).name;
        }
    }
    return {};
}

std::string with_article(std::string_view noun) {
    const bool vowel = std::string_view("aeiou").find(noun.front()) != std::string_view::npos;
    return (vowel ? "an " : "a ") + std::string(noun);
}

std::string unit_list(const DimensionInfo& about, const std::string& separator) {
    std::string names;
    for (const Unit& unit : about.units) {
        names += (names.empty() ? "" : separator) + std::string(unit.name);
    }
    return names;
}

}  // namespace

double parse_quantity(std::string_view text, Dimension dimension) {
    const DimensionInfo about = info(dimension);
    const std::string_view body = trimmed(text);
    const std::string_view digits = !body.empty() && body.front() == '+' ? body.substr(1) : body;
    double number = 0;
    const auto [end, failure] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (failure != std::errc{} || !std::isfinite(number)) {
        throw std::invalid_argument(fmt::format("\"{}\" is not {}, for example \"{}\"", text, with_article(about.name),
                                                example_quantity(dimension, 5)));
    }
    const std::string_view rest = trimmed({end, static_cast<std::size_t>(digits.data() + digits.size() - end)});
    if (rest.empty()) {
        throw std::invalid_argument(
            fmt::format("{} needs a unit, for example \"{}\"", body, example_quantity(dimension, number)));
    }
    const std::string unit = plain_unit(rest);
    for (const Unit& known : about.units) {
        if (known.name != unit) continue;
        if (std::isfinite(number * known.size)) return number * known.size;
        throw std::invalid_argument(fmt::format("\"{}\" is too large", body));
    }
    const std::string_view other = dimension_of_unit(unit);
    const std::string what =
        other.empty() ? fmt::format("\"{}\" is not a unit of {}", rest, about.name)
                      : fmt::format("\"{}\" is {}, not {}", body, with_article(other), with_article(about.name));
    throw std::invalid_argument(what + " (its units: " + unit_list(about, " ") + ")");
}

std::string example_quantity(Dimension dimension, double number) {
    const std::string_view unit = info(dimension).example_unit;
    return fmt::format("{} {}", number, unit);
}

std::string_view dimension_name(Dimension dimension) {
    return info(dimension).name;
}

std::string unit_names(Dimension dimension) {
    return unit_list(info(dimension), ", ");
}

std::string format_quantity(double value, Dimension dimension) {
    return fmt::format("{} {}", value, info(dimension).units.front().name);
}

}  // namespace fluovox
