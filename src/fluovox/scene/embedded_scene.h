#pragma once

// Internal to the module: scenes out of images.

#include <filesystem>
#include <optional>
#include <string>

namespace fluovox {

/// The scene in an image or a stack that fluovox wrote, as its JSON; nothing for files that are not named like one.
/// Throws InputError for those that hold none.
std::optional<std::string> embedded_scene(const std::filesystem::path& file);

/// Whether a text is a scene as `to_json` writes it.
bool is_scene_json(const std::string& text);

/// Such a scene as a scene file: without what is only said for readers (the dyes' data, keys without a value). Throws
/// SceneError where it is no JSON.
std::string scene_file_of_json(const std::string& json, const std::string& file);

}  // namespace fluovox
