#include "fluovox/core/text.h"

#include "fluovox/core/error.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

namespace fluovox {
namespace {

constexpr std::size_t kLargestText = std::size_t{256} << 20;

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// Bytes of the printable UTF-8 character that `text` begins with; 0 when it is none.
std::size_t printable_length(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    if (first < 0x80) return (first >= ' ' && first != 0x7f) || first == '\n' || first == '\t' ? 1 : 0;
    if (first < 0xc2 || first > 0xf4) return 0;
    const std::size_t length = first < 0xe0 ? 2 : (first < 0xf0 ? 3 : 4);
    if (text.size() < length) return 0;
    for (std::size_t i = 1; i < length; ++i)
        if ((byte(i) & 0xc0U) != 0x80) return 0;
    const bool control = first == 0xc2 && byte(1) < 0xa0;
    return control ? 0 : length;
}

}  // namespace

std::string load_text(const std::filesystem::path& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) throw InputError(path.string() + ": is a folder, not a file");
    errno = 0;
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw InputError(path.string() + ": cannot be read: " + std::strerror(errno));
    std::string text;
    std::vector<char> block(std::size_t{1} << 16);
    while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0) {
        text.append(block.data(), static_cast<std::size_t>(stream.gcount()));
        if (text.size() > kLargestText) throw InputError(path.string() + ": is larger than 256 MiB, not a text file");
    }
    if (stream.bad()) throw InputError(path.string() + ": cannot be read to its end");
    return text;
}

std::string lower_case(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), lower);
    return result;
}

std::string printable(std::string_view text) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string result;
    while (!text.empty()) {
        if (const std::size_t length = printable_length(text); length > 0) {
            result += text.substr(0, length);
            text.remove_prefix(length);
            continue;
        }
        const auto byte = static_cast<unsigned char>(text.front());
        result += "\\x";
        result += kDigits[byte >> 4U];
        result += kDigits[byte & 15U];
        text.remove_prefix(1);
    }
    return result;
}

int line_of_deep_key(std::string_view toml) {
    constexpr std::string_view kEndsKey = "\n=,[]{}";
    int line = 1;
    std::size_t dots = 0;
    for (const char c : toml) {
        if (c == '.' && ++dots > kDeepestKey) return line;
        if (kEndsKey.find(c) == std::string_view::npos) continue;
        dots = 0;
        if (c == '\n') ++line;
    }
    return 0;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
    // Three rows of the usual table: distances of the beginnings of `a` one and two letters shorter, and this one.
    std::vector<std::size_t> before(b.size() + 1);
    std::vector<std::size_t> last(b.size() + 1);
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j)
        row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::swap(before, last);
        std::swap(last, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1;
            row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + replaced});
            const bool swapped =
                i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
            if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
        }
    }
    return row[b.size()];
}

std::vector<std::string> closest_names(std::string_view name, const std::vector<std::string>& candidates,
                                       std::size_t count) {
    constexpr std::size_t kShortestStem = 3;
    const std::string wanted = lower_case(name).substr(0, 100);  // a name from a garbage file can be huge
    std::vector<std::pair<std::size_t, std::string>> near;
    for (const std::string& candidate : candidates) {
        const std::string known = lower_case(candidate);
        const std::size_t distance = edit_distance(wanted, known);
        const bool stem = std::min(wanted.size(), known.size()) >= kShortestStem &&
                          (known.rfind(wanted, 0) == 0 || wanted.rfind(known, 0) == 0);
        const std::size_t allowed = std::max<std::size_t>(1, std::max(wanted.size(), known.size()) / 3);
        if (distance <= allowed && distance < known.size()) {
            near.emplace_back(distance, candidate);
        } else if (stem) {
            near.emplace_back(allowed + 1, candidate);
        }
    }
    std::stable_sort(near.begin(), near.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> names;
    for (auto& [distance, candidate] : near) {
        if (names.size() < count) names.push_back(std::move(candidate));
    }
    return names;
}

std::string quoted_alternatives(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
        text += '"' + names[i] + '"';
    }
    return text;
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates) {
    const std::vector<std::string> names = closest_names(name, candidates);
    return names.empty() ? std::string() : "; did you mean " + quoted_alternatives(names) + '?';
}

}  // namespace fluovox
