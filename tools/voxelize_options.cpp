#include "voxelize_options.h"

#include "fluovox/voxelize/circuit.h"
#include "fluovox/voxelize/mesh_file.h"
#include "fluovox/voxelize/morphology.h"

#include "voxelize_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>

namespace fluovox::tools {
namespace {

namespace fs = std::filesystem;

/// The files that one positional argument stands for: itself, or the meshes of a folder by name.
std::vector<fs::path> mesh_files(const std::string& argument) {
    if (!fs::is_directory(argument)) return {argument};
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(argument))
        if (entry.is_regular_file() && (is_mesh_file(entry.path()) || is_morphology_file(entry.path()))) {
            files.push_back(entry.path());
        }
    if (files.empty()) throw InputError(argument + ": has no meshes or morphologies");
    std::sort(files.begin(), files.end());
    return files;
}

/// Joins groups of one dye and concentration, so that their meshes become one union.
void add_group(std::vector<SpecimenGroup>& groups, SpecimenGroup group) {
    for (SpecimenGroup& there : groups) {
        if (there.dye != group.dye || there.concentration_uM != group.concentration_uM) continue;
        there.parts.insert(there.parts.end(), group.parts.begin(), group.parts.end());
        return;
    }
    groups.push_back(std::move(group));
}

/// `--dye` covers the meshes since the last `--dye`; a single one covers all, wherever it stands.
std::vector<SpecimenGroup> parse_groups(const CommandLine& line, double um_per_unit, bool single,
                                        std::vector<std::string>& remarks) {
    std::vector<SpecimenGroup> groups;
    SpecimenGroup group;
    std::optional<DyeChoice> only;
    for (const po::option& option : line.in_order()) {
        if (option.string_key == "mesh") {
            for (const fs::path& file : mesh_files(option.value.front()))
                group.parts.push_back({file, file.string(), um_per_unit, {}});
        } else if (option.string_key == "dye") {
            const DyeChoice dye = parse_dye(line, option.value.front(), remarks);
            only = dye;
            if (single) continue;
            if (group.parts.empty()) line.fail("--dye " + option.value.front() + " has no mesh before it");
            group.dye = dye.name;
            group.concentration_uM = dye.concentration_uM;
            add_group(groups, std::exchange(group, {}));
        }
    }
    if (single && only && !group.parts.empty()) {
        group.dye = only->name;
        group.concentration_uM = only->concentration_uM;
        groups.push_back(std::exchange(group, {}));
    }
    if (!group.parts.empty()) line.fail("no --dye NAME=CONCENTRATION follows " + group.parts.front().name);
    return groups;
}

template <class Choice>
Choice choose(const CommandLine& line, const std::string& option,
              const std::vector<std::pair<const char*, Choice>>& all) {
    const auto& text = line.values()[option].as<std::string>();
    std::string names;
    for (const auto& [name, choice] : all) {
        if (text == name) return choice;
        names += (names.empty() ? "" : ", ") + std::string(name);
    }
    line.fail("--" + option + ' ' + text + ": is one of " + names);
}

void parse_boxes(const CommandLine& line, SpecimenSettings& settings) {
    const auto& values = line.values();
    const double padding = values.count("padding") == 0
                               ? 0
                               : quantity(line, "--padding", values["padding"].as<std::string>(), Dimension::Length);
    if (values.count("padding") != 0 && values.count("bbox") + values.count("clip") == 0) {
        line.fail("--padding makes the box of --bbox or --clip larger: give one of them");
    }
    for (const char* option : {"bbox", "clip"}) {
        if (values.count(option) == 0) continue;
        Bounds bounds = box(line, std::string("--") + option, values[option].as<std::string>());
        bounds.min = bounds.min - Vec3{padding, padding, padding};
        bounds.max = bounds.max + Vec3{padding, padding, padding};
        settings.voxels.clip_um = bounds;
        if (std::string(option) == "bbox") settings.bbox_um = bounds;
    }
}

void parse_settings(const CommandLine& line, SpecimenSettings& settings) {
    const auto& values = line.values();
    if (values.count("voxel-size") == values.count("resolution")) {
        line.fail("give --voxel-size LENGTH or --resolution N (voxels along the longest side)");
    }
    if (values.count("voxel-size") != 0) {
        settings.voxels.voxel_size_um = positive_length(line, "--voxel-size", values["voxel-size"].as<std::string>());
    } else {
        settings.resolution = values["resolution"].as<int>();
        constexpr int kMost = 1 << 20;
        if (settings.resolution < 1 || settings.resolution > kMost) line.fail("--resolution must be 1 to 1048576");
    }
    parse_boxes(line, settings);
    settings.voxels.inside = choose<InsideRule>(line, "inside",
                                                {{"auto", InsideRule::Auto},
                                                 {"stab", InsideRule::Stab},
                                                 {"winding", InsideRule::Winding},
                                                 {"flood", InsideRule::Flood}});
    settings.overlap = choose<OverlapRule>(line, "overlap",
                                           {{"max", OverlapRule::Max},
                                            {"sum", OverlapRule::Sum},
                                            {"first", OverlapRule::First},
                                            {"last", OverlapRule::Last}});
    if (values.count("shell") != 0) {
        settings.shell_um = positive_length(line, "--shell", values["shell"].as<std::string>());
    }
    settings.voxels.max_bytes = values["max-bytes"].as<double>();
    settings.half = values["half"].as<bool>();
    settings.labels = values["labels"].as<bool>();
    settings.strict = values["strict"].as<bool>();
}

}  // namespace

