#include "fluovox/transport/render.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/memory.h"
#include "fluovox/core/progress.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/preview.h"
#include "fluovox/image/relative_error.h"
#include "fluovox/image/rendered_image.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/darkness.h"

#include "commands.h"
#include "json_or_null.h"
#include "render_stack.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace fluovox::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExamples =
    "  fluovox render scene.toml -o neuron.exr\n"
    "  fluovox render scene.toml -o quick.exr --samples 4 --set camera.resolution=[64,64]\n"
    "  fluovox render sheet.toml -o stack.ome.tif            z-stack of a scene with [stack]; .ome.zarr likewise\n"
    "  fluovox render sheet.toml -o stack.tif --format imagej --type uint16\n"
    "  fluovox render scene.toml -o slow.exr --tracking plain --seed 2      the reference to check the fast one by\n";

std::vector<std::string> overrides(const CommandLine& line) {
    std::vector<std::string> keys;
    if (line.values().count("set") > 0) keys = line.values()["set"].as<std::vector<std::string>>();
    if (line.values().count("samples") > 0)
        keys.push_back(fmt::format("render.samples={}", line.at_least("samples", 1)));
    if (line.values().count("seed") > 0) keys.push_back(fmt::format("render.seed={}", line.at_least("seed", 0)));
    return keys;
}

// The reference that the fast tracking is checked by. Only paths from the camera have it.
void choose_tracking(const CommandLine& line, SceneDescription& description) {
    if (line.values().count("tracking") == 0) return;
    const auto kind = line.values()["tracking"].as<std::string>();
    if (kind != "fast" && kind != "plain") line.fail("--tracking is fast or plain");
    description.render.plain_tracking = kind == "plain";
}

void require_tracking(const CommandLine& line, const Scene& scene) {
    if (!scene.description.render.plain_tracking || chosen_estimator(scene).name == "path") return;
    line.fail(
        fmt::format("--tracking plain goes with the estimator path, and this scene's is {}; add --set "
                    "render.estimator=path",
                    chosen_estimator(scene).name));
}

}  // namespace

void warn(const CommonOptions& common, const std::string& message) {
    if (!common.quiet) fmt::print(stderr, "warning: {}\n", message);
}

void note_estimator(const CommonOptions& common, const Scene& scene) {
    if (common.quiet) return;
    const EstimatorChoice estimator = chosen_estimator(scene);
    if (!estimator.why.empty()) fmt::print(stderr, "note: estimator {}, since {}\n", estimator.name, estimator.why);
    if (estimator.name == "cached") {
        fmt::print(stderr,
                   "note: cached is biased in one way: where in a voxel scattered light excites is not known\n");
    }
}

Provenance provenance_of(const Scene& scene) {
    Provenance provenance;
    provenance.scene_json = to_json(scene.description);
    provenance.seed = scene.description.render.seed;
    provenance.samples = scene.description.render.samples;
    provenance.estimator = chosen_estimator(scene).name;
    for (const Dye& dye : scene.dyes)
        provenance.dyes.push_back(dye.name);
    return provenance;
}

