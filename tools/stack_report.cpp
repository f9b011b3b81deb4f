#include "stack_report.h"

#include "fluovox/core/memory.h"
#include "fluovox/image/relative_error.h"
#include "fluovox/scene/stack.h"
#include "fluovox/transport/darkness.h"

#include "json_or_null.h"
#include "render_stack.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

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
struct Summary {
    std::int64_t nan_count = 0, bound_violations = 0;
    std::optional<double> error, bright_error;
    bool has_light = false;
    int dark = 0;

    explicit Summary(const std::vector<PlaneFigures>& planes) {
        std::vector<double> errors;
        std::vector<double> bright;
        for (const PlaneFigures& plane : planes) {
            nan_count += plane.nan_count;
            bound_violations += plane.bound_violations;
            has_light = has_light || plane.max_value > 0;
            dark += plane.is_dark ? 1 : 0;
            if (plane.median_relative_error) errors.push_back(*plane.median_relative_error);
            if (plane.bright_relative_error) bright.push_back(*plane.bright_relative_error);
        }
        error = median(std::move(errors));
        bright_error = median(std::move(bright));
    }
};

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
    const Summary summary(planes);
    if (summary.dark == static_cast<int>(planes.size())) {
        warn(line.common(), "every plane is black");
        for (const std::string& reason :
             reasons_for_darkness(scene_at(scene, 0, plane_count(*scene.description.stack) / 2)))
            warn(line.common(), reason);
    } else if (summary.dark > 0) {
        warn(line.common(), fmt::format("{} of {} planes are black", summary.dark, planes.size()));
    }
    if (summary.nan_count > 0)
        warn(line.common(), fmt::format("{} samples were not finite and count as zero", summary.nan_count));
    if (summary.bound_violations > 0)
        warn(line.common(), fmt::format("{} bounds were exceeded: the images are biased", summary.bound_violations));
}

void print_stack_report(const CommandLine& line, const Scene& scene, const StackReport& report) {
    const Summary summary(report.planes);
    const SceneDescription& description = scene.description;
    std::vector<std::string> names;
    for (const std::filesystem::path& path : report.outputs)
        names.push_back(path.string());
    if (line.common().json) {
        const Json json = {
            {"outputs", names},
            {"finished_before", !report.seconds},
            {"seconds", json_or_null(report.seconds)},
            {"samples", description.render.samples},
            {"threads", tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)},
            {"estimator", report.estimator},
            {"nan_count", summary.nan_count},
            {"bound_violations", summary.bound_violations},
            {"median_relative_error", json_or_null(summary.error)},
            {"bright_relative_error", json_or_null(summary.bright_error)},
            {"planes", planes_json(scene, report.planes)},
            {"peak_memory_bytes", peak_resident_bytes()},
        };
        fmt::print("{}\n", json.dump(2));
        return;
    }
    for (const std::string& name : names)
        fmt::print("{}\n", name);
    if (line.common().quiet) return;
    if (!report.seconds) {
        fmt::print(stderr, "{} is finished already\n", report.output.string());
    } else {
        fmt::print(stderr,
                   "{} planes of {} x {} pixels, {} channels, {} samples each, estimator {}, {:.1f} s; median relative "
                   "error {}, in the brightest tenth {}\n",
                   report.planes.size(), description.camera.width, description.camera.height,
                   description.film.channels.size(), description.render.samples, report.estimator, *report.seconds,
                   relative_error_text(summary.error, summary.has_light),
                   relative_error_text(summary.bright_error, summary.has_light));
    }
    fmt::print(stderr, "Open with {}\n", how_to_open(report.format));
}

}  // namespace fluovox::tools
