#pragma once

// Internal to the module: the only header that shows toml++.

#include "fluovox/core/error.h"

#include <toml++/toml.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fluovox {

/// A parsed scene file with its overrides put in.
struct TomlDocument {
    toml::table root;
    std::string file;
    std::vector<std::pair<std::string, std::string>> overridden;  ///< key path and option as typed, latest first
};

/// Parses `text`; throws SceneError where it is no TOML.
TomlDocument parse_toml(const std::string& text, const std::string& file);

/// Replaces or adds one value; `option` is `KEY=VALUE`. Throws UsageError when it is not, SceneError when the path
/// leads through something that is neither table nor array.
void apply_override(TomlDocument& document, const std::string& option);

/// Where the value at `path` comes from: the option that set it, or its place in the file.
SourceLocation location_of(const TomlDocument& document, const toml::source_region& region, std::string_view path);

/// A value as it may be shown in a message: in one line, short, without bytes that upset a terminal.
/// Empty for tables.
std::string shown(const toml::node& value);
std::string shown(std::string_view text, std::size_t most = 60);

}  // namespace fluovox
