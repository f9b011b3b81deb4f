#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace fluovox {

/// Writes `path` so that no reader ever sees half of it: `write` gets a temporary path in the same folder,
/// which then takes the place of `path` in one step. An existing file survives any failure, and the temporary
/// one is removed. Throws OutputError (folder missing, not writable, disk full); errors of `write` pass through.
void write_atomically(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// Throws the OutputError that `write_atomically` would throw for a folder that is missing or not writable: to be asked
/// before long work, not after it.
void require_writable(const std::filesystem::path& path);

/// Writes `text` to `path` by `write_atomically`.
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace fluovox
