#include "voxelize_values.h"

#include "fluovox/medium/dye_library.h"

#include <fmt/format.h>

#include <cctype>
#include <stdexcept>

namespace fluovox::tools {

double quantity(const CommandLine& line, const std::string& option, const std::string& text, Dimension dimension) {
    try {
        return parse_quantity(text, dimension);
    } catch (const std::invalid_argument& e) {
        const bool whole = option.ends_with(text);
        line.fail(option + (whole ? "" : ' ' + text) + ": " + e.what());
    }
}

double positive_length(const CommandLine& line, const std::string& option, const std::string& text) {
    const double um = quantity(line, option, text, Dimension::Length);
    if (!(um > 0)) line.fail(option + ' ' + text + ": must be greater than zero");
    return um;
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == separator) {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

double mesh_unit(const CommandLine& line, const std::string& text) {
    const bool has_number = !text.empty() && (std::isdigit(static_cast<unsigned char>(text[0])) != 0 || text[0] == '.');
    double um = 0;
    try {
        um = parse_quantity(has_number ? text : "1" + text, Dimension::Length);
    } catch (const std::invalid_argument&) {
        line.fail("--mesh-unit: unknown unit \"" + text + "\"; one of " + unit_names(Dimension::Length) +
                  ", or a number of them such as 8nm");
    }
    if (!(um > 0)) line.fail("--mesh-unit " + text + ": must be greater than zero");
    return um;
}

Bounds box(const CommandLine& line, const std::string& option, const std::string& text) {
    const std::string said = option + ' ' + text;
    const std::vector<std::string> parts = split(text, ',');
    if (parts.size() != 6) line.fail(said + ": wants X0,Y0,Z0,X1,Y1,Z1, for example 0um,0um,0um,50um,50um,20um");
    Bounds bounds;
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        bounds.min[axis] = quantity(line, option, parts[i], Dimension::Length);
        bounds.max[axis] = quantity(line, option, parts[i + 3], Dimension::Length);
        if (!(bounds.min[axis] < bounds.max[axis])) line.fail(said + ": the box is empty");
    }
    return bounds;
}

DyeChoice choose_dye(const CommandLine& line, const std::string& option, const std::string& name,
                     const std::string& concentration, std::vector<std::string>& remarks) {
    DyeChoice choice;
    choice.concentration_uM = quantity(line, option, concentration, Dimension::Concentration);
    if (!(choice.concentration_uM > 0)) line.fail(option + ": the concentration must be greater than zero");
    if (const auto match = find_dye(name)) {
        choice.name = match->dye.name;
        if (!match->remark.empty()) remarks.push_back(match->remark);
    } else if (name.ends_with(".toml") || name.find('/') != std::string::npos) {
        choice.name = load_dye(name).name;
    } else {
        throw Error(ExitCode::Scene, option + ": " + unknown_dye_message(name));
    }
    constexpr double kImpossible_uM = 1e9;
    if (choice.concentration_uM > kImpossible_uM) line.fail(option + ": the concentration is denser than any matter");
    constexpr double kAbsurd_uM = 1e5;
    if (choice.concentration_uM > kAbsurd_uM) {
        remarks.push_back(
            fmt::format("warning: {} at {:g} mol/L is more than any dye dissolves; was a smaller unit meant?",
                        choice.name, choice.concentration_uM * 1e-6));
    }
    return choice;
}

DyeChoice parse_dye(const CommandLine& line, const std::string& text, std::vector<std::string>& remarks) {
    const auto equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
        line.fail("--dye " + text + ": wants NAME=CONCENTRATION, for example EGFP=5uM");
    }
    return choose_dye(line, "--dye " + text, text.substr(0, equals), text.substr(equals + 1), remarks);
}

}  // namespace fluovox::tools
