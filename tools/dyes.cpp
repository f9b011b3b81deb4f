#include "fluovox/core/text.h"
#include "fluovox/image/plot.h"
#include "fluovox/medium/dye_library.h"
#include "fluovox/medium/tissue.h"

#include "commands.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace fluovox::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples =
    "  fluovox dyes                        # the dyes built in\n"
    "  fluovox dyes EGFP                   # one dye: numbers, peaks, source, terms\n"
    "  fluovox dyes EGFP -o egfp.svg       # and its excitation and emission spectra (SVG or PNG)\n"
    "  fluovox dyes mydye.toml --json      # a dye file of your own, with its curves, for machines\n"
    "  fluovox dyes --tissues              # scattering and absorption of tissue, blood, water\n"
    "  fluovox dyes --licences             # where the numbers come from, and their terms\n";

void print(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
}

Json numbers(const Dye& dye) {
    return {{"id", dye.id},
            {"name", dye.name},
            {"kind", dye.kind},
            {"excitation_peak_nm", dye.molar_absorption_per_M_cm.peak_nm()},
            {"emission_peak_nm", dye.emission_per_nm.peak_nm()},
            {"extinction_per_M_cm", dye.molar_absorption_per_M_cm.max()},
            {"quantum_yield", dye.quantum_yield},
            {"source", dye.source},
            {"licence", dye.licence},
            {"note", dye.note}};
}

void list_dyes(bool json) {
    if (json) {
        Json list = Json::array();
        for (const Dye& dye : dye_library())
            list.push_back(numbers(dye));
        print(Json{{"dyes", list}, {"aliases", {{"GFP", "egfp"}, {"RFP", "dsred"}}}}.dump(2) + '\n');
        return;
    }
    print(fmt::format("{:<17} {:<10} {:>10} {:>8} {:>10} {:>5}   {}\n", "name", "id", "excitation", "emission",
                      "extinction", "yield", "kind"));
    print(fmt::format("{:<17} {:<10} {:>10} {:>8} {:>10}\n", "", "", "peak, nm", "peak, nm", "/M/cm"));
    for (const Dye& dye : dye_library()) {
        print(fmt::format("{:<17} {:<10} {:>10.0f} {:>8.0f} {:>10.0f} {:>5.2f}   {}\n", dye.name, dye.id,
                          dye.molar_absorption_per_M_cm.peak_nm(), dye.emission_per_nm.peak_nm(),
                          dye.molar_absorption_per_M_cm.max(), dye.quantum_yield, dye.kind));
    }
    print(
        "\nNames match without regard to case, spaces and dashes. \"GFP\" stands for EGFP, \"RFP\" for DsRed.\n"
        "fluovox dyes NAME shows one dye, fluovox dyes NAME -o NAME.svg plots it. The path of a dye file works as "
        "well:\n"
        "30 more dyes, under terms of their own, are the files dyes-optional/*.toml (in data/ of the sources, in\n"
        "share/fluovox/ when installed).\n");
}

std::string wrapped(const std::string& text, std::size_t indent) {
    constexpr std::size_t kWidth = 100;
    std::string result;
    std::size_t column = indent;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(' ', begin), text.size());
        const std::size_t length = end - begin;
        if (column > indent && column + 1 + length > kWidth) {
            result += '\n' + std::string(indent, ' ');
            column = indent;
        } else if (column > indent) {
            result += ' ';
            ++column;
        }
        result.append(text, begin, length);
        column += length;
        begin = end + 1;
    }
    return result;
}

/// How strongly the usual laser lines excite the dye, in percent of its peak.
std::string at_laser_lines(const Dye& dye) {
    std::string text;
    for (const int line_nm : {405, 445, 458, 473, 488, 514, 532, 561, 594, 633, 640, 685, 730}) {
        const double share = dye.molar_absorption_per_M_cm(line_nm) / dye.molar_absorption_per_M_cm.max();
        if (share >= 0.005) text += fmt::format("{}{} nm {:.0f} %", text.empty() ? "" : ", ", line_nm, 100 * share);
    }
    return text.empty() ? "none of the usual lines above 0.5 % of the peak" : text;
}

