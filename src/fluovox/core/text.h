#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// A whole text file. Throws InputError when it is missing, a folder, unreadable or larger than 256 MiB.
std::string load_text(const std::filesystem::path& path);

/// ASCII letters in lower case; other bytes as they are.
std::string lower_case(std::string_view text);

/// `text` as a terminal may show it: bytes that are no printable UTF-8 become `\x1b`; line breaks and tabs stay.
std::string printable(std::string_view text);

/// The most dots that a key of a TOML file may have: its parser calls itself for each.
inline constexpr std::size_t kDeepestKey = 256;

/// The first line of a TOML file with a key of more dots than that (or something alike); 0 when there is none.
int line_of_deep_key(std::string_view toml);

/// Least number of insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`,
/// without regard to ASCII case (Damerau's distance, restricted: no piece is edited twice).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// Those of `candidates` that `name` may be a slip for, best first, at most `count`: few edits for the length of the
/// name, or one begins with the other.
std::vector<std::string> closest_names(std::string_view name, const std::vector<std::string>& candidates,
                                       std::size_t count = 3);

/// `"a", "b" or "c"`; empty for no names.
std::string quoted_alternatives(const std::vector<std::string>& names);

/// `; did you mean "waist", "width" or "weight"?` from `closest_names`, to append to a message; empty when nothing is
/// close.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace fluovox
