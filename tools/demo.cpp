#include "fluovox/core/progress.h"
#include "fluovox/core/quantity.h"
#include "fluovox/specimen/write_specimen.h"

#include "commands.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace fluovox::tools {
namespace {

void print_list(bool as_json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const SpecimenInfo& specimen : specimens()) {
        list.push_back({{"name", specimen.name}, {"summary", specimen.summary}});
        if (!as_json) fmt::print("{:<18} {}\n", specimen.name, specimen.summary);
    }
    if (as_json)
        fmt::print("{}\n", list.dump(2));
    else
        fmt::print("\nWrite one with: fluovox demo NAME -o FOLDER\n");
}

double parse_voxel_size(const CommandLine& line, const std::string& text) try {
    const double size = parse_quantity(text, Dimension::Length);
    if (!(size > 0)) line.fail("--voxel-size must be positive");
    return size;
} catch (const std::invalid_argument& e) {
    line.fail(fmt::format("--voxel-size: {}", e.what()));
}

void print_written(const std::vector<std::filesystem::path>& files, const std::filesystem::path& folder,
                   const std::string& name, bool as_json) {
    const std::string scene = (folder / "scene.toml").string();
    const char* ending = find_specimen(name).is_stack ? ".ome.tif" : ".exr";
    const std::string next = fmt::format("fluovox render {} -o {}", scene, (folder / (name + ending)).string());
    if (as_json) {
        nlohmann::ordered_json result = {
            {"outputs", nlohmann::ordered_json::array()}, {"scene", scene}, {"next", next}};
        for (const auto& file : files)
            result["outputs"].push_back(file.string());
        fmt::print("{}\n", result.dump(2));
        return;
    }
    for (const auto& file : files)
        fmt::print("{}  ({:.1f} kB)\n", file.string(), static_cast<double>(std::filesystem::file_size(file)) / 1e3);
    if (std::filesystem::exists(folder / (name + ".vdb"))) {
        fmt::print("Look: fluovox info {} --preview {}\n", (folder / (name + ".vdb")).string(),
                   (folder / "voxels.png").string());
    }
    fmt::print("Next: {}\n", next);
}

}  // namespace

ExitCode run_demo(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox demo [NAME -o FOLDER] [options]",
                     "  fluovox demo                                    lists the specimens\n"
                     "  fluovox demo neuron -o demo/neuron              mesh, morphology, grid and scene of a neuron\n"
                     "  fluovox demo neuron -o mine --seed 5            another neuron\n"
                     "  fluovox demo beads -o beads --voxel-size 0.2um  finer voxels\n");
    std::string name;
    std::string folder;
    std::string voxel_size;
    auto add = line.options().add_options();
    add("name", po::value(&name)->value_name("NAME"), "the specimen (also as the first argument)");
    add("output,o", po::value(&folder)->value_name("FOLDER"), "where to write; made if missing");
    add("seed", po::value<std::int64_t>()->value_name("N"), "grows another neuron");
    add("voxel-size", po::value(&voxel_size)->value_name("LEN"), "of the grid, with its unit: 0.5um");
    line.positional("name", 1);
    if (!line.parse(arguments)) return ExitCode::Ok;
    if (name.empty()) {
        print_list(line.common().json);
        return ExitCode::Ok;
    }
    DemoSettings settings;
    if (line.values().count("seed") > 0) settings.seed = static_cast<std::uint64_t>(line.at_least("seed", 0));
    if (!voxel_size.empty()) settings.voxel_size_um = parse_voxel_size(line, voxel_size);
    find_specimen(name);
    if (folder.empty()) line.fail("where to? Add -o FOLDER");
    const auto progress = make_progress(line.common());
    print_written(write_specimen(name, folder, settings, *progress), folder, name, line.common().json);
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
