#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace fluovox {

/// All bytes of a file. Throws InputError when it is missing, a folder or unreadable.
std::string load_bytes(const std::filesystem::path& file);

/// SHA-256 in 64 hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

}  // namespace fluovox
