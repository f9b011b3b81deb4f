#include "fluovox/transport/fluence.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/progress.h"
#include "fluovox/core/quantity.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/darkness.h"
#include "fluovox/volume/brick_field.h"

#include "commands.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace fluovox::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kExamples =
    "  fluovox fluence scene.toml --json budget.json\n"
    "  fluovox fluence scene.toml -o fluence.vdb --voxel-size 5um --photons 1e7\n"
    "  fluovox fluence scene.toml --json budget.json --photons 1e9 --rse 1e-3\n";

constexpr std::array<const char*, 6> kFaces = {"-x", "+x", "-y", "+y", "-z", "+z"};
constexpr std::array<const char*, 3> kEscapes = {"specular", "ballistic", "scattered"};

Json json_of(const Estimate& estimate) {
    return {{"value", estimate.value}, {"stderr", estimate.standard_error}};
}

Json json_of(const LightBudget& budget, const Scene& scene) {
    Json json;
    json["launched"] = json_of(budget.launched);
    for (std::size_t m = 0; m < budget.absorbed.size(); ++m)
        json["absorbed"][scene.media[m].name] = json_of(budget.absorbed[m]);
    if (budget.absorbed.empty()) json["absorbed"] = Json::object();
    for (std::size_t f = 0; f <= kFaces.size(); ++f) {
        Json& face = json["escaped"][f < kFaces.size() ? kFaces[f] : "all"];
        for (std::size_t e = 0; e < kEscapes.size(); ++e) {
            face[kEscapes[e]] = json_of(budget.escaped[f][e]);
            if (f == kFaces.size() || budget.by_angle[f][e].empty()) continue;
            for (const Estimate& bin : budget.by_angle[f][e])
                face["by_angle"][kEscapes[e]].push_back(json_of(bin));
        }
    }
    json["cut"] = json_of(budget.cut);
    json["total"] = json_of(budget.total);
    for (std::size_t d = 0; d < scene.dyes.size(); ++d) {
        const std::string& name = scene.dyes[d].name;
        json["reemitted"][name] = json_of(budget.reemitted[d]);
        json["yield_loss"][name] = json_of(budget.yield_loss[d]);
        json["not_followed"][name] = json_of(budget.not_followed[d]);
    }
    return json;
}

Json json_of(const FluenceResult& result, const Scene& scene, std::uint64_t seed,
             const std::vector<std::string>& warnings) {
    Json json;
    json["photons"] = result.photons;
    json["seed"] = seed;
    json["excitation"] = json_of(result.share.excitation, scene);
    json["emission"] = json_of(result.share.emission, scene);
    json["watts"]["excitation"] = json_of(result.watts.excitation, scene);
    json["watts"]["emission"] = json_of(result.watts.emission, scene);
    json["met_a_medium"] = json_of(result.met_a_medium);
    json["mean_path_um"] = json_of(result.mean_path_um);
    json["bound_violations"] = result.bound_violations;
    json["warnings"] = warnings;
    return json;
}

void print_line(const std::string& name, const Estimate& share, const Estimate& watts) {
    if (share.value == 0 && share.standard_error == 0) return;
    fmt::print("  {:<34} {:>12.5g} +- {:<10.2g} {:>12.5g} W\n", name, share.value, share.standard_error, watts.value);
}

void print_table(const char* title, const LightBudget& share, const LightBudget& watts, const Scene& scene) {
    fmt::print("{}\n", title);
    print_line("launched", share.launched, watts.launched);
    for (std::size_t m = 0; m < share.absorbed.size(); ++m)
        print_line("absorbed by " + scene.media[m].name, share.absorbed[m], watts.absorbed[m]);
    for (std::size_t f = 0; f < kFaces.size(); ++f) {
        for (std::size_t e = 0; e < kEscapes.size(); ++e)
            print_line(fmt::format("escaped through {}, {}", kFaces[f], kEscapes[e]), share.escaped[f][e],
                       watts.escaped[f][e]);
    }
    print_line("cut (roulette balance, limits)", share.cut, watts.cut);
    print_line("total", share.total, watts.total);
    for (std::size_t d = 0; d < scene.dyes.size(); ++d) {
        print_line("  of it re-emitted by " + scene.dyes[d].name, share.reemitted[d], watts.reemitted[d]);
        print_line("  lost to yield of " + scene.dyes[d].name, share.yield_loss[d], watts.yield_loss[d]);
        print_line("  not followed (order), " + scene.dyes[d].name, share.not_followed[d], watts.not_followed[d]);
    }
}