CommandLine voxelize_command_line() {
    CommandLine line("fluovox voxelize MESH... -o OUT.vdb --dye NAME=CONCENTRATION --voxel-size LENGTH",
                     "  fluovox voxelize neuron.obj -o neuron.vdb --dye EGFP=5uM --voxel-size 0.1um\n"
                     "  fluovox voxelize cell.ply -o cell.vdb --dye EGFP=5uM --voxel-size 50nm --mesh-unit nm\n"
                     "  fluovox voxelize cell.swc -o cell.vdb --dye EGFP=5uM --voxel-size 0.2um\n"
                     "  fluovox voxelize segmentation.tif -o cells.vdb --label 17=EGFP:5uM --label 3=mCherry:2uM\n"
                     "  fluovox voxelize mask.nrrd -o cell.vdb --dye EGFP=5uM --voxel-size 16nm,16nm,40nm\n"
                     "  fluovox voxelize --from-levelset sdf.vdb -o cell.vdb --dye EGFP=5uM\n"
                     "  fluovox voxelize --circuit cells.csv -o circuit.vdb --voxel-size 0.2um --labels\n"
                     "  fluovox voxelize axon.ply dendrite.ply --dye EGFP=5uM nucleus.stl --dye DAPI=1uM \\\n"
                     "      -o cell.vdb --resolution 512\n");
    auto add = line.options().add_options();
    add("mesh", po::value<std::vector<std::string>>()->value_name("MESH"),
        "OBJ, PLY, STL, OFF, glTF, GLB; SWC, ASC (Neurolucida); a folder stands for all in it; "
        "or one mask or volume of labels: TIFF stack, NRRD");
    add("output,o", po::value<std::string>()->value_name("OUT.vdb"), "the grid file to write");
    add("dye", po::value<std::vector<std::string>>()->composing()->value_name("NAME=CONC"),
        "dye and concentration of the meshes since the last --dye: EGFP=5uM, or mydye.toml=2uM");
    add("voxel-size", po::value<std::string>()->value_name("LENGTH"),
        "0.1um, 20nm; of a segmentation: what its voxels are instead of what it says, 16nm,16nm,40nm");
    add("resolution", po::value<int>()->value_name("N"), "instead: voxels along the longest side of everything");
    add("mesh-unit", po::value<std::string>()->value_name("UNIT"),
        "what one unit of the meshes is: nm, um, 8nm (default: um; glTF says metres itself), or of a NRRD file");
    add("inside", po::value<std::string>()->default_value("auto")->value_name("RULE"),
        "auto: holes that are nearly flat are capped, at others the generalized winding number decides; stab: all are "
        "capped; winding: the number decides at all; flood: all are capped, and all that cannot be reached from "
        "outside is filled, cavities too");
    add("overlap", po::value<std::string>()->default_value("max")->value_name("RULE"),
        "where meshes of one dye with different concentrations overlap: max, sum, first, last");
    add("bbox", po::value<std::string>()->value_name("BOX"),
        "X0,Y0,Z0,X1,Y1,Z1: only this part, and what --resolution means");
    add("clip", po::value<std::string>()->value_name("BOX"),
        "X0,Y0,Z0,X1,Y1,Z1: only this part, with the covered share of voxels at its faces; of a segmentation: voxels "
        "whose centres are in it");
    add("padding", po::value<std::string>()->value_name("LENGTH"), "makes the box larger on every side");
    add("label", po::value<std::vector<std::string>>()->composing()->value_name("N=DYE:CONC"),
        "of a segmentation: which labels are which dye: 17=EGFP:5uM, or 1,4,10-19=EGFP:5uM; as often as needed");
    add("circuit", po::value<std::string>()->value_name("CELLS.csv"),
        "many cells: file, x, y, z (um), rx, ry, rz (degrees), scale, dye, concentration, label");
    add("labels", po::bool_switch(),
        "add an integer grid of labels: which mesh (or label) has at least half of each voxel");
    add("shell", po::value<std::string>()->value_name("LENGTH"),
        "fill a layer this thick along the surface, half of it outside and half inside, instead of the inside "
        "(membrane dyes)");
    add("from-levelset", po::value<std::string>()->value_name("FILE.vdb"),
        "convert a level set to a concentration, instead of meshes");
    add("grid", po::value<std::string>()->value_name("NAME"), "which grid of that file");
    add("half", po::bool_switch(), "store 16 bits a value (concentrations from 6.1e-5 to 65504 umol/L)");
    add("strict", po::bool_switch(), "refuse meshes that are not watertight");
    add("repair", po::bool_switch(), "does nothing: damaged meshes are always repaired as far as possible");
    add("report", po::value<std::string>()->value_name("FILE.json"), "what was found in each mesh, and the volumes");
    add("max-bytes", po::value<double>()->default_value(8.0 * (1LL << 30), "8 GiB")->value_name("N"),
        "stop when the grid would be larger");
    line.positional("mesh", -1);
    return line;
}

