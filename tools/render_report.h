#pragma once

// What `fluovox render` says when it is done: of an image, and what stacks have in common with it.

#include "fluovox/transport/render.h"

#include "command.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace fluovox::tools {

/// Figures of what was rendered, an image or all planes of a stack together.
struct RunFigures {
    int samples = 0;  ///< per pixel
    std::string estimator;
    std::int64_t nan_count = 0, bound_violations = 0;
    std::optional<double> error, bright_error;  ///< medians of the relative standard error
    bool has_light = false;
};

struct ImageReport {
    std::filesystem::path output, preview;
    double seconds = 0;
    int width = 0, height = 0;
    TrackingCounts counts;
    RunFigures figures;
};

/// Warns of samples that were not finite and of bounds that were exceeded; `biased` is what then is biased.
void warn_of_samples(const CommonOptions& common, const RunFigures& figures, const char* biased);

/// Adds the figures, the number of threads among them.
void add_figures(nlohmann::ordered_json& json, const RunFigures& figures);

/// With --verbose: the most memory that the run held at once, reading of the grids included.
void print_peak_memory(const CommonOptions& common);

/// Names of files on stdout and figures on stderr, or JSON.
void print_image_report(const CommonOptions& common, const ImageReport& report);

}  // namespace fluovox::tools