double number(const CommandLine& line, const char* option, double least, double most) {
    const auto text = line.values()[option].as<std::string>();
    try {
        std::size_t used = 0;
        const double value = std::stod(text, &used);
        if (used == text.size() && value >= least && value <= most) return value;
    } catch (const std::logic_error&) {
    }
    line.fail(fmt::format("--{} {}: a number from {:g} to {:g} is needed", option, text, least, most));
}

FluenceSettings settings_of(const CommandLine& line) {
    FluenceSettings settings;
    const bool rse = line.values().count("rse") > 0;
    if (rse) {
        settings.relative_error = number(line, "rse", 1e-7, 1);
        settings.photons = 10'000'000'000;
    }
    if (line.values().count("photons") > 0)
        settings.photons = static_cast<std::int64_t>(std::llround(number(line, "photons", 1, 1e13)));
    if (line.values().count("angle-bins") > 0)
        settings.angle_bins = static_cast<int>(number(line, "angle-bins", 1, 10000));
    settings.grids = line.values().count("output") > 0;
    if (line.values().count("voxel-size") > 0) {
        try {
            settings.voxel_um = parse_quantity(line.values()["voxel-size"].as<std::string>(), Dimension::Length);
        } catch (const std::invalid_argument& e) {
            line.fail(std::string("--voxel-size: ") + e.what());
        }
        if (!(*settings.voxel_um > 0)) line.fail("--voxel-size must be above zero");
        if (!settings.grids) line.fail("--voxel-size is for the grids: say where to with -o OUT.vdb");
    }
    if (line.values().count("max-bytes") > 0) settings.max_bytes = number(line, "max-bytes", 1, 1e18);
    return settings;
}

std::vector<std::string> overrides(const CommandLine& line) {
    std::vector<std::string> keys;
    if (line.values().count("set") > 0) keys = line.values()["set"].as<std::vector<std::string>>();
    if (line.values().count("seed") > 0) keys.push_back(fmt::format("render.seed={}", line.at_least("seed", 0)));
    return keys;
}

void add_options(CommandLine& line) {
    const auto text = [](const char* value) { return po::value<std::string>()->value_name(value); };
    auto add = line.options().add_options();
    add("scene", text("SCENE.toml"), "the scene file (also without the option's name)");
    add("output,o", text("OUT.vdb"), "fluence rate (W/mm2) and absorbed power of each medium (W/mm3) as grids");
    add("json", text("FILE"), "the energy budget; without it a table is printed");
    add("photons", text("N"), "how many are launched (default 1e6; with --rse: at most)");
    add("rse", text("R"), "stop when all that is absorbed or escaped (1 % or more) is known to this relative error");
    add("voxel-size", text("LENGTH"), "of the grids; without it they have the voxels of the dyes that have grids");
    add("angle-bins", text("N"), "escaped light also by its angle to the face's normal, in N even bins of 0 to 90 deg");
    add("max-bytes", text("N"), "limit for the grids' memory (default 4e9)");
    add("seed", po::value<std::int64_t>()->value_name("N"), "instead of render.seed");
    add("set", po::value<std::vector<std::string>>()->value_name("KEY=VALUE"), "override a key of the scene file");
    line.positional("scene", 1);
}

