// Speed and memory of the main job, on the project's own neuron.

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/render.h"
#include "fluovox/voxelize/specimen.h"

#include "cases.h"
#include "measure.h"

#include <fmt/format.h>

#include <string>

namespace fluovox::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kResolution = 256;  // voxels along the neuron's longest side
constexpr int kPixels = 128;
constexpr int kSamples = 32;

Figures voxelize_neuron(const fs::path& folder) {
    NoProgress silent;
    SpecimenGroup group;
    group.dye = "EGFP";
    group.concentration_uM = 10;
    SpecimenPart part;
    part.file = folder / "neuron.obj";
    part.name = "neuron";
    group.parts = {part};
    SpecimenSettings settings;
    settings.resolution = kResolution;
    Figures figures;
    figures["seconds"] = seconds_of([&] {
        const SpecimenResult result = voxelize_specimen({group}, settings, silent);
        save_dye_grids(folder / "bench.vdb", result.grids);
    });
    return figures;
}

SceneDescription scene_of(const fs::path& folder) {
    return load_scene_description(folder / "scene.toml", {fmt::format("camera.resolution=[{0},{0}]", kPixels),
                                                          fmt::format("render.samples={}", kSamples)});
}

Figures set_up(const fs::path& folder) {
    Figures figures;
    figures["seconds"] = seconds_of([&] {
        const Scene scene = build_scene(scene_of(folder));
        for (const SceneMedium& medium : scene.media) {
            if (!medium.grid) continue;
            figures["active_voxels"] += static_cast<double>(medium.grid->active_voxels());
            figures["grid_bytes"] += static_cast<double>(medium.grid->memory_bytes());
        }
    });
    return figures;
}

/// The neuron in a block of cortex 0.5 mm deep: paths are long, so the cost of a collision shows.
SceneDescription deep_scene_of(const fs::path& folder) {
    SceneDescription scene = scene_of(folder);
    for (MediumDescription& medium : scene.media) {
        if (!medium.dye) medium.region = BoxRegion{{-400, -400, -250}, {400, 400, 250}};
    }
    return scene;
}

Figures render_neuron(const SceneDescription& description) {
    NoProgress silent;
    const Scene scene = build_scene(description);
    Figures figures;
    for (const SceneMedium& medium : scene.media) {
        if (medium.grid) figures["active_bytes"] += sizeof(float) * static_cast<double>(medium.grid->active_voxels());
    }
    time_into(figures, [&] {
        const RenderResult result = render(scene, silent);
        figures["real"] = static_cast<double>(result.counts.real_collisions);
        figures["null"] = static_cast<double>(result.counts.null_collisions);
        figures["shadow"] = static_cast<double>(result.counts.shadow_collisions);
        figures["lookups"] = static_cast<double>(result.counts.grid_lookups);
        figures["violations"] = static_cast<double>(result.counts.bound_violations);
    });
    return figures;
}

void report_render(const std::string& what, SceneDescription scene, double set_up_bytes, Table& table) {
    scene.render.estimator = "path";
    const Figures two = measure(2, 3, [&] { return render_neuron(scene); });
    const Figures one = measure(1, 3, [&] { return render_neuron(scene); });
    const double paths = static_cast<double>(kPixels) * kPixels * kSamples;
    const double seconds = two.at("cpu") / 2;
    const double collisions = two.at("real") + two.at("null");
    table.heading(fmt::format("{}, {} x {}, {} samples", what, kPixels, kPixels, kSamples));
    table.figure("seconds, two threads by their CPU time", seconds);
    table.figure("  paths/s (k)", paths / seconds / 1e3);
    table.figure("  real and null collisions of flights/s (M)", collisions / seconds / 1e6);
    table.figure("  those of transmittances included/s (M)", (collisions + two.at("shadow")) / seconds / 1e6);
    table.figure("  grid look-ups/s (M)", two.at("lookups") / seconds / 1e6);
    table.figure("  real collisions per path", two.at("real") / paths);
    table.figure("  null collisions per path", two.at("null") / paths);
    table.figure("  tentative collisions of transmittances per path", two.at("shadow") / paths);
    table.figure("  collisions per real one", collisions / two.at("real"));
    table.figure("  grid look-ups per path", two.at("lookups") / paths);
    table.figure("  one thread over two, by the clock", one.at("seconds") / two.at("seconds"));
    const double film =
        film_bytes(scene.film, kPixels, kPixels, film_layers({"EGFP", "mCherry"}, scene.film.per_dye).size());
    table.figure("  peak memory (MB)", two.at("peak_bytes") / 1e6);
    table.figure("  of that the film (MB)", film / 1e6);
    table.figure("  active voxels, 4 bytes each (MB)", two.at("active_bytes") / 1e6);
    // The data are so small that the program itself and OpenVDB's reading, told above, are most of the whole.
    const double allowed = 3 * two.at("active_bytes") + film;
    table.figure("  peak memory over 3 x active voxels + film", two.at("peak_bytes") / allowed);
    table.at_most("  the same without what scene set-up took before", (two.at("peak_bytes") - set_up_bytes) / allowed,
                  1);
    table.at_most("bounds exceeded", two.at("violations"), 0);
}

}  // namespace

void report_neuron(const fs::path& folder, Table& table) {
    const Figures voxels = measure(2, 3, [&] { return voxelize_neuron(folder); });
    const Figures voxels_one = measure(1, 3, [&] { return voxelize_neuron(folder); });
    table.heading("the neuron");
    table.figure("voxelize it at 256, reading included (s)", voxels.at("seconds"));
    table.figure("  one thread over two", voxels_one.at("seconds") / voxels.at("seconds"));
    table.figure("  peak memory (MB)", voxels.at("peak_bytes") / 1e6);
    const Figures idle = measure(1, 1, [] { return Figures{}; });
    const Figures grid = measure(2, 3, [&] { return set_up(folder); });
    table.figure("the program itself, idle (MB)", idle.at("peak_bytes") / 1e6);
    table.figure("scene set-up (s)", grid.at("seconds"));
    table.figure("  peak memory, the program's own included (MB)", grid.at("peak_bytes") / 1e6);
    table.at_most("bytes per active voxel", grid.at("grid_bytes") / grid.at("active_voxels"), 6);
    report_render("render the neuron", scene_of(folder), grid.at("peak_bytes"), table);
    report_render("render the neuron 0.5 mm deep in cortex", deep_scene_of(folder), grid.at("peak_bytes"), table);
}

}  // namespace fluovox::bench
