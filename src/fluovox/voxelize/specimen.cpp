#include "fluovox/voxelize/specimen.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/core/version.h"
#include "fluovox/volume/vdb_internal.h"
#include "fluovox/voxelize/capsule_tile.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/label_grid.h"
#include "fluovox/voxelize/mesh_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

/// A part of the specimen as it stands in the world, in um.
struct LoadedPart {
    Mesh mesh;
    std::vector<Capsule> capsules;
    std::string sha256;
    std::optional<MorphologyReport> morphology;
    std::string unit_doubt;

    Bounds bounds() const {
        Bounds all = mesh_bounds(mesh);
        for (const Capsule& capsule : capsules)
            all.add(capsule_bounds(capsule));
        return all;
    }
};

/// What to say of a part that is larger than any cell, where nobody said what its unit is; empty when it isn't.
/// `format_um`: what its format takes one unit for; 0: nothing.
std::string doubt_unit(const SpecimenPart& part, const Bounds& bounds, bool morphology, double format_um) {
    // Skeletons of axons do run through a whole mouse brain; meshes come from volumes of a millimetre.
    const double largest_um = morphology ? 2e4 : 5e3;
    constexpr double kAbsurd_um = 1e6;
    const Vec3 size = bounds.size();
    const double longest = std::max({size.x, size.y, size.z});
    if (part.um_per_unit > 0 || !(longest > largest_um)) return {};
    const std::string box = fmt::format("its bounding box is {:.6g} x {:.6g} x {:.6g} um", size.x, size.y, size.z);
    if (format_um > 0) {
        return fmt::format("{}: {}, since the format counts {:g} um a unit; --mesh-unit um or nm says otherwise",
                           part.name, box, format_um);
    }
    std::string doubt = fmt::format(
        "{}: {} when its coordinates are micrometres; neuron meshes are often in nanometres: add --mesh-unit nm, or "
        "--mesh-unit um if they are micrometres",
        part.name, box);
    if (longest > kAbsurd_um) throw InputError(doubt);
    return doubt;
}

LoadedPart load_part(const SpecimenPart& part) {
    const std::string bytes = load_bytes(part.file);
    const std::string extension = part.file.extension().string();
    LoadedPart loaded;
    loaded.sha256 = sha256_hex(bytes);
    if (is_morphology_file(part.file)) {
        CapsuleNeuron morphology = parse_morphology(bytes, extension, part.file.string());
        const double um = part.um_per_unit > 0 ? part.um_per_unit : 1;
        const double scale = length(part.placement.rows[0]);
        for (Capsule& capsule : morphology.capsules) {
            const Vec3 turned = part.placement.apply(capsule.normal) - part.placement.shift_um;
            capsule = {part.placement.apply(um * capsule.from), part.placement.apply(um * capsule.to),
                       um * scale * capsule.from_radius, um * scale * capsule.to_radius, (1 / scale) * turned};
        }
        loaded.capsules = std::move(morphology.capsules);
        loaded.morphology = morphology.report;
        loaded.unit_doubt = doubt_unit(part, loaded.bounds(), true, 0);
        return loaded;
    }
    MeshFile file = parse_mesh(bytes, extension, part.file.string());
    const double um = part.um_per_unit > 0 ? part.um_per_unit : (file.um_per_unit > 0 ? file.um_per_unit : 1);
    for (Vec3& v : file.mesh.vertices)
        v = part.placement.apply(um * v);
    loaded.mesh = std::move(file.mesh);
    loaded.unit_doubt = doubt_unit(part, loaded.bounds(), false, file.um_per_unit);
    return loaded;
}

Bounds specimen_bounds(const std::vector<SpecimenGroup>& groups) {
    Bounds bounds;
    for (const SpecimenGroup& group : groups) {
        for (const SpecimenPart& part : group.parts) {
            try {
                bounds.add(load_part(part).bounds());
            } catch (const InputError& e) {
                if (part.place.empty()) throw;
                throw InputError(part.place + ": " + e.what());
            }
        }
    }
    return bounds;
}

double require_sensible_voxel(double voxel_um, const char* cure) {
    constexpr double kSmallest = 1e-4;
    if (voxel_um >= kSmallest) return voxel_um;
    throw InputError(fmt::format("voxels of {:g} um are smaller than an atom; {}", voxel_um, cure));
}

