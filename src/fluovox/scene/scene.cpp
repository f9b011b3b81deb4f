#include "fluovox/scene/scene.h"

#include "fluovox/core/quantity.h"
#include "fluovox/volume/grid_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace fluovox {
namespace {

constexpr double kAbsurd_uM = 1e5;      // 0.1 mol/L: no fluorescent dye dissolves like that
constexpr double kImpossible_uM = 1e9;  // denser than any matter

int index_of_dye(Scene& scene, const Dye& dye) {
    for (std::size_t i = 0; i < scene.dyes.size(); ++i) {
        if (scene.dyes[i].name == dye.name) return static_cast<int>(i);
    }
    scene.dyes.push_back(dye);
    return static_cast<int>(scene.dyes.size()) - 1;
}

// The grid's name in its file: as given, or the one named after the dye; or nothing, for the only one.
std::string grid_name(const MediumDescription& medium) {
    if (!medium.grid->name.empty() || !medium.dye || list_grids(medium.grid->file).size() == 1)
        return medium.grid->name;
    return medium.dye->name;
}

// Own units in one unit of the file: as its metadata say, or as ours.
double unit_size(const std::string& unit, Dimension dimension, const std::string& place) {
    if (unit.empty()) return 1;
    try {
        return parse_quantity("1 " + unit, dimension);
    } catch (const std::invalid_argument&) {
        throw InputError(
            fmt::format("{}: its metadata give the unit \"{}\", which is not a {}; say the right one in the scene",
                        place, unit, dimension_name(dimension)));
    }
}

/// Opens each grid once, however many media use it in the same way.
class GridLoader {
public:
    GridLoader(SparseGrid::Tree tree, std::vector<std::string>& warnings) : tree_(tree), warnings_(&warnings) {}

    std::shared_ptr<const SparseGrid> load(const MediumDescription& medium) {
        const GridReference& reference = *medium.grid;
        const std::string name = grid_name(medium);
        const bool is_dye = medium.dye.has_value();
        auto& grid = grids_[{reference.file.string(), name, is_dye, reference.scale, reference.uM_per_value,
                             reference.um_per_length}];
        if (grid) return grid;
        const auto units = [&](const GridMetadata& metadata) {
            const std::string place = place_of(reference, name);
            GridScale scale{reference.scale, 1};
            if (is_dye) {
                scale.value *= reference.uM_per_value ? *reference.uM_per_value
                                                      : unit_size(metadata.value_unit, Dimension::Concentration, place);
            }
            if (is_dye && !reference.uM_per_value && metadata.value_unit.empty()) {
                warnings_->push_back(fmt::format(
                    "{}: does not say what its values are: taken as umol/L; say it in the scene, grid = {{ ..., unit = "
                    "\"uM\" }}",
                    place));
            }
            scale.length = reference.um_per_length ? *reference.um_per_length
                                                   : unit_size(metadata.length_unit, Dimension::Length, place);
            return scale;
        };
        grid = std::make_shared<const SparseGrid>(SparseGrid::load(reference.file, name, units, tree_));
        if (is_dye && !(grid->max() <= kImpossible_uM)) {
            const std::string most =
                std::isfinite(grid->max()) ? fmt::format("{:.3g} mol/L", grid->max() * 1e-6) : "no finite number";
            throw InputError(fmt::format(
                "{}: its largest concentration is {}, denser than any matter; give its unit (grid.unit) or a smaller "
                "grid.scale",
                place_of(reference, name), most));
        }
        return grid;
    }

private:
    static std::string place_of(const GridReference& reference, const std::string& name) {
        return name.empty() ? reference.file.string() : reference.file.string() + ": grid \"" + name + '"';
    }

