#include "fluovox/core/text.h"
#include "fluovox/image/png.h"
#include "fluovox/volume/grid_info.h"
#include "fluovox/volume/projection.h"

#include "commands.h"
#include "image_info.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>

namespace fluovox::tools {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Json bounds_json(const Bounds& bounds) {
    if (bounds.empty()) return nullptr;
    return {{"min", vector_json(bounds.min)}, {"max", vector_json(bounds.max)}};
}

Json grid_json(const GridInfo& grid) {
    Json json = {{"name", grid.entry.name}, {"value_type", grid.entry.value_type}, {"half", grid.entry.half}};
    if (grid.labels) {
        json["labels"] = grid.labels->labels;
        json["largest_label"] = grid.labels->largest;
        json["voxel_size_um"] = vector_json(grid.voxel_size_um);
        json["active_voxels"] = grid.active_voxels;
        json["bbox_um"] = bounds_json(grid.bbox_um);
        json["memory_bytes"] = grid.memory_bytes;
    }
    if (!grid.entry.readable) return json;
    json["dye"] = grid.metadata.dye;
    json["value_unit"] = grid.metadata.value_unit;
    json["length_unit"] = grid.metadata.length_unit;
    json["class"] = grid.grid_class;
    json["source"] = grid.metadata.source;
    json["source_sha256"] = grid.metadata.source_sha256;
    json["fluovox_version"] = grid.metadata.fluovox_version;
    json["voxel_size_um"] = vector_json(grid.voxel_size_um);
    json["active_voxels"] = grid.active_voxels;
    json["bbox_um"] = bounds_json(grid.bbox_um);
    json["min"] = grid.min;
    json["mean"] = grid.mean;
    json["max"] = grid.max;
    json["total_mol"] = grid.has_concentrations ? Json(grid.total_mol) : Json(nullptr);
    json["memory_bytes"] = grid.memory_bytes;
    return json;
}

/// Zero where a coordinate is nothing beside a voxel.
Vec3 without_rounding(Vec3 position, const Vec3& voxel) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(position[axis]) < 1e-9 * voxel[axis]) position[axis] = 0;
    return position;
}

void print_extent(const GridInfo& grid) {
    const Vec3& voxel = grid.voxel_size_um;
    fmt::print("  voxel size    {:g} x {:g} x {:g} um\n", voxel.x, voxel.y, voxel.z);
    fmt::print("  active voxels {}\n", grid.active_voxels);
    if (grid.bbox_um.empty()) return;
    const Vec3 low = without_rounding(grid.bbox_um.min, voxel);
    const Vec3 high = without_rounding(grid.bbox_um.max, voxel);
    fmt::print("  bounding box  [{:g}, {:g}, {:g}] to [{:g}, {:g}, {:g}] um\n", low.x, low.y, low.z, high.x, high.y,
               high.z);
}

/// Of a grid that holds no dye: labels, or something else.
void print_other_grid(const GridInfo& grid) {
    const bool whole = grid.entry.value_type.starts_with("int");
    fmt::print("  values        {} ({})\n", grid.entry.value_type,
               whole ? "whole numbers such as labels, no concentration" : "not a grid that fluovox reads");
    if (!grid.labels) return;
    fmt::print("  labels        {}, the largest {}\n", grid.labels->labels, grid.labels->largest);
    print_extent(grid);
}

void print_statistics(const GridInfo& grid) {
    if (grid.grid_class == "level set") {
        fmt::print("  distances     {:.6g} to {:.6g}; voxelize --from-levelset makes a concentration of them\n",
                   grid.min, grid.max);
        return;
    }
    const std::string& unit = grid.metadata.value_unit;
    const bool silent = unit.empty();
    fmt::print("  {:<13} min {:.6g}, mean {:.6g}, max {:.6g}{}{}\n",
               grid.has_concentrations && !silent ? "concentration" : "range", grid.min, grid.mean, grid.max,
               silent ? "" : " ", unit);
    if (!grid.has_concentrations) return;
    fmt::print("  total amount  {:.6g} mol{}\n", grid.total_mol,
               silent ? " if the values are umol/L, as which they are read" : "");
}