double choose_voxel_size(const std::vector<SpecimenGroup>& groups, const SpecimenSettings& settings) {
    if (settings.voxels.voxel_size_um > 0) {
        return require_sensible_voxel(settings.voxels.voxel_size_um, "choose a larger --voxel-size");
    }
    const Vec3 size = (settings.bbox_um ? *settings.bbox_um : specimen_bounds(groups)).size();
    const double longest = std::max({size.x, size.y, size.z});
    if (!(longest > 0)) throw InputError("all meshes together have no extent, so --resolution means nothing");
    return require_sensible_voxel(longest / settings.resolution,
                                  "is the unit of the meshes right? --mesh-unit um says that their coordinates are "
                                  "micrometres");
}

void require_sound(const SpecimenPart& part, const MeshReport& mesh) {
    if (mesh.watertight()) return;
    throw InputError(fmt::format(
        "{}: is not watertight: {} open edges, {} edges whose triangles disagree about where outside is; close and "
        "orient it in a mesh editor, or leave out --strict, which caps its {} holes and says so in the report",
        part.name, mesh.boundary_edges, mesh.misoriented_edges, mesh.holes));
}

class DamageList {
public:
    void add(const std::string& what) { text_ += (text_.empty() ? "" : ", ") + what; }
    void add(std::size_t count, const char* what) {
        if (count > 0) add(fmt::format("{} {}", count, what));
    }
    std::string sentence(const std::string& name) const { return text_.empty() ? text_ : name + ": " + text_; }

private:
    std::string text_;
};

/// What is wrong with a mesh that was filled all the same, in one sentence; empty when nothing is.
std::string damage(const std::string& name, const MeshReport& mesh) {
    DamageList list;
    list.add(mesh.boundary_edges, "open edges");
    list.add(mesh.misoriented_edges, "mis-oriented edges");
    list.add(mesh.nonmanifold_edges, "non-manifold edges");
    list.add(mesh.holes, "holes capped");
    list.add(mesh.flipped_triangles, "triangles turned");
    list.add(mesh.flipped_components, "components turned inside out");
    list.add(mesh.guessed_components, "open components were turned by a guess, on which the amount depends");
    return list.sentence(name);
}

std::string damage(const std::string& name, const MorphologyReport& report) {
    DamageList list;
    list.add(report.mended_radii, "radii of zero or less replaced by a neighbour's");
    list.add(report.zero_lengths, "segments of no length");
    list.add(report.missing_parents, "points whose parent is missing made roots");
    list.add(report.cycles, "cycles cut");
    list.add(report.repeated_points, "points with a number used before dropped");
    // Each tree of an ASC file is a root of its own.
    const bool one_root = lower_case(std::filesystem::path(name).extension().string()) == ".swc";
    if (report.roots > 1 && one_root) list.add(report.roots, "roots");
    if (report.soma.starts_with("none") || report.soma.starts_with("outline")) list.add("soma: " + report.soma);
    return list.sentence(name);
}

/// A closed mesh whose volume the voxels miss points to a mistake, ours or in the input; better no file than that one.
void require_plausible(const GroupReport& report) {
    double volume = 0;
    for (const PartReport& part : report.parts)
        volume += part.mesh.volume_um3;
    constexpr double kTolerance = 0.05;
    if (volume == 0) return;
    if (std::abs(report.voxels.capped_um3 - volume) <= kTolerance * std::abs(volume)) return;
    throw InputError(fmt::format("{}: the voxels hold {:g} um3 and the meshes {:g} um3: the result would be wrong",
                                 report.parts.front().name, report.voxels.capped_um3, volume));
}

/// What to say of open meshes that hold another volume than their caps say; empty when they don't.
std::string doubt_volume(const GroupReport& report) {
    double volume = 0;
    std::size_t open_edges = 0;
    for (const PartReport& part : report.parts) {
        volume += part.mesh.volume_um3;
        open_edges += part.mesh.boundary_edges;
    }
    constexpr double kTolerance = 0.05;
    if (open_edges == 0 || std::abs(report.voxels.volume_um3 - volume) <= kTolerance * std::abs(volume)) return {};
    return fmt::format(
        "{}: the voxels hold {:.6g} um3, the mesh with its holes capped {:.6g} um3: the amount of dye depends on how "
        "its holes are closed (--inside), or parts of it overlap",
        report.parts.front().name, report.voxels.volume_um3, volume);
}

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

struct FilledGroup {
    DyeGrid grid;
    GroupReport report;
};

openvdb::FloatGrid& floats(const DyeGrid& grid) {
    return *openvdb::gridPtrCast<openvdb::FloatGrid>(grid.impl().grid);
}

