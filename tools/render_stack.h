#pragma once

// What `fluovox render` does with a scene that has a [stack].

#include "fluovox/image/rendered_image.h"
#include "fluovox/image/stack_file.h"
#include "fluovox/scene/scene.h"

#include "command.h"

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace fluovox::tools {

/// Prints a warning on stderr unless the user wants quiet.
void warn(const CommonOptions& common, const std::string& message);

/// How an image of this scene comes about, for its file.
Provenance provenance_of(const Scene& scene);

void add_stack_options(CommandLine& line);

/// By `--format`, otherwise by the file's name; nothing where that says none. Throws UsageError for an unknown format,
/// and for a name whose ending says another one.
std::optional<StackFormat> stack_format(const CommandLine& line, const std::filesystem::path& output);

/// Throws UsageError where options were given that do nothing for a single image.
void require_no_stack_options(const CommandLine& line);

/// `--truth labels,photons` as a set; "all" stands for every kind.
std::set<std::string> read_truth(const CommandLine& line);

/// `stack.ome.tif` as `stack` and `.ome.tif`.
std::pair<std::string, std::string> split_stack_name(const std::filesystem::path& path);

/// Programs that read the format.
const char* how_to_open(StackFormat format);

/// Renders all planes and views, going on where an earlier run was stopped.
ExitCode render_stack(const CommandLine& line, const Scene& scene, const std::filesystem::path& output,
                      StackFormat format);

}  // namespace fluovox::tools