namespace {

/// The dye that a line of the table names; what is wrong with it is said of that line.
DyeChoice cell_dye(const CommandLine& line, const CircuitCell& cell, const std::string& place,
                   std::vector<std::string>& remarks) {
    const std::string named = cell.dye + '=' + cell.concentration;
    if (cell.concentration.empty()) throw InputError(place + ": " + cell.dye + " has no concentration");
    try {
        return choose_dye(line, named, cell.dye, cell.concentration, remarks);
    } catch (const UsageError& e) {
        throw InputError(place + ": " + std::string(e.what()).substr(0, std::string(e.what()).find('\n')));
    } catch (const Error& e) {
        throw Error(e.code(), place + ": " + e.what());
    }
}

/// Each cell is a group of its own, so that only one is in memory at a time.
void parse_circuit(const CommandLine& line, VoxelizeRequest& request) {
    const auto& values = line.values();
    const auto circuit = values["circuit"].as<std::string>();
    if (values.count("label") != 0) {
        line.fail("--label is for segmentations (TIFF, NRRD); the table gives each cell its dye, in " + circuit);
    }
    std::string otherwise;
    if (values.count("dye") != 0) {
        const auto dyes = values["dye"].as<std::vector<std::string>>();
        otherwise = dyes.front();
        if (dyes.size() > 1) line.fail("--circuit takes one --dye at most, for the cells to which it gives none");
    }
    std::vector<std::string> remarks;
    const std::vector<CircuitCell> cells = load_circuit(circuit, request.um_per_unit);
    const auto has_dye = [](const CircuitCell& cell) { return !cell.dye.empty(); };
    if (!otherwise.empty() && std::all_of(cells.begin(), cells.end(), has_dye))
        line.fail("--dye " + otherwise + ": the table gives each cell its dye; leave out --dye, or change " + circuit);
    for (const CircuitCell& cell : cells) {
        const std::string place = circuit + ':' + std::to_string(cell.line);
        const bool own = !cell.dye.empty();
        if (!own && otherwise.empty()) throw InputError(place + ": has no dye, and no --dye is given for all");
        const DyeChoice dye = own ? cell_dye(line, cell, place, remarks) : parse_dye(line, otherwise, remarks);
        request.groups.push_back({dye.name, dye.concentration_uM, {cell.part}});
    }
    for (const std::string& remark : remarks)
        if (std::find(request.remarks.begin(), request.remarks.end(), remark) == request.remarks.end())
            request.remarks.push_back(remark);
}

/// For labels each mesh must be told from the others.
std::vector<SpecimenGroup> one_part_each(const std::vector<SpecimenGroup>& groups) {
    std::vector<SpecimenGroup> single;
    for (const SpecimenGroup& group : groups) {
        for (const SpecimenPart& part : group.parts)
            single.push_back({group.dye, group.concentration_uM, {part}});
    }
    return single;
}

void parse_levelset(const CommandLine& line, VoxelizeRequest& request) {
    const auto& values = line.values();
    const auto dyes = values["dye"].as<std::vector<std::string>>();
    if (values.count("mesh") != 0 || dyes.size() != 1) line.fail("--from-levelset takes one --dye and no meshes");
    const DyeChoice dye = parse_dye(line, dyes.front(), request.remarks);
    request.groups = {{dye.name, dye.concentration_uM, {}}};
    request.levelset = values["from-levelset"].as<std::string>();
    if (values.count("grid") != 0) request.levelset_grid = values["grid"].as<std::string>();
    request.settings.half = values["half"].as<bool>();
}

std::uint64_t label_number(const CommandLine& line, const std::string& option, const std::string& text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || number == 0) {
        line.fail(option + ": \"" + text + "\" is no label; labels are whole numbers from 1");
    }
    return number;
}

