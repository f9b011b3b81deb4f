#include "fluovox/image/film.h"

#include "render_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <sstream>
#include <vector>

namespace fluovox::tools {

namespace fs = std::filesystem;

void add_stack_options(CommandLine& line) {
    auto add = line.options().add_options();
    add("format", po::value<std::string>()->value_name("NAME"),
        "of a stack: ome-tiff, imagej, ome-zarr or exr (default: by the file's name)");
    add("type", po::value<std::string>()->default_value("float32")->value_name("float32|uint16"),
        "of a stack's values");
    add("value-per-count", po::value<double>()->value_name("X"),
        "of uint16 (default: the stack's largest value becomes 65535)");
    add("layer", po::value<std::string>()->default_value(kTotalLayer)->value_name("NAME"),
        "which light a stack holds: total, fluorescence, elastic, or a dye (film.per_dye)");
    add("truth", po::value<std::string>()->value_name("LIST"),
        "ground truth beside a stack: all, or some of labels,concentration,photons,irradiance");
    add("overwrite", po::bool_switch(), "drop the planes that other work left beside the stack");
}

namespace {

struct FormatFacts {
    StackFormat format;
    const char* name;    ///< as `--format` has it
    const char* ending;  ///< the usual one
    const char* open_with;
};

constexpr std::array<FormatFacts, 4> kFormats = {{
    {StackFormat::OmeTiff, "ome-tiff", ".ome.tif",
     "Fiji: Plugins > Bio-Formats > Importer, or napari; plain ImageJ: run again with --format imagej"},
    {StackFormat::ImageJ, "imagej", ".tif", "ImageJ or Fiji: File > Open"},
    {StackFormat::OmeZarr, "ome-zarr", ".ome.zarr",
     "napari (with napari-ome-zarr), Fiji: File > Import > HDF5/N5/Zarr/OME-NGFF"},
    {StackFormat::Exr, "exr", ".exr", "any viewer of OpenEXR files; fluovox spectrum"},
}};

const FormatFacts& facts_of(StackFormat format) {
    return *std::find_if(kFormats.begin(), kFormats.end(), [&](const auto& facts) { return facts.format == format; });
}

std::optional<StackFormat> format_named(const CommandLine& line) {
    if (line.values().count("format") == 0) return std::nullopt;
    const std::string name = line.values()["format"].as<std::string>();
    for (const FormatFacts& facts : kFormats) {
        if (name == facts.name) return facts.format;
    }
    line.fail("--format is ome-tiff, imagej, ome-zarr or exr, not \"" + name + '"');
}

/// A name's ending, and what it says the file is: nothing for what we write beside a stack.
struct Ending {
    const char* text;
    std::vector<StackFormat> formats;
};

// The first that fits holds: .ome.tif is a .tif as well.
const std::vector<Ending>& endings() {
    static const std::vector<Ending> kEndings = {
        {".ome.tif", {StackFormat::OmeTiff}},
        {".ome.tiff", {StackFormat::OmeTiff}},
        {".tif", {StackFormat::OmeTiff, StackFormat::ImageJ}},
        {".tiff", {StackFormat::OmeTiff, StackFormat::ImageJ}},
        {".ome.zarr", {StackFormat::OmeZarr}},
        {".zarr", {StackFormat::OmeZarr}},
        {".exr", {StackFormat::Exr}},
        {".png", {}},
        {".apng", {}},
    };
    return kEndings;
}

/// Whether a name is more than this ending of it.
bool ends_with(const std::string& name, const std::string& end) {
    return name.size() > end.size() && name.ends_with(end);
}

}  // namespace

std::optional<StackFormat> stack_format(const CommandLine& line, const fs::path& output) {
    const std::optional<StackFormat> named = format_named(line);
    const std::string name = output.filename().string();
    for (const Ending& ending : endings()) {
        if (!ends_with(name, ending.text)) continue;
        if (!named) return ending.formats.empty() ? std::nullopt : std::optional(ending.formats.front());
        if (std::find(ending.formats.begin(), ending.formats.end(), *named) == ending.formats.end()) {
            line.fail(fmt::format("--format {} contradicts -o {}: end its name in {}, or leave --format out",
                                  line.values()["format"].as<std::string>(), output.string(), facts_of(*named).ending));
        }
        break;
    }
    return named;
}

void require_no_stack_options(const CommandLine& line) {
    for (const char* option : {"type", "value-per-count", "layer", "truth", "overwrite"}) {
        const auto& values = line.values();
        if (values.count(option) > 0 && !values[option].defaulted())
            line.fail(fmt::format("--{} is of stacks, and the scene has no [stack]", option));
    }
}

std::set<std::string> read_truth(const CommandLine& line) {
    static const std::set<std::string> kKinds = {"labels", "concentration", "photons", "irradiance"};
    std::set<std::string> wanted;
    if (line.values().count("truth") == 0) return wanted;
    std::istringstream list(line.values()["truth"].as<std::string>());
    for (std::string kind; std::getline(list, kind, ',');) {
        if (kind == "all") {
            wanted = kKinds;
        } else if (kKinds.contains(kind)) {
            wanted.insert(kind);
        } else {
            line.fail(fmt::format("--truth \"{}\" is none of: all, {}", kind, fmt::join(kKinds, ", ")));
        }
    }
    return wanted;
}

std::pair<std::string, std::string> split_stack_name(const fs::path& path) {
    const std::string name = path.filename().string();
    for (const Ending& ending : endings()) {
        if (ending.formats.empty() || !ends_with(name, ending.text)) continue;
        const std::string end = ending.text;
        return {name.substr(0, name.size() - end.size()), end};
    }
    return {path.stem().string(), path.extension().string()};
}

const char* how_to_open(StackFormat format) {
    return facts_of(format).open_with;
}

}  // namespace fluovox::tools
