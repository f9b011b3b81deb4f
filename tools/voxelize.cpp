#include "fluovox/core/atomic_file.h"
#include "fluovox/core/memory.h"
#include "fluovox/core/progress.h"
#include "fluovox/core/text.h"
#include "fluovox/core/version.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/levelset.h"
#include "fluovox/voxelize/specimen.h"

#include "commands.h"
#include "voxelize_options.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace fluovox::tools {
namespace {

using Json = nlohmann::ordered_json;

bool are_cubes(const Vec3& voxel) {
    return std::abs(voxel.y - voxel.x) + std::abs(voxel.z - voxel.x) < 1e-6 * voxel.x;
}

Json part_json(const PartReport& part) {
    const MeshReport& mesh = part.mesh;
    return {{"name", part.name},
            {"sha256", part.sha256},
            {"watertight", mesh.watertight()},
            {"vertices", mesh.vertices},
            {"triangles", mesh.triangles},
            {"welded_vertices", mesh.welded_vertices},
            {"degenerate_triangles", mesh.degenerate_triangles},
            {"boundary_edges", mesh.boundary_edges},
            {"nonmanifold_edges", mesh.nonmanifold_edges},
            {"misoriented_edges", mesh.misoriented_edges},
            {"components", mesh.components},
            {"cavities", mesh.cavities},
            {"flipped_triangles", mesh.flipped_triangles},
            {"flipped_components", mesh.flipped_components},
            {"guessed_components", mesh.guessed_components},
            {"holes", mesh.holes},
            {"uneven_holes", mesh.uneven_holes},
            {"area_um2", mesh.area_um2},
            {"volume_um3", mesh.volume_um3}};
}

Json part_json(const PartReport& part, const MorphologyReport& morphology) {
    return {{"name", part.name},
            {"sha256", part.sha256},
            {"points", morphology.points},
            {"roots", morphology.roots},
            {"soma", morphology.soma},
            {"soma_points", morphology.soma_points},
            {"branch_points", morphology.branch_points},
            {"spines", morphology.spines},
            {"cable_length", morphology.cable_length},
            {"mended_radii", morphology.mended_radii},
            {"zero_lengths", morphology.zero_lengths},
            {"missing_parents", morphology.missing_parents},
            {"cycles", morphology.cycles},
            {"repeated_points", morphology.repeated_points}};
}

Json part_json(const PartReport& part, const SegmentReport& segment) {
    return {{"name", part.name},
            {"sha256", part.sha256},
            {"label", segment.label},
            {"voxels", segment.voxels},
            {"volume_um3", segment.volume_um3}};
}

Json any_part_json(const PartReport& part) {
    if (part.segment) return part_json(part, *part.segment);
    return part.morphology ? part_json(part, *part.morphology) : part_json(part);
}

Json group_json(const GroupReport& group) {
    const VoxelizeReport& voxels = group.voxels;
    const double share =
        voxels.voxels == 0 ? 0 : static_cast<double>(voxels.decided_by_winding) / static_cast<double>(voxels.voxels);
    constexpr double kMolPerUmolLitreUm3 = 1e-21;
    Json json = {{"dye", group.dye},
                 {"concentration_umol_per_L", group.concentration_uM},
                 {"voxels", voxels.voxels},
                 {"volume_um3", voxels.volume_um3},
                 {"capped_volume_um3", voxels.capped_um3},
                 {"amount_mol", voxels.volume_um3 * group.concentration_uM * kMolPerUmolLitreUm3},
                 {"winding_share", share},
                 {"merged_points", voxels.merged_points},
                 {"seconds", group.seconds},
                 {"reading_seconds", group.reading_seconds},
                 {"voxelizing_seconds", group.seconds - group.reading_seconds},
                 {"meshes", Json::array()}};
    for (const PartReport& part : group.parts) {
        json["meshes"].push_back(any_part_json(part));
        if (part.label != 0) json["meshes"].back()["label"] = part.label;
    }
    return json;
}

Json report_json(const SpecimenResult& result, const std::string& output) {
    Json json = {{"output", output}, {"voxel_size_um", result.voxel_size_um}, {"groups", Json::array()}};
    const Vec3 size = inspect_dye_grid(result.grids.front()).voxel_size_um;
    if (!are_cubes(size)) json["voxel_size_um"] = {size.x, size.y, size.z};
    for (const GroupReport& group : result.groups)
        json["groups"].push_back(group_json(group));
    json["peak_memory_bytes"] = peak_resident_bytes();
    return json;
}

std::string text_of(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

void print_summary(const SpecimenResult& result, const std::string& output) {
    std::string text;
    double seconds = 0;
    for (const GroupReport& group : result.groups)
        seconds += group.seconds;
    for (const DyeGrid& grid : result.grids) {
        const GridInfo info = inspect_dye_grid(grid);
        text += fmt::format(" {} {} voxels", info.entry.name, info.active_voxels);
        text += info.entry.readable ? fmt::format(", {:.6g} mol;", info.total_mol) : std::string(";");
    }
    const Vec3 size = inspect_dye_grid(result.grids.front()).voxel_size_um;
    const std::string voxel = are_cubes(size) ? fmt::format("{:g} um", result.voxel_size_um)
                                              : fmt::format("{:g} x {:g} x {:g} um", size.x, size.y, size.z);
    fmt::print("{}:{} voxels of {}, {:.2f} s, {} MB\n", output, text, voxel, seconds, peak_resident_bytes() / 1000000);
}

/// Files of 16 bits a value keep umol/L: throws where the largest would become infinite, or one would lose digits.
void require_half_holds(const std::string& dye, double smallest_uM, double largest_uM) {
    constexpr double kLargestHalf = 65504;
    constexpr double kSmallestNormalHalf = 0x1p-14;
    if (largest_uM <= kLargestHalf && smallest_uM >= kSmallestNormalHalf) return;
    throw InputError(
        fmt::format("{} at {:g} umol/L: --half keeps concentrations from 6.1e-05 to 65504 umol/L; leave out --half",
                    dye, largest_uM > kLargestHalf ? largest_uM : smallest_uM));
}

/// Before any work.
void require_half_holds(const VoxelizeRequest& request) {
    for (const SpecimenGroup& group : request.groups)
        require_half_holds(group.dye, group.concentration_uM, group.concentration_uM);
    if (!request.segmentation) return;
    for (const SegmentDye& dye : request.segmentation->dyes)
        require_half_holds(dye.dye, dye.concentration_uM, dye.concentration_uM);
}

/// Once overlaps are summed.
void require_half_holds(const SpecimenResult& result) {
    for (const DyeGrid& grid : result.grids) {
        const GridInfo info = inspect_dye_grid(grid);
        if (info.entry.readable) require_half_holds(info.entry.name, info.max, info.max);
    }
}

/// A level set is one step: read, convert, describe.
SpecimenResult convert_levelset(const VoxelizeRequest& request) {
    const SpecimenGroup& group = request.groups.front();
    const double um = request.um_per_unit > 0 ? request.um_per_unit : 1;
    const DyeGrid grid = load_levelset_as_dye(request.levelset, request.levelset_grid, group.concentration_uM, um);
    GridMetadata metadata;
    metadata.dye = group.dye;
    metadata.value_unit = "umol/L";
    metadata.length_unit = "um";
    metadata.source = std::filesystem::path(request.levelset).filename().string();
    metadata.source_sha256 = sha256_hex(load_bytes(request.levelset));
    metadata.fluovox_version = version();
    describe_dye_grid(grid, group.dye, metadata, request.settings.half);
    SpecimenResult result;
    result.voxel_size_um = inspect_dye_grid(grid).voxel_size_um.x;
    result.grids = {grid};
    return result;
}

SpecimenResult run_request(const VoxelizeRequest& request, Progress& progress) {
    if (!request.levelset.empty()) return convert_levelset(request);
    if (request.segmentation) return voxelize_segmentation(*request.segmentation, request.settings, progress);
    return voxelize_specimen(request.groups, request.settings, progress);
}

}  // namespace

ExitCode run_voxelize(const std::vector<std::string>& arguments) {
    VoxelizeRequest request;
    CommandLine line = voxelize_command_line();
    if (!parse_voxelize(line, arguments, request)) return ExitCode::Ok;
    require_writable(request.output);
    if (!request.report.empty()) require_writable(request.report);
    const auto progress = make_progress(line.common());
    const auto say = [&](const std::string& remark) {
        if (!line.common().quiet) fmt::print(stderr, "fluovox: {}\n", printable(remark));
    };
    for (const std::string& remark : request.remarks)
        say(remark);

    if (request.settings.half) require_half_holds(request);
    const SpecimenResult result = run_request(request, *progress);
    if (progress->stopped()) {
        say("stopped; nothing was written");
        return ExitCode::Stopped;
    }
    for (const std::string& remark : result.remarks)
        say("warning: " + remark);
    if (request.settings.half) require_half_holds(result);
    save_dye_grids(request.output, result.grids);
    const Json report = report_json(result, request.output);
    if (!request.report.empty()) write_text_file(request.report, text_of(report));
    if (line.common().json) {
        fmt::print("{}", text_of(report));
    } else {
        print_summary(result, request.output);
    }
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