/// Joins `from` to `into` where both have the same lattice; `from` comes later and is used up.
void join(openvdb::FloatGrid& into, openvdb::FloatGrid& from, OverlapRule rule) {
    using Arguments = openvdb::CombineArgs<float>;
    into.tree().combineExtended(
        from.tree(),
        [rule](Arguments& values) {
            const float a = values.a();
            const float b = values.b();
            switch (rule) {
                case OverlapRule::Max:
                    values.setResult(std::max(a, b));
                    break;
                case OverlapRule::Sum:
                    values.setResult(a + b);
                    break;
                case OverlapRule::First:
                    values.setResult(a > 0 ? a : b);
                    break;
                case OverlapRule::Last:
                    values.setResult(b > 0 ? b : a);
                    break;
            }
            values.setResultIsActive(values.result() > 0);
        },
        /*prune=*/false);
}

void add_voxels(VoxelizeReport& all, const VoxelizeReport& more) {
    all.volume_um3 += more.volume_um3;
    all.capped_um3 += more.capped_um3;
    all.voxels += more.voxels;
    all.decided_by_winding += more.decided_by_winding;
    all.merged_points += more.merged_points;
}

/// What a group is made of once read.
struct GroupShapes {
    std::vector<SolidMesh> solids;
    std::vector<Capsule> capsules;
};

GroupShapes load_group(const SpecimenGroup& group, const SpecimenSettings& settings, const VoxelizeSettings& voxels,
                       GroupReport& report, Progress& progress) {
    GroupShapes shapes;
    progress.start("reading", static_cast<long long>(group.parts.size()));
    for (const SpecimenPart& part : group.parts) {
        if (progress.stopped()) break;
        const auto begin = Clock::now();
        LoadedPart loaded = load_part(part);
        report.reading_seconds += seconds_since(begin);
        PartReport done{part.name, loaded.sha256, part.label, loaded.unit_doubt, {}, loaded.morphology, {}};
        if (loaded.morphology) {
            shapes.capsules.insert(shapes.capsules.end(), loaded.capsules.begin(), loaded.capsules.end());
        } else {
            const double bytes = estimate_grid_bytes(loaded.mesh, voxels.voxel_size_um);
            require_affordable(bytes, mesh_bounds(loaded.mesh), voxels);
            shapes.solids.push_back(make_solid(loaded.mesh));
            done.mesh = shapes.solids.back().report;
            if (settings.strict) require_sound(part, done.mesh);
        }
        report.parts.push_back(std::move(done));
        progress.advance(1);
    }
    return shapes;
}

// Nothing where the user stopped it.
std::optional<DyeGrid> fill_shapes(const GroupShapes& shapes, const SpecimenSettings& settings,
                                   const VoxelizeSettings& voxels, GroupReport& report, Progress& progress) {
    std::optional<DyeGrid> grid;
    if (!shapes.solids.empty()) {
        const bool shell = settings.shell_um > 0;
        VoxelizedGrid filled = shell ? voxelize_shell(shapes.solids, settings.shell_um, voxels, progress)
                                     : voxelize(shapes.solids, voxels, progress);
        if (progress.stopped()) return std::nullopt;
        report.voxels = filled.report;
        if (!shell) require_plausible(report);
        grid = filled.grid;
    }
    if (!shapes.capsules.empty()) {
        if (settings.shell_um > 0) throw InputError("--shell works on meshes, not on morphologies");
        VoxelizedGrid filled = voxelize_capsules(shapes.capsules, voxels, progress);
        if (progress.stopped()) return std::nullopt;
        add_voxels(report.voxels, filled.report);
        if (grid) {
            join(floats(*grid), floats(filled.grid), OverlapRule::Max);
        } else {
            grid = filled.grid;
        }
    }
    if (!grid) throw InputError("there is nothing to voxelize");
    return grid;
}

// Nothing where the user stopped it.
std::optional<FilledGroup> fill_group(const SpecimenGroup& group, const SpecimenSettings& settings, double voxel_um,
                                      Progress& progress) {
    const auto begin = Clock::now();
    GroupReport report;
    report.dye = group.dye;
    report.concentration_uM = group.concentration_uM;
    VoxelizeSettings voxels = settings.voxels;
    voxels.voxel_size_um = voxel_um;
    voxels.value = group.concentration_uM;
    try {
        const GroupShapes shapes = load_group(group, settings, voxels, report, progress);
        if (progress.stopped()) return std::nullopt;
        const auto grid = fill_shapes(shapes, settings, voxels, report, progress);
        if (!grid) return std::nullopt;
        report.seconds = seconds_since(begin);
        return FilledGroup{*grid, std::move(report)};
    } catch (const InputError& e) {
        const SpecimenPart& first = group.parts.front();
        const std::string text = e.what();
        const bool named = text.starts_with(first.name) || group.parts.size() > 1;
        throw InputError((first.place.empty() ? "" : first.place + ": ") + (named ? "" : first.name + ": ") + text);
    }
}

