#include "fluovox/core/atomic_file.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/plot.h"
#include "fluovox/image/response.h"
#include "fluovox/medium/dye_library.h"

#include "commands.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iostream>

namespace fluovox::tools {
namespace {

constexpr const char* kUsage =
    "fluovox spectrum IMAGE.exr [--region x0,y0,x1,y1] [--dye NAME] [--layer NAME] [-o CSV] [--plot FILE]";
constexpr const char* kExamples =
    "  fluovox spectrum image.exr                              mean spectral response as CSV\n"
    "  fluovox spectrum image.exr --plot response.svg          a plot over the dye's emission spectrum\n"
    "  fluovox spectrum image.exr --region 10,10,20,20 -o a.csv    of the pixels 10 to 19 in x and y, row 0 on top\n"
    "  fluovox spectrum image.exr --layer elastic --dye none   scattered light instead of fluorescence\n"
    "\nThe last two columns are the integral over the film's range and its standard error, the same in every row: bins "
    "of\n"
    "one path are not independent, so their errors do not add up to it.\n"
    "\nThe distance between response and emission is the sum of |a - b| x bin width, both normalised to unit area "
    "over\n"
    "the film's range: 0 for equal shapes, 2 for no wavelength in common. An image in watts is compared with the\n"
    "emission as energy, one in photons with the emission as photons.\n";

/// A dye's emission as the film would see it.
struct Reference {
    Dye dye;
    std::vector<double> on_film;     // per bin
    std::optional<double> distance;  // nothing when there is no light
};

/// All that the command found out.
struct Findings {
    std::string image;
    std::string layer;
    PixelRegion region;
    FilmSpec film;
    SpectralResponse response;
    double bin_nm = 1;
    std::vector<Reference> references;
};

PixelRegion parse_region(const CommandLine& command, const RenderedImage& image) {
    if (command.values().count("region") == 0) return {0, 0, image.width, image.height};
    const auto text = command.values()["region"].as<std::string>();
    std::array<int, 4> v{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (std::size_t i = 0; i < v.size(); ++i) {
        const auto [next, error] = std::from_chars(at, end, v[i]);
        const bool last = i + 1 == v.size();
        if (error != std::errc() || (last ? next != end : next == end || *next != ',')) {
            command.fail("--region " + text + " must be four whole numbers x0,y0,x1,y1, for example 10,10,20,20");
        }
        at = next + (last ? 0 : 1);
    }
    const PixelRegion region{v[0], v[1], v[2], v[3]};
    if (region.x0 < 0 || region.y0 < 0 || region.x0 >= region.x1 || region.y0 >= region.y1 || region.x1 > image.width ||
        region.y1 > image.height) {
        command.fail(
            fmt::format("--region {} is empty or leaves the image of {} x {} pixels", text, image.width, image.height));
    }
    return region;
}

int chosen_layer(const CommandLine& command, const RenderedImage& image) {
    if (command.values().count("layer") == 0) {
        const int layer = image.display_layer();
        if (layer == 0 && image.layer(kFluorescenceLayer) >= 0 && !command.common().quiet)
            std::cerr << "fluovox: note: the image has no fluorescence; this is all of its light\n";
        return layer;
    }
    const auto name = command.values()["layer"].as<std::string>();
    const int layer = image.layer(name);
    if (layer < 0) {
        command.fail(fmt::format("the image has no layer \"{}\"; it has {}", name, fmt::join(image.layers, ", ")));
    }
    return layer;
}

Dye dye_of_option(const CommandLine& command, const std::string& name) {
    const bool is_file = std::filesystem::path(name).extension() == ".toml";
    if (is_file) return load_dye(name);
    auto found = find_dye(name);
    if (!found) command.fail(unknown_dye_message(name));
    if (!found->remark.empty() && !command.common().quiet) std::cerr << "fluovox: note: " << found->remark << '\n';
    return found->dye;
}

/// The dyes to compare with: those asked for, otherwise those of the scene (of the layer, where it is one dye's).
std::vector<Dye> chosen_dyes(const CommandLine& command, const RenderedImage& image, const std::string& layer) {
    std::vector<Dye> dyes;
    if (command.values().count("dye") > 0) {
        for (const auto& name : command.values()["dye"].as<std::vector<std::string>>()) {
            if (name != "none") dyes.push_back(dye_of_option(command, name));
        }
        return dyes;
    }
    if (layer == kElasticLayer) return dyes;
    const auto& names = image.provenance.dyes;
    const bool layer_is_dye = std::find(names.begin(), names.end(), layer) != names.end();
    for (const std::string& name : names) {
        if (layer_is_dye && name != layer) continue;
        if (auto found = find_dye(name)) {
            dyes.push_back(found->dye);
        } else if (!command.common().quiet) {
            std::cerr << "fluovox: note: the library has no dye \"" << name
                      << "\" of this scene; give its file with --dye\n";
        }
    }
    return dyes;
}

bool has_light(const SpectralResponse& response) {
    double sum = 0;
    for (const double value : response.mean)
        sum += value;
    return sum > 0;
}

Findings find_out(const CommandLine& command, const RenderedImage& image, const std::string& name) {
    Findings f;
    const int layer = chosen_layer(command, image);
    f.image = name;
    f.layer = image.layers[static_cast<std::size_t>(layer)];
    f.region = parse_region(command, image);
    f.film = image.film;
    f.response = mean_response(image, layer, f.region);
    if (!image.film.is_spectral) return f;
    f.bin_nm = (image.film.to_nm - image.film.from_nm) / image.channels();
    for (const Dye& dye : chosen_dyes(command, image, f.layer)) {
        Reference reference{dye, normalized(emission_on_film(dye.emission_per_nm, f.film), f.bin_nm), {}};
        if (has_light(f.response)) reference.distance = normalized_distance(f.response.mean, reference.on_film);
        f.references.push_back(std::move(reference));
    }
    return f;
}

std::string quoted(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string result = "\"";
    for (const char c : text)
        result += c == '"' ? std::string("\"\"") : std::string(1, c);
    return result + '"';
}

std::string watts_or_photons(const Findings& f) {
    return f.film.unit == FilmUnit::Photons ? "photons_per_s_m2_sr" : "W_per_m2_sr";
}

bool knows_error(const Findings& f) {
    return std::isfinite(f.response.standard_error_of_sum);
}

// The total is the same in every row: a table of plain columns is what programs read.
std::string to_csv(const Findings& f) {
    const bool spectral = f.film.is_spectral;
    const std::string unit = watts_or_photons(f) + (spectral ? "_nm" : "");
    std::string csv = (spectral ? "wavelength_nm" : "channel,center_nm") + fmt::format(",mean_{},standard_error", unit);
    if (spectral) csv += ",normalised_per_nm";
    for (const Reference& reference : f.references)
        csv += ',' + quoted(reference.dye.name + " emission_per_nm");
    if (spectral) csv += fmt::format(",total_{},total_standard_error", watts_or_photons(f));
    csv += '\n';
    const std::vector<double> shape = normalized(f.response.mean, f.bin_nm);
    for (std::size_t i = 0; i < f.response.mean.size(); ++i) {
        const FilmChannel& channel = f.film.channels[i];
        if (!spectral) csv += quoted(channel.name) + ',';
        csv += fmt::format("{:.9g},{:.9g},{:.4g}", channel.center_nm, f.response.mean[i], f.response.standard_error[i]);
        if (spectral) csv += fmt::format(",{:.9g}", shape[i]);
        for (const Reference& reference : f.references)
            csv += fmt::format(",{:.9g}", reference.on_film[i]);
        if (spectral)
            csv +=
                fmt::format(",{:.9g},{:.4g}", f.bin_nm * f.response.sum, f.bin_nm * f.response.standard_error_of_sum);
        csv += '\n';
    }
    return csv;
}

std::string to_json_text(const Findings& f) {
    nlohmann::ordered_json json = {{"image", f.image},
                                   {"layer", f.layer},
                                   {"region", {f.region.x0, f.region.y0, f.region.x1, f.region.y1}},
                                   {"unit", f.film.unit == FilmUnit::Photons ? "photons" : "watts"}};
    for (const FilmChannel& channel : f.film.channels) {
        if (!f.film.is_spectral) json["channel"].push_back(channel.name);
        json["wavelength_nm"].push_back(channel.center_nm);
    }
    json["mean"] = f.response.mean;
    json["standard_error"] = f.response.standard_error;
    if (!f.film.is_spectral) return json.dump(2) + '\n';
    json["total"] = f.bin_nm * f.response.sum;
    json["total_standard_error"] = f.bin_nm * f.response.standard_error_of_sum;
    json["normalised_per_nm"] = normalized(f.response.mean, f.bin_nm);
    json["distance_from_noise"] = distance_from_noise(f.response);
    json["dyes"] = nlohmann::ordered_json::array();
    for (const Reference& reference : f.references) {
        nlohmann::ordered_json dye = {{"name", reference.dye.name}, {"distance", nullptr}};
        if (reference.distance) dye["distance"] = *reference.distance;
        dye["emission_per_nm"] = reference.on_film;
        json["dyes"].push_back(std::move(dye));
    }
    return json.dump(2) + '\n';
}

std::string total_text(const Findings& f) {
    const std::string error = knows_error(f) ? fmt::format("{:.2g}", f.bin_nm * f.response.standard_error_of_sum)
                                             : "unknown (one sample per pixel)";
    return fmt::format("total from {:g} to {:g} nm: {:.6g} +- {} {}\n", f.film.from_nm, f.film.to_nm,
                       f.bin_nm * f.response.sum, error,
                       f.film.unit == FilmUnit::Photons ? "photons/s/m2/sr" : "W/m2/sr");
}

std::string distance_text(const Findings& f) {
    const std::string noise =
        knows_error(f) ? fmt::format("{:.4f}", distance_from_noise(f.response)) : "unknown, one sample per pixel";
    std::string text;
    for (const Reference& reference : f.references) {
        text += reference.distance
                    ? fmt::format("distance to the emission of {}: {:.4f} (noise alone: {})\n", reference.dye.name,
                                  *reference.distance, noise)
                    : fmt::format("distance to the emission of {}: none, there is no light here\n", reference.dye.name);
    }
    return text;
}

PlotCurve emission_curve(const Findings& f, const Reference& reference) {
    const double area = [&] {
        double sum = 0;
        for (const double value : emission_on_film(reference.dye.emission_per_nm, f.film))
            sum += value * f.bin_nm;
        return sum;
    }();
    PlotCurve curve;
    curve.label = reference.dye.name + " emission";
    curve.color = display_color(reference.dye.emission_per_nm.peak_nm());
    curve.dashed = true;
    for (double nm = f.film.from_nm; area > 0 && nm <= f.film.to_nm; nm += 0.5) {
        const double weight = f.film.unit == FilmUnit::Photons ? 1 : 1 / nm;
        curve.x.push_back(nm);
        curve.y.push_back(reference.dye.emission_per_nm(nm) * weight / area);
    }
    return curve;
}

/// What the image has more or less than the emission, bin by bin, with the image's noise.
PlotCurve residual_curve(const PlotCurve& response, const Reference& reference, double bin_nm) {
    PlotCurve residual;
    residual.label = "image - emission";
    residual.color = {0.8, 0.1, 0.1};
    residual.steps = true;
    residual.x = response.x;
    residual.error = response.error;
    const std::vector<double> emission = normalized(reference.on_film, bin_nm);
    for (std::size_t i = 0; i < emission.size(); ++i)
        residual.y.push_back(response.y[i] - emission[i]);
    return residual;
}

Plot make_plot(const Findings& f) {
    Plot plot;
    plot.title = "Spectral response";
    plot.subtitle =
        fmt::format("{}: {}, columns {} to {}, rows {} to {}", std::filesystem::path(f.image).filename().string(),
                    f.layer, f.region.x0, f.region.x1 - 1, f.region.y0, f.region.y1 - 1);
    for (const Reference& reference : f.references) {
        if (reference.distance) {
            plot.subtitle += fmt::format("; distance to {} {:.4f}", reference.dye.name, *reference.distance);
        }
    }
    plot.x_label = "wavelength (nm)";
    plot.y_label = "normalised to unit area (per nm)";
    plot.x_range = {f.film.from_nm, f.film.to_nm};
    plot.x_is_wavelength = true;
    PlotCurve response;
    response.label = "image";
    response.steps = true;
    response.y = normalized(f.response.mean, f.bin_nm);
    double sum = 0;
    for (const double value : f.response.mean)
        sum += value * f.bin_nm;
    for (std::size_t i = 0; i < f.film.channels.size(); ++i) {
        response.x.push_back(f.film.channels[i].center_nm);
        if (knows_error(f)) response.error.push_back(sum > 0 ? f.response.standard_error[i] / sum : 0);
    }
    if (f.references.size() == 1 && sum > 0) {
        plot.curves.push_back(residual_curve(response, f.references.front(), f.bin_nm));
    }
    plot.curves.push_back(std::move(response));
    double strength = 1;  // dyes of nearly the same colour are told apart by its depth
    for (const Reference& reference : f.references) {
        plot.curves.push_back(emission_curve(f, reference));
        Rgb& color = plot.curves.back().color;
        color = {strength * color.r, strength * color.g, strength * color.b};
        strength *= 0.6;
    }
    return plot;
}

void declare_options(CommandLine& command) {
    auto add = command.options().add_options();
    add("image", po::value<std::string>()->value_name("FILE"), "the image");
    add("region", po::value<std::string>()->value_name("x0,y0,x1,y1"), "pixels from x0,y0 up to but not x1,y1");
    add("dye", po::value<std::vector<std::string>>()->value_name("NAME"),
        "dye to compare with, or its file; may be repeated; none for no dye (default: the scene's)");
    add("layer", po::value<std::string>()->value_name("NAME"),
        "total, elastic, fluorescence or a dye's name (default: fluorescence where there is a dye)");
    add("output,o", po::value<std::string>()->value_name("CSV"), "write the CSV here instead of to stdout");
    add("plot", po::value<std::string>()->value_name("FILE"), "plot over the dye's emission, .svg or .png");
    command.positional("image", 1);
}

/// Files first; then the CSV or JSON on stdout, and the distances beside it.
void deliver(const CommandLine& command, const Findings& findings) {
    const auto& values = command.values();
    const bool to_file = values.count("output") > 0;
    if (to_file) write_text_file(values["output"].as<std::string>(), to_csv(findings));
    if (values.count("plot") > 0) save_plot(make_plot(findings), values["plot"].as<std::string>());
    if (command.common().json) {
        std::cout << to_json_text(findings);
        return;
    }
    if (!to_file) std::cout << to_csv(findings);
    if (command.common().quiet) return;
    std::ostream& out = to_file ? std::cout : std::cerr;
    if (findings.film.is_spectral) out << total_text(findings);
    out << distance_text(findings);
    for (const char* option : {"output", "plot"}) {
        if (values.count(option) > 0) out << values[option].as<std::string>() << '\n';
    }
}

}  // namespace

ExitCode run_spectrum(const std::vector<std::string>& arguments) {
    CommandLine command(kUsage, kExamples);
    declare_options(command);
    if (!command.parse(arguments)) return ExitCode::Ok;
    const auto& values = command.values();
    if (values.count("image") == 0) command.fail("which image?");
    const auto name = values["image"].as<std::string>();
    const bool plots = values.count("plot") > 0;
    if (plots && !is_plot_path(values["plot"].as<std::string>())) {
        command.fail("--plot " + values["plot"].as<std::string>() + " must end in .svg or .png");
    }
    const RenderedImage image = load_exr(name);
    if (plots && !image.film.is_spectral) {
        throw InputError(name + ": has detector channels, not a spectrum; there is nothing to plot over wavelength");
    }
    deliver(command, find_out(command, image, name));
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