void print_grid(const GridInfo& grid) {
    fmt::print("{}\n", grid.entry.name.empty() ? "(no name)" : grid.entry.name);
    if (!grid.entry.readable) {
        print_other_grid(grid);
        return;
    }
    const auto or_unknown = [](const std::string& text) { return text.empty() ? std::string("(not said)") : text; };
    fmt::print("  dye           {}\n", or_unknown(grid.metadata.dye));
    fmt::print("  values        {}{}, {}, in {}\n", grid.entry.value_type, grid.entry.half ? " (16 bit)" : "",
               grid.grid_class, or_unknown(grid.metadata.value_unit));
    print_extent(grid);
    if (!grid.bbox_um.empty()) print_statistics(grid);
    fmt::print("  memory        {:.3g} MB\n", static_cast<double>(grid.memory_bytes) / 1e6);
    if (!grid.metadata.source.empty()) fmt::print("  source        {}\n", grid.metadata.source);
}

/// All grids in one picture, each in its colour, brightness by the square root of its concentration.
Picture preview(const std::vector<Projection>& grids) {
    static constexpr std::array<std::array<double, 3>, 6> kColours = {
        {{0.25, 1, 0.35}, {1, 0.25, 0.9}, {0.25, 0.6, 1}, {1, 0.75, 0.2}, {0.2, 1, 1}, {1, 0.3, 0.25}}};
    Picture picture(grids.front().width, grids.front().height);
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            std::array<double, 3> light{};
            for (std::size_t g = 0; g < grids.size(); ++g) {
                const auto at =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) + static_cast<std::size_t>(x);
                const auto share = static_cast<double>(grids[g].values[at] / grids[g].largest);
                for (std::size_t c = 0; c < 3; ++c)
                    light[c] += std::sqrt(std::max(0.0, share)) * kColours[g % kColours.size()][c];
            }
            for (std::size_t c = 0; c < 3; ++c)
                picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, light[c])));
        }
    }
    return picture;
}

void save_preview(const std::string& file, const std::string& output) {
    constexpr int kMostPixels = 1024;
    const auto grids = project_grids(file, kMostPixels);
    if (grids.empty()) throw InputError(file + ": has no grid with anything to show");
    save_png(output, preview(grids));
}

}  // namespace

ExitCode run_info(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox info FILE.vdb|IMAGE.exr|STACK [--json] [--preview OUT.png] [--scene]",
                     "  fluovox info neuron.vdb\n"
                     "  fluovox info neuron.vdb --json\n"
                     "  fluovox info neuron.vdb --preview neuron.png\n"
                     "  fluovox info neuron.exr                  an image: pixels, channels, samples, seed\n"
                     "  fluovox info stack.ome.tif --scene       the scene that it was rendered from, as JSON\n");
    std::string file;
    std::string picture;
    auto add = line.options().add_options();
    bool scene = false;
    add("file", po::value(&file)->value_name("FILE"),
        "the grid file, or an image or stack of fluovox (.exr, .ome.tif, .tif, .ome.zarr)");
    add("preview", po::value(&picture)->value_name("OUT.png"),
        "of grids: write a picture, the maximum along the shortest axis");
    add("scene", po::bool_switch(&scene), "of an image or stack: print only the scene in it, as check --print would");
    line.positional("file", 1);
    if (!line.parse(arguments)) return ExitCode::Ok;
    if (file.empty()) line.fail("which file?");
    if (!picture.empty() && lower_case(std::filesystem::path(picture).extension().string()) != ".png") {
        line.fail("--preview " + picture + ": the picture is a PNG: --preview OUT.png");
    }

    if (is_image_name(file)) {
        if (!picture.empty()) line.fail("--preview draws grids, and " + file + " is named like an image");
        print_image_info(line.common(), file, scene);
        return ExitCode::Ok;
    }
    if (scene) line.fail("--scene is of images and stacks, and " + file + " is named like neither");
    const auto grids = inspect_grids(file);
    if (!picture.empty()) save_preview(file, picture);
    if (line.common().json) {
        Json json = {{"file", file}, {"grids", Json::array()}};
        for (const GridInfo& grid : grids)
            json["grids"].push_back(grid_json(grid));
        fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
        return ExitCode::Ok;
    }
    fmt::print("{}: {} grid{}\n", file, grids.size(), grids.size() == 1 ? "" : "s");
    for (const GridInfo& grid : grids)
        print_grid(grid);
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
