// Speed and memory of the main job, on the project's own neuron: what tools/bench.sh prints.

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/specimen/write_specimen.h"
#include "fluovox/transport/render.h"
#include "fluovox/voxelize/specimen.h"

#include "measure.h"

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

namespace {

namespace fs = std::filesystem;
using namespace fluovox;         // NOLINT(google-build-using-namespace): a program, not a header
using namespace fluovox::bench;  // NOLINT(google-build-using-namespace)

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
    figures["seconds"] = seconds_of([&] {
        const RenderResult result = render(scene, silent);
        figures["real"] = static_cast<double>(result.counts.real_collisions);
        figures["null"] = static_cast<double>(result.counts.null_collisions);
        figures["lookups"] = static_cast<double>(result.counts.grid_lookups);
        figures["violations"] = static_cast<double>(result.counts.bound_violations);
    });
    return figures;
}

void row(const std::string& what, const std::string& value) {
    fmt::print("{:<52} {:>14}\n", what, value);
}

Figures report_render(const std::string& what, SceneDescription scene) {
    const auto number = [](double value) { return fmt::format("{:.3g}", value); };
    scene.render.estimator = "path";
    const Figures two = measure(2, 3, [&] { return render_neuron(scene); });
    const Figures one = measure(1, 3, [&] { return render_neuron(scene); });
    const double paths = static_cast<double>(kPixels) * kPixels * kSamples;
    const double seconds = two.at("seconds");
    row(fmt::format("{}, {} x {}, {} samples (s)", what, kPixels, kPixels, kSamples), number(seconds));
    row("  paths/s (k)", number(paths / seconds / 1e3));
    row("  real and null collisions/s (M)", number((two.at("real") + two.at("null")) / seconds / 1e6));
    row("  grid look-ups/s (M)", number(two.at("lookups") / seconds / 1e6));
    row("  real collisions per path", number(two.at("real") / paths));
    row("  null collisions per path", number(two.at("null") / paths));
    row("  collisions per real one", number((two.at("real") + two.at("null")) / two.at("real")));
    row("  grid look-ups per path", number(two.at("lookups") / paths));
    row("  one thread over two", number(one.at("seconds") / seconds));
    return two;
}

void report(const fs::path& folder) {
    const auto number = [](double value) { return fmt::format("{:.3g}", value); };
    row("plain loop, one thread (M steps/s)", number(plain_loop_rate()));

    const Figures voxels = measure(2, 3, [&] { return voxelize_neuron(folder); });
    const Figures voxels_one = measure(1, 3, [&] { return voxelize_neuron(folder); });
    row("voxelize the neuron at 256, reading included (s)", number(voxels.at("seconds")));
    row("  one thread over two", number(voxels_one.at("seconds") / voxels.at("seconds")));
    row("  peak memory (MB)", number(voxels.at("peak_bytes") / 1e6));

    const Figures idle = measure(1, 1, [] { return Figures{}; });
    const Figures grid = measure(2, 3, [&] { return set_up(folder); });
    row("scene set-up (s)", number(grid.at("seconds")));
    row("  bytes per active voxel", number(grid.at("grid_bytes") / grid.at("active_voxels")));

    const Figures two = report_render("render the neuron", scene_of(folder));
    row("  peak memory (MB)", number(two.at("peak_bytes") / 1e6));
    row("  of which the program itself, idle (MB)", number(idle.at("peak_bytes") / 1e6));
    row("  bounds exceeded", number(two.at("violations")));
    const Figures deep = report_render("render the neuron 0.5 mm deep in cortex", deep_scene_of(folder));
    row("  bounds exceeded", number(deep.at("violations")));
}

}  // namespace

int main() try {
    const fs::path folder = fs::temp_directory_path() / "fluovox_bench";
    fs::create_directories(folder);
    measure(2, 1, [&] {
        NoProgress silent;
        write_specimen("neuron", folder.string(), DemoSettings{}, silent);
        return Figures{};
    });
    report(folder);
    fs::remove_all(folder);
    return 0;
} catch (const std::exception& e) {
    fmt::print(stderr, "bench: {}\n", e.what());
    return 1;
}