ExitCode run_render(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox render SCENE.toml -o OUT.exr|OUT.ome.tif|OUT.ome.zarr [options]", kExamples);
    auto add = line.options().add_options();
    add("scene", po::value<std::string>()->value_name("SCENE.toml"), "the scene file (also without the option's name)");
    add("output,o", po::value<std::string>()->value_name("OUT.exr"),
        "the image or stack; a preview OUT.png is written beside it");
    add("samples", po::value<std::int64_t>()->value_name("N"), "samples per pixel, instead of render.samples");
    add("seed", po::value<std::int64_t>()->value_name("N"), "instead of render.seed");
    add("set", po::value<std::vector<std::string>>()->value_name("KEY=VALUE"), "override a key of the scene file");
    add("tracking", po::value<std::string>()->value_name("KIND"),
        "fast (default), or plain: one bound for each grid and values between eight voxels looked up from its root, "
        "slower; the same image within its noise (fluovox diff). For the estimator path");
    add_stack_options(line);
    line.positional("scene", 1);
    if (!line.parse(arguments)) return ExitCode::Ok;
    if (line.values().count("scene") == 0) line.fail("which scene?");
    if (line.values().count("output") == 0) line.fail("where to? -o OUT.exr");
    const fs::path output = line.values()["output"].as<std::string>();
    const std::optional<StackFormat> format = stack_format(line, output);
    if (!format) line.fail("the image is an OpenEXR file: -o OUT.exr; a stack also .ome.tif or .ome.zarr");

    const auto begin = std::chrono::steady_clock::now();
    SceneDescription description = load_scene_description(line.values()["scene"].as<std::string>(), overrides(line));
    if (!description.stack && format != StackFormat::Exr)
        line.fail("the image is an OpenEXR file: -o OUT.exr (only scenes with [stack] make stacks)");
    if (!description.stack) {
        require_no_stack_options(line);
        require_writable(output);
    }
    choose_tracking(line, description);
    const Scene scene = build_scene(std::move(description));
    require_tracking(line, scene);
    for (const std::string& remark : scene.description.remarks)
        warn(line.common(), remark);
    for (const std::string& warning : scene.warnings)
        warn(line.common(), warning);
    note_estimator(line.common(), scene);
    if (scene.description.stack) return render_stack(line, scene, output, *format);

    RenderResult result = [&] {
        const auto progress = make_progress(line.common());
        return render(scene, *progress);
    }();
    if (result.stopped) {
        fmt::print(stderr, "fluovox: stopped; nothing was written\n");
        return ExitCode::Stopped;
    }
    const Provenance provenance = provenance_of(scene);
    save_exr(output, result.film, scene.description.film, provenance);
    const fs::path preview = fs::path(output).replace_extension(".png");
    save_preview(preview, make_preview(result.film, scene.description.film));

    const RenderedImage image = make_image(result.film, scene.description.film, provenance);
    const bool converts = !scene.dyes.empty() && scene.description.render.fluorescence_orders != 0;
    if (is_dark(result.film, converts ? kFluorescenceLayer : kTotalLayer)) {
        warn(line.common(), converts ? "the image has no fluorescence" : "the image is black");
        for (const std::string& reason : reasons_for_darkness(scene))
            warn(line.common(), reason);
    }
    if (image.nan_count > 0)
        warn(line.common(), fmt::format("{} samples were not finite and count as zero", image.nan_count));
    if (image.bound_violations > 0)
        warn(line.common(), fmt::format("{} bounds were exceeded: the image is biased", image.bound_violations));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const RelativeErrors error = relative_errors(result.film, image.display_layer(), BrightestOf::AllPixels);
    const bool has_light = !is_dark(result.film, image.layers[static_cast<std::size_t>(image.display_layer())].c_str());
    if (line.common().json) {
        const nlohmann::ordered_json json = {
            {"outputs", {output.string(), preview.string()}},
            {"seconds", seconds},
            {"samples", provenance.samples},
            {"threads", tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)},
            {"estimator", provenance.estimator},
            {"nan_count", image.nan_count},
            {"bound_violations", image.bound_violations},
            {"median_relative_error", json_or_null(error.all)},
            {"bright_relative_error", json_or_null(error.brightest)},
            {"real_collisions", result.counts.real_collisions},
            {"null_collisions", result.counts.null_collisions},
            {"shadow_collisions", result.counts.shadow_collisions},
            {"grid_lookups", result.counts.grid_lookups},
            {"peak_memory_bytes", peak_resident_bytes()},
        };
        fmt::print("{}\n", json.dump(2));
    } else {
        fmt::print("{}\n{}\n", output.string(), preview.string());
        if (!line.common().quiet) {
            fmt::print(stderr,
                       "{} x {} pixels, {} samples each, estimator {}, {:.1f} s; median relative error {}, {} "
                       "in the brightest tenth\n",
                       image.width, image.height, provenance.samples, provenance.estimator, seconds,
                       relative_error_text(error.all, has_light), relative_error_text(error.brightest, has_light));
        }
    }
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
