#pragma once

// What `fluovox render` says of a stack when it is done.

#include "fluovox/image/plane_store.h"
#include "fluovox/image/stack_file.h"
#include "fluovox/scene/scene.h"

#include "command.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox::tools {

struct StackReport {
    std::filesystem::path output;
    std::vector<std::filesystem::path> outputs;  ///< all files, the stack and its companions
    StackFormat format = StackFormat::OmeTiff;
    std::string estimator;
    std::vector<PlaneFigures> planes;  ///< of all views
    std::optional<double> seconds;     ///< nothing: it was finished before, and not rendered
};

/// Warns of black planes, and of samples that were not finite or bounds that were exceeded.
void warn_of_planes(const CommandLine& line, const Scene& scene, const std::vector<PlaneFigures>& planes);

/// Names of files on stdout and figures on stderr, or JSON.
void print_stack_report(const CommandLine& line, const Scene& scene, const StackReport& report);

}  // namespace fluovox::tools
