#pragma once

// Internal: not installed.

#include <cstddef>
#include <string>
#include <string_view>

namespace fluovox {

/// The character that begins at byte `at` of a UTF-8 text, as its number; `at` moves behind it. 0xFFFD for what is no
/// UTF-8.
char32_t next_character(std::string_view text, std::size_t& at);

/// Appends the character `c` to a UTF-8 text.
void append_utf8(std::string& out, char32_t c);

/// UTF-8 as UTF-16 and back; what is not well formed becomes U+FFFD.
std::u16string to_utf16(std::string_view text);
std::string to_utf8(std::u16string_view text);

}  // namespace fluovox
