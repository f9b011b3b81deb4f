#include "stack_report.h"

#include "fluovox/core/memory.h"
#include "fluovox/image/relative_error.h"
#include "fluovox/scene/stack.h"
#include "fluovox/transport/darkness.h"

#include "json_or_null.h"
#include "render_report.h"
#include "render_stack.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>

namespace fluovox::tools {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> median(std::vector<double> values) {
    if (values.empty()) return std::nullopt;
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// All planes taken together.
RunFigures figures_of(const std::vector<PlaneFigures>& planes) {
    RunFigures run;
    std::vector<double> errors;
    std::vector<double> bright;
    for (const PlaneFigures& plane : planes) {
        run.nan_count += plane.nan_count;
        run.bound_violations += plane.bound_violations;
        run.has_light = run.has_light || plane.max_value > 0;
        if (plane.median_relative_error) errors.push_back(*plane.median_relative_error);
        if (plane.bright_relative_error) bright.push_back(*plane.bright_relative_error);
    }
    run.error = median(std::move(errors));
    run.bright_error = median(std::move(bright));
    return run;
}

Json planes_json(const Scene& scene, const std::vector<PlaneFigures>& planes) {
    const StackDescription& stack = *scene.description.stack;
    const auto count = static_cast<std::size_t>(plane_count(stack));
    Json json = Json::array();
    for (std::size_t image = 0; image < planes.size(); ++image) {
        const PlaneFigures& figures = planes[image];
        json.push_back({{"view", image / count},
                        {"plane", image % count},
                        {"offset_um", plane_offset_um(stack, static_cast<int>(image % count))},
                        {"seconds", json_or_null(figures.seconds)},
                        {"median_relative_error", json_or_null(figures.median_relative_error)},
                        {"bright_relative_error", json_or_null(figures.bright_relative_error)}});
    }
    return json;
}

}  // namespace

void warn_of_planes(const CommandLine& line, const Scene& scene, const std::vector<PlaneFigures>& planes) {
    const auto dark = std::count_if(planes.begin(), planes.end(), [](const auto& plane) { return plane.is_dark; });
    if (dark == static_cast<std::ptrdiff_t>(planes.size())) {
        warn(line.common(), "every plane is black");
        for (const std::string& reason :
             reasons_for_darkness(scene_at(scene, 0, plane_count(*scene.description.stack) / 2)))
            warn(line.common(), reason);
    } else if (dark > 0) {
        warn(line.common(), fmt::format("{} of {} planes are black", dark, planes.size()));
    }
    warn_of_samples(line.common(), figures_of(planes), "the images are");
}

void print_stack_report(const CommandLine& line, const Scene& scene, const StackReport& report) {
    const SceneDescription& description = scene.description;
    RunFigures figures = figures_of(report.planes);
    figures.samples = description.render.samples;
    figures.estimator = report.estimator;
    std::vector<std::string> names;
    for (const std::filesystem::path& path : report.outputs)
        names.push_back(path.string());
    if (line.common().json) {
        Json json = {
            {"outputs", names}, {"finished_before", !report.seconds}, {"seconds", json_or_null(report.seconds)}};
        add_figures(json, figures);
        json["planes"] = planes_json(scene, report.planes);
        json["peak_memory_bytes"] = peak_resident_bytes();
        fmt::print("{}\n", json.dump(2));
        return;
    }
    for (const std::string& name : names)
        fmt::print("{}\n", name);
    if (line.common().quiet) return;
    if (!report.seconds) {
        fmt::print(stderr, "{} is finished already\n", report.output.string());
    } else {
        fmt::print(
            stderr,
            "{} planes of {} x {} pixels, {} channels, {} sample{} each, estimator {}, {:.1f} s; median relative "
            "error {}, in the brightest tenth {}\n",
            report.planes.size(), description.camera.width, description.camera.height, description.film.channels.size(),
            description.render.samples, description.render.samples == 1 ? "" : "s", report.estimator, *report.seconds,
            relative_error_text(figures.error, figures.has_light),
            relative_error_text(figures.bright_error, figures.has_light));
    }
    fmt::print(stderr, "Open with {}\n", how_to_open(report.format));
    print_peak_memory(line.common());
}

}  // namespace fluovox::tools
