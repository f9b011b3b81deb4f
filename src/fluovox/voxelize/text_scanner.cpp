#include "fluovox/core/error.h"
#include "fluovox/voxelize/mesh_readers.h"

#include <charconv>
#include <cmath>
#include <cstdlib>

namespace fluovox {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";

}  // namespace

bool TextScanner::next_line(char comment) {
    while (!rest_.empty()) {
        const auto end = rest_.find('\n');
        line_ = rest_.substr(0, end);
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        ++line_number_;
        const auto begin = line_.find_first_not_of(kBlanks);
        if (begin == std::string_view::npos || line_[begin] == comment) continue;
        line_.remove_prefix(begin);
        return true;
    }
    line_ = {};
    return false;
}

std::string_view TextScanner::token() {
    const auto begin = line_.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) {
        line_ = {};
        return {};
    }
    auto end = line_.find_first_of(kBlanks, begin);
    if (end == std::string_view::npos) end = line_.size();
    const auto token = line_.substr(begin, end - begin);
    line_.remove_prefix(end);
    return token;
}

double TextScanner::number() {
    return to_number(token(), *this);
}

long long TextScanner::integer() {
    return to_integer(token(), *this);
}

bool TextScanner::token_anywhere(char comment, std::string_view& found) {
    for (;;) {
        found = token();
        if (!found.empty() && found.front() == comment) line_ = {};
        if (!found.empty() && found.front() != comment) return true;
        if (!next_line(comment)) return false;
    }
}

double TextScanner::number_anywhere(char comment) {
    std::string_view found;
    if (!token_anywhere(comment, found)) fail("is truncated: a number is missing");
    return to_number(found, *this);
}

long long TextScanner::integer_anywhere(char comment) {
    std::string_view found;
    if (!token_anywhere(comment, found)) fail("is truncated: a number is missing");
    return to_integer(found, *this);
}

void TextScanner::fail(const std::string& message) const {
    throw InputError(name_ + ':' + std::to_string(line_number_) + ": " + message);
}

void TextScanner::fail_without_triangles(std::size_t vertices) const {
    fail("has no triangles: it ends here, after " + std::to_string(vertices) +
         " vertices and no faces (is the file truncated?)");
}

double to_number(std::string_view token, const TextScanner& where) {
    if (token.empty()) where.fail("a number is missing");
    double value = 0;
    const auto* const begin = token.data() + (token.front() == '+' ? 1 : 0);
    const auto* const end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    // Out of range is 0 or infinite as strtod has it; only infinite is a mistake.
    if (error == std::errc::result_out_of_range) value = std::strtod(std::string(begin, stop).c_str(), nullptr);
    const bool read = error == std::errc{} || error == std::errc::result_out_of_range;
    if (!read || stop != end) where.fail('"' + std::string(token.substr(0, 40)) + "\" is not a number");
    if (!std::isfinite(value)) where.fail('"' + std::string(token.substr(0, 40)) + "\" is not a finite number");
    return value;
}

long long to_integer(std::string_view token, const TextScanner& where) {
    if (token.empty()) where.fail("a number is missing");
    long long value = 0;
    const auto* const begin = token.data() + (token.front() == '+' ? 1 : 0);
    const auto* const end = token.data() + token.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc{} || stop != end) {
        where.fail('"' + std::string(token.substr(0, 40)) + "\" is not a whole number");
    }
    return value;
}

}  // namespace fluovox