GridMetadata describe(const GroupReport& report) {
    GridMetadata metadata;
    metadata.dye = report.dye;
    metadata.value_unit = "umol/L";
    metadata.length_unit = "um";
    constexpr std::size_t kListed = 8;
    std::string all;
    for (std::size_t i = 0; i < report.parts.size(); ++i) {
        all += report.parts[i].sha256;
        if (i >= kListed) continue;
        const char* const separator = i == 0 ? "" : ",";
        metadata.source += separator + std::filesystem::path(report.parts[i].name).filename().string();
        metadata.source_sha256 += separator + report.parts[i].sha256;
    }
    if (report.parts.size() > kListed) {
        metadata.source += fmt::format(" and {} more", report.parts.size() - kListed);
        metadata.source_sha256 = sha256_hex(all);
    }
    metadata.fluovox_version = version();
    return metadata;
}

/// What the user should hear of a group. Files of one kind share their unit, so the first doubt stands for all.
void remark_on(const GroupReport& group, const SpecimenSettings& settings, bool& unit_doubted,
               std::vector<std::string>& remarks) {
    const auto remark = [&](const std::string& text) {
        if (!text.empty()) remarks.push_back(text);
    };
    for (const PartReport& part : group.parts) {
        remark(part.morphology ? damage(part.name, *part.morphology) : damage(part.name, part.mesh));
        if (!part.unit_doubt.empty() && !std::exchange(unit_doubted, true)) remark(part.unit_doubt);
    }
    const PartReport& first = group.parts.front();
    if (settings.shell_um == 0 && !settings.voxels.clip_um && !first.morphology) remark(doubt_volume(group));
    if (group.voxels.caps_only)
        remark(first.name + ": holes too large for the winding number at this voxel size; they were capped");
}

/// Parts without a label get their number among all.
void number_parts(GroupReport& group, int& part_number) {
    for (PartReport& part : group.parts) {
        ++part_number;
        if (part.label == 0) part.label = part_number;
    }
}

using GridsByDye = std::vector<std::pair<std::string, DyeGrid>>;

/// Joins a group to the grid of its dye; the first one becomes that grid.
void add_group(GridsByDye& grids, FilledGroup& group, const SpecimenSettings& settings) {
    const GridMetadata added = describe(group.report);
    const auto same =
        std::find_if(grids.begin(), grids.end(), [&](const auto& entry) { return entry.first == group.report.dye; });
    if (same == grids.end()) {
        describe_dye_grid(group.grid, group.report.dye, added, settings.half);
        grids.emplace_back(group.report.dye, group.grid);
        return;
    }
    join(floats(same->second), floats(group.grid), settings.overlap);
    GridMetadata metadata = grid_metadata(*same->second.impl().grid);
    metadata.source += ',' + added.source;
    metadata.source_sha256 += ',' + added.source_sha256;
    set_grid_metadata(*same->second.impl().grid, metadata);
}

}  // namespace

SpecimenResult voxelize_specimen(const std::vector<SpecimenGroup>& groups, const SpecimenSettings& settings,
                                 Progress& progress) {
    SpecimenResult result;
    result.voxel_size_um = choose_voxel_size(groups, settings);
    GridsByDye by_dye;
    std::optional<LabelGrid> labels;
    if (settings.labels) labels.emplace(result.voxel_size_um, settings.overlap);
    int part_number = 0;
    bool unit_doubted = false;
    for (const SpecimenGroup& group : groups) {
        std::optional<FilledGroup> filled = fill_group(group, settings, result.voxel_size_um, progress);
        if (!filled) return result;
        remark_on(filled->report, settings, unit_doubted, result.remarks);
        if (labels) {
            number_parts(filled->report, part_number);
            labels->add(floats(filled->grid), static_cast<float>(group.concentration_uM),
                        filled->report.parts[0].label);
        }
        add_group(by_dye, *filled, settings);
        result.groups.push_back(std::move(filled->report));
    }
    for (auto& [dye, grid] : by_dye)
        result.grids.push_back(grid);
    if (labels) result.grids.emplace_back(std::make_shared<DyeGrid::Impl>(DyeGrid::Impl{labels->finish()}));
    return result;
}

}  // namespace fluovox
