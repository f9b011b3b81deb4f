#pragma once

#include "command.h"

#include <string>

namespace fluovox::tools {

/// Whether a file is named like an image or a stack of images, not like a grid.
bool is_image_name(const std::string& file);

/// What `info` says of an image or a stack that fluovox wrote: sizes, channels, how it came about; with `scene` the
/// scene that is in it, as JSON, and nothing else. Throws InputError for files of others.
void print_image_info(const CommonOptions& common, const std::string& file, bool scene);

}  // namespace fluovox::tools