void show_numbers(const Dye& dye) {
    constexpr double kPerMm = 1e3;
    const Spectrum& absorption = dye.molar_absorption_per_M_cm;
    const Spectrum& emission = dye.emission_per_nm;
    const auto row = [](const char* label, const std::string& value) {
        if (!value.empty()) print(fmt::format("  {:<16} {}\n", label, wrapped(value, 19)));
    };
    print(fmt::format("{} ({}){}{}\n", dye.name, dye.id, dye.kind.empty() ? "" : ", ", dye.kind));
    row("excitation peak", fmt::format("{:.0f} nm", absorption.peak_nm()));
    row("emission peak", fmt::format("{:.0f} nm", emission.peak_nm()));
    row("extinction", fmt::format("{:.0f} /M/cm at {:.0f} nm (decadic)", absorption.max(), absorption.peak_nm()));
    row("quantum yield", fmt::format("{:.2f} photons out per photon absorbed", dye.quantum_yield));
    row("absorption", fmt::format("{:.4g} /mm (natural) at {:.0f} nm and 1 uM",
                                  kPerMm * absorption_per_um_per_uM(dye, absorption.peak_nm()), absorption.peak_nm()));
    row("laser lines", at_laser_lines(dye));
    row("tables", fmt::format("excitation {:.0f} to {:.0f} nm, emission {:.0f} to {:.0f} nm; zero outside",
                              absorption.first_nm(), absorption.last_nm(), emission.first_nm(), emission.last_nm()));
    row("source", dye.source);
    row("licence", dye.licence);
    row("note", dye.note);
}

void show_json(const DyeMatch& match) {
    Json json = numbers(match.dye);
    json["remark"] = match.remark;
    json["excitation"] = {{"wavelength_nm", match.dye.molar_absorption_per_M_cm.wavelengths_nm()},
                          {"molar_absorption_per_M_cm", match.dye.molar_absorption_per_M_cm.values()}};
    json["emission"] = {{"wavelength_nm", match.dye.emission_per_nm.wavelengths_nm()},
                        {"photons_per_nm", match.dye.emission_per_nm.values()}};
    print(json.dump(2) + '\n');
}

/// A line colour that reads on white: the wavelength's own, darkened.
Rgb line_color(double wavelength_nm) {
    const Rgb color = display_color(wavelength_nm);
    const double luminance = 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b;
    const double scale = std::min(1.0, 0.42 / std::max(luminance, 1e-3));
    return {scale * color.r, scale * color.g, scale * color.b};
}

PlotCurve relative_curve(const Spectrum& spectrum, const char* label) {
    PlotCurve curve{label, spectrum.wavelengths_nm(), spectrum.scaled(1 / spectrum.max()).values()};
    curve.color = line_color(spectrum.peak_nm());
    curve.filled = true;
    return curve;
}

PlotMark peak_mark(const Spectrum& spectrum, PlotMark::Side side) {
    return {spectrum.peak_nm(), 1, fmt::format("{:.0f} nm", spectrum.peak_nm()), side, line_color(spectrum.peak_nm())};
}

Plot make_plot(const Dye& dye) {
    Plot plot;
    plot.title = dye.name;
    plot.subtitle = fmt::format("extinction {:.0f} /M/cm, quantum yield {:.2f}", dye.molar_absorption_per_M_cm.max(),
                                dye.quantum_yield);
    plot.x_label = "wavelength (nm)";
    plot.y_label = "relative to the peak";
    plot.x_is_wavelength = true;
    plot.y_range = {0, 1.1};
    plot.curves = {relative_curve(dye.molar_absorption_per_M_cm, "excitation"),
                   relative_curve(dye.emission_per_nm, "emission (photons)")};
    plot.curves.front().dashed = true;
    plot.marks = {peak_mark(dye.molar_absorption_per_M_cm, PlotMark::Side::Left),
                  peak_mark(dye.emission_per_nm, PlotMark::Side::Right)};
    return plot;
}

void show_dye(const CommandLine& line, const std::string& name) {
    const DyeMatch match = resolve_dye(name, {}, {"fluovox dyes", 0, 0});
    const bool plots = line.values().count("output") > 0;
    const std::string output = plots ? line.values()["output"].as<std::string>() : std::string();
    if (plots && !is_plot_path(output)) line.fail("-o " + output + ": a plot's name must end in .svg or .png");
    if (plots) save_plot(make_plot(match.dye), output);
    if (line.common().json) return show_json(match);
    if (!match.remark.empty()) print("Note: " + match.remark + '\n');
    show_numbers(match.dye);
    if (plots) print("Wrote " + output + '\n');
}

constexpr std::array<double, 7> kShown_nm = {400, 450, 500, 550, 600, 650, 700};
constexpr double kPerCm_per_um = 1e4;

