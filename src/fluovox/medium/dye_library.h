#pragma once

#include "fluovox/medium/dye.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// All dyes compiled in, in the order of the library's table.
const std::vector<Dye>& dye_library();

/// A dye found by name, and a remark where the name stands for another ("GFP" means EGFP here).
struct DyeMatch {
    Dye dye;
    std::string remark;  ///< empty, or a sentence the output should repeat
};

/// Finds a dye by id or name, without regard to case; nothing when there is none.
std::optional<DyeMatch> find_dye(std::string_view name);

/// The closest names of the library, best first, for "did you mean".
std::vector<std::string> closest_dyes(std::string_view name);

/// Reads a user's dye file (TOML; its keys are in the README). Throws SceneError with the place.
Dye load_dye(const std::filesystem::path& file);

/// `name` is a library name, or the path of a dye file (it ends in ".toml"). A relative path starts at `folder`.
/// Throws SceneError at `where` with the closest names when there is no such dye.
DyeMatch resolve_dye(const std::string& name, const std::filesystem::path& folder);

}  // namespace fluovox