/// "17=EGFP:5uM", "1,4,10-19=EGFP:5uM".
SegmentDye parse_label(const CommandLine& line, const std::string& text, std::vector<std::string>& remarks) {
    const std::string option = "--label " + text;
    const auto equals = text.find('=');
    const auto colon = text.rfind(':');
    if (equals == std::string::npos || equals == 0 || colon == std::string::npos || colon < equals + 2) {
        line.fail(option + ": wants LABEL=DYE:CONCENTRATION, for example 17=EGFP:5uM");
    }
    SegmentDye dye;
    dye.text = text.substr(0, equals);
    for (const std::string& range : split(dye.text, ',')) {
        const std::vector<std::string> ends = split(range, '-');
        const std::uint64_t first = label_number(line, option, ends.front());
        const std::uint64_t last = ends.size() == 1 ? first : label_number(line, option, ends.back());
        if (ends.size() > 2 || last < first) line.fail(fmt::format("{}: {} is no range of labels", option, range));
        dye.labels.emplace_back(first, last);
    }
    const DyeChoice choice =
        choose_dye(line, option, text.substr(equals + 1, colon - equals - 1), text.substr(colon + 1), remarks);
    dye.dye = choice.name;
    dye.concentration_uM = choice.concentration_uM;
    return dye;
}

/// A label has one dye.
void require_apart(const CommandLine& line, const std::vector<SegmentDye>& dyes) {
    for (std::size_t i = 0; i < dyes.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            for (const auto& [first, last] : dyes[i].labels) {
                for (const auto& [low, high] : dyes[j].labels) {
                    if (last < low || high < first) continue;
                    line.fail("--label " + dyes[i].text + '=' + dyes[i].dye + ": label " +
                              std::to_string(std::max(first, low)) + " has " + dyes[j].dye +
                              " already; a label takes one dye (make a file for each dye)");
                }
            }
        }
    }
}