    using Key = std::tuple<std::string, std::string, bool, double, std::optional<double>, std::optional<double>>;
    std::map<Key, std::shared_ptr<const SparseGrid>> grids_;
    SparseGrid::Tree tree_;
    std::vector<std::string>* warnings_;
};

double volume(const Bounds& bounds) {
    const Vec3 size = bounds.size();
    return size.x * size.y * size.z;
}

// True for boxes of which the second has more room, also where both are infinite.
bool is_smaller(const Bounds& inner, const Bounds& outer) {
    if (std::isfinite(volume(inner))) return volume(inner) < volume(outer);
    const bool same = inner.min == outer.min && inner.max == outer.max;
    return !same && outer.contains(inner.min) && outer.contains(inner.max);
}

// Regions that replace this one where they lie: those marked exclusive that are inside it, being smaller.
std::vector<int> replaced_by(const std::vector<MediumDescription>& media, std::size_t outer) {
    std::vector<int> inner;
    for (std::size_t i = 0; i < media.size(); ++i) {
        if (i == outer || !media[i].exclusive || media[i].grid) continue;
        if (is_smaller(bounds_of(media[i].region), bounds_of(media[outer].region)))
            inner.push_back(static_cast<int>(i));
    }
    return inner;
}

void require_available(const SceneDescription& description) {
    const std::string& estimator = description.render.estimator;
    if (estimator == "bidirectional" || estimator == "vpl") {
        throw SceneError(
            description.render.where,
            fmt::format("estimator \"{}\" is not available yet; \"path\", \"light\" and \"cached\" are", estimator));
    }
}

// What is wrong with a grid is said at the place of the scene that names it.
std::shared_ptr<const SparseGrid> load_grid(const MediumDescription& medium, GridLoader& loader) {
    try {
        return loader.load(medium);
    } catch (const InputError& e) {
        const SourceLocation& at = medium.grid->where;
        throw InputError(fmt::format("{}:{}:{}: {}", at.file, at.line, at.column, e.what()));
    }
}

void add_medium(Scene& scene, const MediumDescription& description, GridLoader& loader) {
    SceneMedium medium;
    medium.name = description.name;
    medium.region = description.region;
    medium.scattering = description.scattering;
    medium.absorption = description.absorption;
    medium.phase = description.phase;
    medium.refractive_index = description.refractive_index;
    if (description.grid) medium.grid = load_grid(description, loader);
    if (description.dye) {
        medium.dye = index_of_dye(scene, *description.dye);
        if (!description.grid) medium.amount = description.concentration_uM;
        const double most = description.grid ? medium.grid->max() : medium.amount;
        if (most > kAbsurd_uM) {
            scene.warnings.push_back(
                fmt::format("{} reaches {:.3g} mol/L, more than any dye dissolves; did you mean {:.3g} uM?",
                            medium.name, most * 1e-6, most * 1e-6));
        }
    }
    scene.media.push_back(std::move(medium));
}

Vec3 turned(Vec3 v, Vec3 axis, double angle) {  // Rodrigues' formula
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) + ((1 - std::cos(angle)) * dot(axis, v)) * axis;
}

// A sheet that is pivoted while a picture is taken is, on average, as many sheets as angles; a two-sided one, two.
std::vector<SheetLight> parts_of(const SheetLight& sheet) {
    std::vector<SheetLight> sheets;
    for (const double angle : sheet.pivots_rad.empty() ? std::vector<double>{0} : sheet.pivots_rad) {
        SheetLight part = sheet;
        part.pivots_rad.clear();
        if (angle != 0) {
            part.direction = turned(sheet.direction, sheet.normal, angle);
            part.position = sheet.waist + turned(sheet.position - sheet.waist, sheet.normal, angle);
        }
        sheets.push_back(part);
        if (!sheet.two_sided) continue;
        part.direction = -part.direction;
        part.position = 2 * part.waist - part.position;
        sheets.push_back(part);
    }
    return sheets;
}

void add_light(Scene& scene, int table) {
    const Light& light = scene.description.lights[static_cast<std::size_t>(table)].light;
    const auto* sheet = std::get_if<SheetLight>(&light.shape);
    if (sheet == nullptr || (!sheet->two_sided && sheet->pivots_rad.empty())) {
        scene.lights.push_back(light);
        scene.light_tables.push_back(table);
        return;
    }
    const std::vector<SheetLight> sheets = parts_of(*sheet);
    for (const SheetLight& part : sheets) {
        Light one = light;
        one.power_W = light.power_W / static_cast<double>(sheets.size());
        one.shape = part;
        scene.lights.push_back(one);
        scene.light_tables.push_back(table);
    }
}

// Share of the dye's peak absorption that the light reaches where it is strongest.
double best_absorption(const Dye& dye, const std::vector<Light>& lights) {
    const Spectrum& absorption = dye.molar_absorption_per_M_cm;
    double best = 0;
    for (const Light& light : lights) {
        for (const auto& line : light.spectrum.lines)
            best = std::max(best, absorption(line.wavelength_nm));
        const Spectrum& continuous = light.spectrum.energy_per_nm;
        const double shared = integral_of_product(continuous, absorption);
        if (continuous.integral() > 0) best = std::max(best, shared / continuous.integral());
    }
    return absorption.max() > 0 ? best / absorption.max() : 0;
}

void warn_of_weak_excitation(Scene& scene) {
    constexpr double kWeak = 0.02;
    if (scene.lights.empty()) return;
    for (const Dye& dye : scene.dyes) {
        const double share = best_absorption(dye, scene.lights);
        if (share >= kWeak) continue;
        scene.warnings.push_back(
            fmt::format("{} absorbs the light at {:.2g} % of its peak ({:.0f} nm); expect almost no signal", dye.name,
                        100 * share, dye.molar_absorption_per_M_cm.peak_nm()));
    }
}

}  // namespace

Scene build_scene(SceneDescription description) {
    require_available(description);
    Scene scene;
    scene.description = std::move(description);
    const bool plain = scene.description.render.plain_tracking;
    GridLoader loader(plain ? SparseGrid::Tree::Keep : SparseGrid::Tree::Free, scene.warnings);
    for (const MediumDescription& medium : scene.description.media)
        add_medium(scene, medium, loader);
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        if (!scene.media[i].grid) scene.media[i].cut_by = replaced_by(scene.description.media, i);
    }
    for (int table = 0; table < static_cast<int>(scene.description.lights.size()); ++table)
        add_light(scene, table);
    warn_of_weak_excitation(scene);
    return scene;
}

}  // namespace fluovox
