#pragma once

// Internal: readers of the stacks that fluovox writes, one for each format. Not installed.

#include "fluovox/image/stack_info.h"

#include <filesystem>
#include <string>

namespace fluovox {

/// What a stack says of itself, and its values; `source` throws InputError where the file is damaged.
struct OpenStack {
    StackInfo info;
    PlaneSource source;
};

/// All throw InputError for what is not such a stack, or damaged.
OpenStack open_tiff_stack(const std::filesystem::path& path);
OpenStack open_zarr_stack(const std::filesystem::path& folder);
/// `stem` is what comes before `exr_plane_ending`.
OpenStack open_exr_stack(const std::filesystem::path& stem);

/// What `stack_info_from_json` makes of a text of a file; InputError where it is damaged or says impossible sizes.
StackInfo checked_stack_info(const std::string& json, const std::filesystem::path& path);

/// Names what is read, for messages about anything else.
inline constexpr const char* kStacksRead =
    "an OME-TIFF, an ImageJ TIFF, an OME-Zarr folder or planes of .exr, as fluovox render writes a scene with a "
    "[stack]";

}  // namespace fluovox
