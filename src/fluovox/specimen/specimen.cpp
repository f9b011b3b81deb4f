#include "fluovox/specimen/specimen.h"

#include "fluovox/core/embedded_text.h"
#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/core/version.h"
#include "fluovox/specimen/pyramidal_neuron.h"
#include "fluovox/specimen/skin.h"
#include "fluovox/specimen/solids.h"

#include <fmt/format.h>

#include <algorithm>

namespace fluovox {

namespace {

constexpr double kSkinResolution_um = 0.4;

Specimen make_neuron(std::uint64_t seed) {
    const Morphology cell = grow_pyramidal_neuron(seed);
    const std::string origin =
        fmt::format("Synthetic pyramidal neuron, fluovox {}, seed {}; micrometres.", version(), seed);
    const Vec3 center{0, 0.5, 0};
    Specimen neuron;
    neuron.swc = to_swc(cell, origin + "\nTypes: 1 soma, 2 axon, 3 basal dendrite, 4 apical dendrite, 5 spine.");
    neuron.bodies.push_back({"neuron.obj", "EGFP", 20, make_skin(body_of(cell), kSkinResolution_um), origin});
    neuron.bodies.push_back({"nucleus.obj", "mCherry", 20,
                             stretched(make_ball(center, 5, 4), center, {0.95, 1.1, 0.95}), "Nucleus. " + origin});
    return neuron;
}

/// Two cells side by side, each full of another dye.
Specimen make_cell_pair(std::uint64_t seed) {
    const Vec3 aside{62, -48, 8};
    Specimen pair;
    const auto add = [&](std::uint64_t of_cell, Vec3 shift, const char* file, const char* dye) {
        Morphology cell = grow_pyramidal_neuron(of_cell);
        for (MorphologyPoint& point : cell.points)
            point.position = point.position + shift;
        pair.bodies.push_back(
            {file, dye, 20, make_skin(body_of(cell), kSkinResolution_um),
             fmt::format("Synthetic pyramidal neuron, fluovox {}, seed {}; micrometres.", version(), of_cell)});
    };
    add(seed, {}, "green-cell.obj", "EGFP");
    add(seed + 3, aside, "red-cell.obj", "mCherry");
    return pair;
}

Specimen make_beads() {
    constexpr double kRadius_um = 5;
    constexpr double kSpacing_um = 40;
    Specimen beads;
    LabelledBody body{"beads.obj", "EGFP", 50, {}, "27 beads of 10 um, 40 um apart; micrometres."};
    for (const double z : {-kSpacing_um, 0.0, kSpacing_um}) {
        for (const double y : {-kSpacing_um, 0.0, kSpacing_um}) {
            for (const double x : {-kSpacing_um, 0.0, kSpacing_um})
                append(body.mesh, make_ball({x, y, z}, kRadius_um, 4));
        }
    }
    beads.bodies.push_back(std::move(body));
    return beads;
}

}  // namespace

const std::vector<SpecimenInfo>& specimens() {
    static const std::vector<SpecimenInfo> all = {
        {"neuron", "pyramidal neuron grown from a seed: EGFP in the cell, mCherry in its nucleus, in cortex", 0.7, 8},
        {"lightsheet-neuron", "two neurons, EGFP and mCherry, in cortex-like tissue: a light-sheet z-stack", 0.8, 8,
         true},
        {"beads", "27 beads of 10 um with a known amount of EGFP", 0.5, 0},
        {"cuvette-gfp", "cuvette of GFP in a highly scattering solution, excited at 460 nm", 0, 0},
        {"cuvette-rfp", "cuvette of RFP in a highly scattering solution, excited at 520 nm", 0, 0},
    };
    return all;
}

const SpecimenInfo& find_specimen(const std::string& name) {
    const auto& all = specimens();
    const auto found = std::find_if(all.begin(), all.end(), [&](const SpecimenInfo& s) { return s.name == name; });
    if (found != all.end()) return *found;
    std::vector<std::string> names;
    names.reserve(all.size());
    for (const SpecimenInfo& specimen : all)
        names.push_back(specimen.name);
    throw UsageError(
        fmt::format("no specimen \"{}\"{}\nThere are: {}", name, did_you_mean(name, names), fmt::join(names, ", ")));
}

Specimen make_specimen(const std::string& name, std::uint64_t seed) {
    find_specimen(name);
    Specimen specimen;
    if (name == "neuron") specimen = make_neuron(seed);
    if (name == "lightsheet-neuron") specimen = make_cell_pair(seed);
    if (name == "beads") specimen = make_beads();
    specimen.scene_toml = embedded_text("volumes/" + name + "/scene.toml");
    return specimen;
}

}  // namespace fluovox
