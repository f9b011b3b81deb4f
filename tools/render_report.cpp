#include "render_report.h"

#include "fluovox/core/memory.h"
#include "fluovox/image/relative_error.h"

#include "json_or_null.h"
#include "render_stack.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cstdio>

namespace fluovox::tools {

void warn_of_samples(const CommonOptions& common, const RunFigures& figures, const char* biased) {
    if (figures.nan_count > 0)
        warn(common, fmt::format("{} samples were not finite and count as zero", figures.nan_count));
    if (figures.bound_violations > 0)
        warn(common, fmt::format("{} bounds were exceeded: {} biased", figures.bound_violations, biased));
}

void add_figures(nlohmann::ordered_json& json, const RunFigures& figures) {
    json["samples"] = figures.samples;
    json["threads"] = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    json["estimator"] = figures.estimator;
    json["nan_count"] = figures.nan_count;
    json["bound_violations"] = figures.bound_violations;
    json["median_relative_error"] = json_or_null(figures.error);
    json["bright_relative_error"] = json_or_null(figures.bright_error);
}

void print_peak_memory(const CommonOptions& common) {
    if (common.verbose && !common.quiet)
        fmt::print(stderr, "peak memory {:.0f} MB\n", static_cast<double>(peak_resident_bytes()) * 1e-6);
}

void print_image_report(const CommonOptions& common, const ImageReport& report) {
    const RunFigures& figures = report.figures;
    if (common.json) {
        nlohmann::ordered_json json = {{"outputs", {report.output.string(), report.preview.string()}},
                                       {"seconds", report.seconds}};
        add_figures(json, figures);
        json["real_collisions"] = report.counts.real_collisions;
        json["null_collisions"] = report.counts.null_collisions;
        json["shadow_collisions"] = report.counts.shadow_collisions;
        json["grid_lookups"] = report.counts.grid_lookups;
        json["peak_memory_bytes"] = peak_resident_bytes();
        fmt::print("{}\n", json.dump(2));
        return;
    }
    fmt::print("{}\n{}\n", report.output.string(), report.preview.string());
    if (common.quiet) return;
    fmt::print(
        stderr,
        "{} x {} pixels, {} sample{} each, estimator {}, {:.1f} s; median relative error {}, {} in the brightest "
        "tenth\n",
        report.width, report.height, figures.samples, figures.samples == 1 ? "" : "s", figures.estimator,
        report.seconds, relative_error_text(figures.error, figures.has_light),
        relative_error_text(figures.bright_error, figures.has_light));
    print_peak_memory(common);
}

}  // namespace fluovox::tools
