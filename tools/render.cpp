#include "fluovox/transport/render.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/progress.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/preview.h"
#include "fluovox/image/relative_error.h"
#include "fluovox/image/rendered_image.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/darkness.h"

#include "commands.h"
#include "render_report.h"
#include "render_stack.h"

#include <fmt/format.h>

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
    "  fluovox render scene.toml -o slow.exr --tracking plain --seed 2      the reference to check the fast one by\n"
    "  fluovox render neuron.exr -o again.exr                the scene in an image or stack once more: the same "
    "bytes\n";

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

namespace {

CommandLine render_command_line() {
    CommandLine line("fluovox render SCENE.toml -o OUT.exr|OUT.ome.tif|OUT.ome.zarr [options]", kExamples);
    auto add = line.options().add_options();
    add("scene", po::value<std::string>()->value_name("SCENE.toml"), "the scene file (also without the option's name)");
    add("output,o", po::value<std::string>()->value_name("OUT.exr"),
        "the image or stack; a preview OUT.png is written beside it");
    add("samples", po::value<std::int64_t>()->value_name("N"), "samples per pixel, instead of render.samples");
    add("seed", po::value<std::int64_t>()->value_name("N"), "instead of render.seed");
    add("set", po::value<std::vector<std::string>>()->value_name("KEY=VALUE"), "override a key of the scene file");
    add("tracking", po::value<std::string>()->value_name("KIND"),
        "fast (default), or plain: one bound for each grid, values by OpenVDB's own interpolation in the file's tree, "
        "slower; the same image within its noise (fluovox diff). For the estimator path");
    add_stack_options(line);
    line.positional("scene", 1);
    return line;
}

/// Where the image goes, or the stack, and as what.
struct RenderOutput {
    fs::path path;
    StackFormat format = StackFormat::Exr;
};

RenderOutput output_of(const CommandLine& line) {
    if (line.values().count("scene") == 0) line.fail("which scene?");
    if (line.values().count("output") == 0) line.fail("where to? -o OUT.exr");
    const fs::path path = line.values()["output"].as<std::string>();
    const std::optional<StackFormat> format = stack_format(line, path);
    if (!format) line.fail("the image is an OpenEXR file: -o OUT.exr; a stack also .ome.tif or .ome.zarr");
    return {path, *format};
}

Scene load_scene(const CommandLine& line, const RenderOutput& output) {
    SceneDescription description = load_scene_description(line.values()["scene"].as<std::string>(), overrides(line));
    if (!description.stack) {
        if (output.format != StackFormat::Exr)
            line.fail("the image is an OpenEXR file: -o OUT.exr (only scenes with [stack] make stacks)");
        require_no_stack_options(line);
        require_writable(output.path);
    }
    choose_tracking(line, description);
    Scene scene = build_scene(std::move(description));
    require_tracking(line, scene);
    for (const std::string& remark : scene.description.remarks)
        warn(line.common(), remark);
    for (const std::string& warning : scene.warnings)
        warn(line.common(), warning);
    note_estimator(line.common(), scene);
    return scene;
}

void warn_of_darkness(const CommonOptions& common, const Scene& scene, const Film& film) {
    const bool converts = !scene.dyes.empty() && scene.description.render.fluorescence_orders != 0;
    if (!is_dark(film, converts ? kFluorescenceLayer : kTotalLayer)) return;
    warn(common, converts ? "the image has no fluorescence" : "the image is black");
    for (const std::string& reason : reasons_for_darkness(scene))
        warn(common, reason);
}

RunFigures figures_of(const RenderedImage& image, const Film& film) {
    RunFigures figures;
    figures.samples = image.provenance.samples;
    figures.estimator = image.provenance.estimator;
    figures.nan_count = image.nan_count;
    figures.bound_violations = image.bound_violations;
    const int layer = image.display_layer();
    const RelativeErrors errors = relative_errors(film, layer, BrightestOf::AllPixels);
    figures.error = errors.all;
    figures.bright_error = errors.brightest;
    figures.has_light = !is_dark(film, image.layers[static_cast<std::size_t>(layer)].c_str());
    return figures;
}

}  // namespace

ExitCode run_render(const std::vector<std::string>& arguments) {
    CommandLine line = render_command_line();
    if (!line.parse(arguments)) return ExitCode::Ok;
    const RenderOutput output = output_of(line);
    const auto begin = std::chrono::steady_clock::now();
    const Scene scene = load_scene(line, output);
    if (scene.description.stack) return render_stack(line, scene, output.path, output.format);

    const RenderResult result = [&] {
        const auto progress = make_progress(line.common());
        return render(scene, *progress);
    }();
    if (result.stopped) {
        fmt::print(stderr, "fluovox: stopped; nothing was written\n");
        return ExitCode::Stopped;
    }
    const FilmSpec& film = scene.description.film;
    const Provenance provenance = provenance_of(scene);
    save_exr(output.path, result.film, film, provenance);
    ImageReport report;
    report.output = output.path;
    report.preview = fs::path(output.path).replace_extension(".png");
    save_preview(report.preview, make_preview(result.film, film));

    const RenderedImage image = make_image(result.film, film, provenance);
    report.width = image.width;
    report.height = image.height;
    report.counts = result.counts;
    report.figures = figures_of(image, result.film);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    warn_of_darkness(line.common(), scene, result.film);
    warn_of_samples(line.common(), report.figures, "the image is");
    print_image_report(line.common(), report);
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
