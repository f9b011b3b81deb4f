#pragma once

// What the projection of a finished stack says about the files beside it, so that a second run may trust them.

#include "fluovox/image/plane_store.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace fluovox::tools {

/// The keyword of the stamp in the projection's PNG.
inline constexpr const char* kStampRemark = "fluovox:stack";

/// What files hold: their size, and a SHA-256 of their bytes.
struct Content {
    std::uintmax_t bytes = 0;
    std::string digest;
};

struct StackStamp {
    std::string key;                       ///< the same for the same work
    std::map<std::string, Content> parts;  ///< by what they are: "stack", "labels" ...
    std::vector<PlaneFigures> planes;      ///< without the seconds, which differ between runs of the same work
};

/// One line of ASCII. The same work gives the same text.
std::string to_json(const StackStamp& stamp);

/// The stamp of a projection; nothing where the file is not whole, or has none.
std::optional<StackStamp> load_stamp(const std::filesystem::path& projection);

/// Of files, or of the one OME-Zarr folder that `paths` names; reads all of it. Throws InputError where something
/// cannot be read.
Content content_of(const std::vector<std::filesystem::path>& paths);

/// Whether the files still hold what was written. Reads them whole, unless their size tells already.
bool still_holds(const std::vector<std::filesystem::path>& paths, const Content& written);

}  // namespace fluovox::tools
