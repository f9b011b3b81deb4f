// Elastic scattering at one wavelength in branching tubes and in a cloud.

#include "fluovox/core/memory.h"
#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/render.h"

#include "cases.h"
#include "measure.h"
#include "scenes.h"

#include <fmt/format.h>

#include <string>
#include <vector>

namespace fluovox::bench {
namespace {

namespace fs = std::filesystem;

struct Case {
    std::string name, title;
    double least_paths = 0;      // millions per second with two threads
    double most_collisions = 0;  // per real one; 0: no target
    double times_plain = 0;      // 0: not compared
    double pbrt = 0;             // millions of paths per second of pbrt-v4 on two threads of a 2 GHz Xeon
    double pbrt_collisions = 0;  // per path there, of scenes described alike
};

const std::vector<Case>& cases() {
    static const std::vector<Case> all = {
        {"tubes256_1", "tubes 256^3, optical depth 1", 2.0, 5, 3, 0.25, 4.5},
        {"tubes256_20", "tubes 256^3, optical depth 20", 0.45, 0, 0, 0.03, 72},
        {"cloud256_20", "cloud 256^3, optical depth 20", 1.4, 1.6, 0, 0.15, 5.1},
        {"tubes1024_1", "tubes 1024^3, optical depth 1", 1.0, 7, 10, 0.1, 16.8},
    };
    return all;
}

// After this the process holds what any render does: libraries, threads, their stacks.
void render_something(const fs::path& folder) {
    NoProgress silent;
    const Scene scene = build_scene(load_scene_description(folder / "tubes32_1.toml", {"render.samples=1"}));
    render(scene, silent);
}

Figures render_scene(const fs::path& file, const std::vector<std::string>& overrides, bool plain = false) {
    NoProgress silent;
    Figures figures;
    render_something(file.parent_path());
    const double idle = resident_bytes();
    SceneDescription description = load_scene_description(file, overrides);
    description.render.plain_tracking = plain;
    Scene scene;
    figures["ready"] = seconds_of([&] { scene = build_scene(std::move(description)); });
    for (const SceneMedium& medium : scene.media) {
        figures["voxels"] += static_cast<double>(medium.grid->active_voxels());
        figures["grid_bytes"] += static_cast<double>(medium.grid->memory_bytes());
    }
    const auto& camera = scene.description.camera;
    const double pixels = static_cast<double>(camera.width) * camera.height;
    figures["paths"] = pixels * scene.description.render.samples;
    figures["film_bytes"] = pixels * 32;
    time_into(figures, [&] {
        const RenderResult result = render(scene, silent);
        release_freed_memory();
        figures["held"] = resident_bytes() - idle + static_cast<double>(result.guess_bytes);
        figures["real"] = static_cast<double>(result.counts.real_collisions);
        figures["null"] = static_cast<double>(result.counts.null_collisions);
        figures["lookups"] = static_cast<double>(result.counts.grid_lookups);
        figures["violations"] = static_cast<double>(result.counts.bound_violations);
    });
    figures["cpu_per_path"] = figures["cpu"] / figures["paths"];
    return figures;
}

void report_case(const Case& one, const fs::path& folder, double plain_loop, Table& table) {
    const fs::path file = folder / (one.name + ".toml");
    const Figures fast = measure(2, 3, [&] { return render_scene(file, {}); });
    table.heading(one.title);
    const double paths = fast.at("paths");
    table.at_least("paths/s (M), two threads by their CPU time", 2e-6 / fast.at("cpu_per_path"), one.least_paths);
    table.figure("  times pbrt-v4's", 2e-6 / fast.at("cpu_per_path") / one.pbrt);
    table.figure("  plain loop's steps of the same run in one path's time", plain_loop * 1e6 * fast.at("cpu_per_path"));
    table.figure("  paths/s (M) by the clock", 1e-6 * paths / fast.at("seconds"));
    const double ratio = (fast.at("real") + fast.at("null")) / fast.at("real");
    if (one.most_collisions > 0) {
        table.at_most("collisions per real one", ratio, one.most_collisions);
    } else {
        table.figure("collisions per real one", ratio);
    }
    if (one.times_plain > 0) {
        const Figures plain = measure(2, 1, [&] { return render_scene(file, {"render.samples=1"}, true); });
        table.at_least("CPU time per path of --tracking plain, in ours",
                       plain.at("cpu_per_path") / fast.at("cpu_per_path"), one.times_plain);
    }
    table.figure(fmt::format("  collisions per path ({} in pbrt-v4's scene)", one.pbrt_collisions),
                 (fast.at("real") + fast.at("null")) / paths);
    table.figure("  real collisions per path", fast.at("real") / paths);
    table.figure("  grid look-ups per path", fast.at("lookups") / paths);
    table.at_most("bounds exceeded", fast.at("violations"), 0);
    table.at_most("bytes per active voxel", fast.at("grid_bytes") / fast.at("voxels"), 6);
    table.at_most("memory held while rendering, less film: bytes per active voxel",
                  (fast.at("held") - fast.at("film_bytes")) / fast.at("voxels"), 6);
    if (one.name == "tubes1024_1") {
        table.at_most("ready after (s), from the .vdb file", fast.at("ready"), 1.5);
    } else {
        table.figure("ready after (s), from the .vdb file", fast.at("ready"));
    }
}

// One specimen on its own, and two of them side by side; the same at twice the resolution.
void report_growth(const fs::path& folder, Table& table) {
    const auto cost = [&](const std::string& name) {
        return measure(2, 3, [&] { return render_scene(folder / (name + ".toml"), {}); }).at("cpu_per_path");
    };
    const double base = cost("tubes256_1");
    table.heading("growth");
    table.at_most("time per path when the resolution doubles (256^3 to 512^3)", cost("tubes512_1") / base, 1.25);
    table.at_most("time per path when the specimen count doubles (256 x 256 x 256 to 512 x 256 x 256)",
                  cost("two256_1") / base, 1.3);
}

// Paths per pixel: so many that a run takes a second or so, and what it takes to begin and end hardly counts.
constexpr int kSamplesOfShortPaths = 128;
constexpr int kSamplesOfLongPaths = 32;

}  // namespace

void write_scenes(const fs::path& folder) {
    const auto write_tubes = [&](const Tubes& tubes, const std::string& name, const std::vector<double>& depths) {
        const BenchField field = make_tubes(tubes);
        const double cells = static_cast<double>(tubes.size.x) * tubes.size.y * tubes.size.z;
        fmt::print("{}: {} active voxels, {:.2f} % of the box\n", name, field.active,
                   100 * static_cast<double>(field.active) / (cells * tubes.scale * tubes.scale * tubes.scale));
        for (const double depth : depths)
            write_elastic_scene(folder, fmt::format("{}_{}", name, depth), field, depth / (field.mean * tubes.size.z),
                                depth > 1 ? kSamplesOfLongPaths : kSamplesOfShortPaths);
    };
    write_tubes({{32, 32, 32}, 0.033, 3.2, 1, 1}, "tubes32", {1});
    write_tubes({{256, 256, 256}, 0.033, 3.2, 1, 1}, "tubes256", {1, 20});
    write_tubes({{256, 256, 256}, 0.033, 3.2, 2, 1}, "tubes512", {1});
    write_tubes({{512, 256, 256}, 0.033, 3.2, 1, 2}, "two256", {1});
    write_tubes({{1024, 1024, 1024}, 0.0062, 2.7, 1, 1}, "tubes1024", {1});
    const BenchField cloud = make_cloud(256);
    write_elastic_scene(folder, "cloud256_20", cloud, 20 / cloud.through_middle_um, kSamplesOfShortPaths);
    fmt::print("cloud256: {} active voxels\n", cloud.active);
}

void report_elastic(const fs::path& folder, Table& table) {
    const double loop = plain_loop_rate();
    table.heading("this machine");
    table.figure("plain loop, one thread (M steps/s)", loop);
    for (const Case& one : cases())
        report_case(one, folder, loop, table);
    report_growth(folder, table);
}

}  // namespace fluovox::bench