std::string absorption_row(const char* name, double (*per_um)(double)) {
    std::string row = fmt::format("{:<22}", name);
    for (const double nm : kShown_nm)
        row += fmt::format(" {:>8.3g}", kPerCm_per_um * per_um(nm));
    return row + '\n';
}

double arterial_per_um(double nm) {
    return blood_absorption_per_um(nm, 1);
}
double venous_per_um(double nm) {
    return blood_absorption_per_um(nm, 0);
}

void list_tissues() {
    std::string header = fmt::format("{:<22}", "wavelength, nm");
    for (const double nm : kShown_nm)
        header += fmt::format(" {:>8.0f}", nm);
    print("Reduced scattering mu_s' = mu_s (1 - g), /cm\n" + header + '\n');
    for (const TissueScattering& tissue : tissues()) {
        print(fmt::format("{:<22}", tissue.name));
        for (const double nm : kShown_nm)
            print(fmt::format(" {:>8.3g}", kPerCm_per_um * coefficient_per_um(tissue.reduced, nm)));
        print("\n");
    }
    print("\nAbsorption (natural), /cm\n" + header + '\n' + absorption_row("water", water_absorption_per_um) +
          absorption_row("blood, oxygenated", arterial_per_um) + absorption_row("blood, deoxygenated", venous_per_um));
    print("Blood: 150 g/L of haemoglobin. Tissue holds a few percent of blood.\n\nIn a scene, with g = 0.9:\n");
    for (const TissueScattering& tissue : tissues()) {
        const PowerLaw law = scattering_from_reduced(tissue.reduced, 0.9);
        print(fmt::format("  scattering = {{ at = \"{:.0f} nm\", value = \"{:.4g} /cm\", exponent = {} }}   # {}\n",
                          law.at_nm, kPerCm_per_um * law.value_per_um, law.exponent, tissue.name));
    }
    print("\nSources\n");
    for (const TissueScattering& tissue : tissues())
        print(fmt::format("  {:<6} {}\n", tissue.name, wrapped(std::string(tissue.source), 9)));
    print(
        "  water  Segelstein 1981, by refractiveindex.info (below 500 nm newer measurements are lower)\n"
        "  blood  S. Prahl, Oregon Medical Laser Center\n");
}

Json absorption_json(double (*per_um)(double)) {
    Json json;
    for (int nm = 300; nm <= 1000; nm += 2) {
        json["wavelength_nm"].push_back(nm);
        json["absorption_per_cm"].push_back(kPerCm_per_um * per_um(nm));
    }
    return json;
}

void list_tissues_json() {
    Json list = Json::array();
    for (const TissueScattering& tissue : tissues()) {
        list.push_back({{"name", tissue.name},
                        {"reduced_scattering_per_cm", kPerCm_per_um * tissue.reduced.value_per_um},
                        {"at_nm", tissue.reduced.at_nm},
                        {"exponent", tissue.reduced.exponent},
                        {"source", tissue.source}});
    }
    print(Json{{"tissues", list},
               {"water", absorption_json(water_absorption_per_um)},
               {"blood_oxygenated", absorption_json(arterial_per_um)},
               {"blood_deoxygenated", absorption_json(venous_per_um)}}
              .dump(2) +
          '\n');
}

}  // namespace

ExitCode run_dyes(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox dyes [NAME] [options]", kExamples);
    auto add = line.options().add_options();
    add("name", po::value<std::string>()->value_name("NAME"),
        "a dye's name, or the path of a dye file (first argument)");
    add("output,o", po::value<std::string>()->value_name("FILE"), "plot the dye's spectra into FILE (.svg or .png)");
    add("tissues", po::bool_switch(), "list the scattering and absorption of tissue, blood and water");
    add("licences", po::bool_switch(), "show sources and terms of all tables");
    line.positional("name", 1);
    if (!line.parse(arguments)) return ExitCode::Ok;

    const bool tissue_list = line.values()["tissues"].as<bool>();
    const bool licences = line.values()["licences"].as<bool>();
    const bool named = line.values().count("name") > 0;
    if (line.values().count("output") > 0 && !named) line.fail("-o needs the NAME of a dye to plot");
    if (static_cast<int>(tissue_list) + static_cast<int>(licences) + static_cast<int>(named) > 1) {
        line.fail("NAME, --tissues and --licences exclude each other");
    }
    if (licences) {
        print(std::string(data_licences()));
    } else if (tissue_list) {
        line.common().json ? list_tissues_json() : list_tissues();
    } else if (named) {
        show_dye(line, line.values()["name"].as<std::string>());
    } else {
        list_dyes(line.common().json);
    }
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