/// A volume of labels keeps its voxels; what makes or moves voxels of meshes has no meaning for it.
void parse_segmentation(const CommandLine& line, const std::string& file, VoxelizeRequest& request) {
    const auto& values = line.values();
    for (const char* option : {"resolution", "shell", "circuit", "from-levelset"}) {
        if (values.count(option) == 0) continue;
        line.fail(std::string("--") + option + " is for meshes; a segmentation keeps its own voxels");
    }
    Segmentation segmentation;
    segmentation.file = file;
    segmentation.um_per_unit = request.um_per_unit;
    if (values.count("voxel-size") != 0) {
        const auto text = values["voxel-size"].as<std::string>();
        const std::vector<std::string> sides = split(text, ',');
        if (sides.size() != 1 && sides.size() != 3) line.fail("--voxel-size " + text + ": wants one length, or X,Y,Z");
        Vec3 size;
        for (int axis = 0; axis < 3; ++axis)
            size[axis] =
                positive_length(line, "--voxel-size", sides[sides.size() == 1 ? 0 : static_cast<std::size_t>(axis)]);
        segmentation.voxel_size_um = size;
    }
    const auto list = [&](const char* option) {
        return values.count(option) == 0 ? std::vector<std::string>() : values[option].as<std::vector<std::string>>();
    };
    for (const std::string& text : list("label"))
        segmentation.dyes.push_back(parse_label(line, text, request.remarks));
    require_apart(line, segmentation.dyes);
    const std::vector<std::string> dyes = list("dye");
    if (dyes.size() + (segmentation.dyes.empty() ? 0 : 1) != 1) {
        line.fail(
            "which dye? A mask takes one --dye NAME=CONCENTRATION for all of it, a volume of labels takes "
            "--label N=NAME:CONCENTRATION, for example --label 17=EGFP:5uM");
    }
    if (!dyes.empty()) {
        const DyeChoice dye = parse_dye(line, dyes.front(), request.remarks);
        segmentation.dyes.push_back({dye.name, dye.concentration_uM, {}, "above 0"});
    }
    parse_boxes(line, request.settings);
    request.settings.voxels.max_bytes = values["max-bytes"].as<double>();
    request.settings.half = values["half"].as<bool>();
    request.settings.labels = values["labels"].as<bool>();
    request.segmentation = std::move(segmentation);
}

/// The segmentation among the inputs, which must then be the only one.
std::optional<std::string> segmentation_file(const CommandLine& line) {
    const auto& values = line.values();
    if (values.count("mesh") == 0) return {};
    const auto files = values["mesh"].as<std::vector<std::string>>();
    const auto at = std::find_if(files.begin(), files.end(), [](const std::string& file) {
        return is_segmentation_file(file) && !fs::is_directory(file);
    });
    if (at == files.end()) {
        if (values.count("label") != 0) line.fail("--label is for segmentations (TIFF, NRRD)");
        return {};
    }
    if (files.size() > 1) line.fail(*at + " is a segmentation: it takes a run and a file of its own");
    return *at;
}

}  // namespace

bool parse_voxelize(CommandLine& line, const std::vector<std::string>& arguments, VoxelizeRequest& request) {
    if (!line.parse(arguments)) return false;
    const auto& values = line.values();
    const bool levelset = values.count("from-levelset") != 0;
    const bool circuit = values.count("circuit") != 0;
    if (values.count("mesh") == 0 && !levelset && !circuit) line.fail("which mesh?");
    if (values.count("mesh") != 0 && circuit) line.fail("--circuit names all meshes itself");
    if (values.count("output") == 0) line.fail("where to? add -o OUT.vdb");
    const auto segmentation = segmentation_file(line);
    if (values.count("dye") == 0 && !circuit && !segmentation)
        line.fail("which dye? add --dye NAME=CONCENTRATION, for example --dye EGFP=5uM");
    request.output = values["output"].as<std::string>();
    if (std::filesystem::path(request.output).extension() != ".vdb")
        line.fail("the grids go into an OpenVDB file: -o OUT.vdb");
    if (values.count("report") != 0) request.report = values["report"].as<std::string>();
    if (values.count("mesh-unit") != 0) request.um_per_unit = mesh_unit(line, values["mesh-unit"].as<std::string>());
    if (segmentation) {
        parse_segmentation(line, *segmentation, request);
        return true;
    }
    if (levelset) {
        parse_levelset(line, request);
        return true;
    }
    parse_settings(line, request.settings);
    if (circuit) {
        parse_circuit(line, request);
        return true;
    }
    const bool single = values["dye"].as<std::vector<std::string>>().size() == 1;
    request.groups = parse_groups(line, request.um_per_unit, single, request.remarks);
    // Summed where they overlap, or labelled: every mesh by itself, not as part of a union.
    if (request.settings.labels || request.settings.overlap != OverlapRule::Max) {
        request.groups = one_part_each(request.groups);
    }
    return true;
}

}  // namespace fluovox::tools