// Light that was given up rather than followed, other than by the balance of roulette, which is zero on average.
void warn_of_what_was_cut(const LightBudget& budget, const char* what, std::vector<std::string>& warnings) {
    constexpr double kLittle = 1e-4;
    const Estimate& cut = budget.cut;
    if (cut.value <= kLittle * budget.launched.value || cut.value <= 5 * cut.standard_error) return;
    const double percent = 100 * cut.value / budget.launched.value;
    warnings.push_back(
        fmt::format("{:.{}f} % of the {} was cut: it would be reflected inside the same surfaces, or scatter, almost "
                    "for ever (or render.max_scatterings stops it)",
                    percent, percent < 10 ? 2 : 0, what));
}

/// What looks like a mistake, in the scene and in what came of it.
std::vector<std::string> warnings_of(const CommandLine& line, const Scene& scene, const FluenceResult& result) {
    std::vector<std::string> warnings = scene.warnings;
    if (!scene.media.empty() && !scene.lights.empty() && !(result.met_a_medium.value > 0)) {
        warnings.emplace_back("no photon met a medium: all light passes them by");
        for (const std::string& reason : how_lights_miss(scene))
            warnings.push_back(reason);
    }
    warn_of_what_was_cut(result.share.excitation, "light", warnings);
    warn_of_what_was_cut(result.share.emission, "fluorescence", warnings);
    if (!result.precise) {
        warnings.push_back(fmt::format(
            "{} photons were not enough for the relative standard error asked for (--rse {}); raise --photons",
            result.photons, line.values()["rse"].as<std::string>()));
    }
    if (result.bound_violations > 0)
        warnings.push_back(fmt::format("{} bounds were exceeded: the result is biased", result.bound_violations));
    return warnings;
}

}  // namespace

ExitCode run_fluence(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox fluence SCENE.toml [-o OUT.vdb] [--json BUDGET.json] [options]", kExamples);
    add_options(line);
    if (!line.parse(arguments)) return ExitCode::Ok;
    if (line.values().count("scene") == 0) line.fail("which scene?");
    FluenceSettings settings = settings_of(line);

    const auto begin = std::chrono::steady_clock::now();
    const Scene scene =
        build_scene(load_scene_description(line.values()["scene"].as<std::string>(), overrides(line), SceneUse::Light));
    settings.seed = scene.description.render.seed;
    if (!line.common().quiet) {
        for (const std::string& remark : scene.description.remarks)
            fmt::print(stderr, "note: {}\n", remark);
    }
    for (const std::string& warning : scene.warnings)
        fmt::print(stderr, "warning: {}\n", warning);  // at once: the rest may take long
    const FluenceResult result = [&] {
        const auto progress = make_progress(line.common());
        return trace_fluence(scene, settings, *progress);
    }();
    if (result.stopped) {
        fmt::print(stderr, "fluovox: stopped; nothing was written\n");
        return ExitCode::Stopped;
    }
    const std::vector<std::string> warnings = warnings_of(line, scene, result);
    if (settings.grids) {
        const auto output = line.values()["output"].as<std::string>();
        save_brick_fields(output, result.grids);
        fmt::print("{}\n", output);
    }
    if (line.values().count("json") > 0) {
        const auto output = line.values()["json"].as<std::string>();
        write_text_file(output, json_of(result, scene, settings.seed, warnings).dump(2) + "\n");
        fmt::print("{}\n", output);
    } else {
        print_table("excitation (shares of the photons launched)", result.share.excitation, result.watts.excitation,
                    scene);
        if (!scene.dyes.empty()) print_table("emission", result.share.emission, result.watts.emission, scene);
        if (result.met_a_medium.value > 0) {
            fmt::print("mean path in media of photons that met one: {:.6g} +- {:.2g} um\n", result.mean_path_um.value,
                       result.mean_path_um.standard_error);
        }
    }
    for (std::size_t i = scene.warnings.size(); i < warnings.size(); ++i)
        fmt::print(stderr, "warning: {}\n", warnings[i]);
    if (!line.common().quiet) {
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        fmt::print(stderr, "{} photons, {:.3g} scatterings, {:.1f} s\n", result.photons,
                   static_cast<double>(result.scatterings), seconds);
    }
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
