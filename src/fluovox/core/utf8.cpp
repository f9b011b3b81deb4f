#include "fluovox/core/utf8.h"

namespace fluovox {

char32_t next_character(std::string_view text, std::size_t& at) {
    const auto byte = static_cast<unsigned char>(text[at++]);
    if (byte < 0x80) return byte;
    const int more = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : 1;
    if (byte < 0xC2 || byte > 0xF4) return 0xFFFD;
    char32_t character = byte & (0x3FU >> static_cast<unsigned>(more));
    for (int i = 0; i < more; ++i) {
        if (at >= text.size() || (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U) return 0xFFFD;
        character = (character << 6U) | (static_cast<unsigned char>(text[at++]) & 0x3FU);
    }
    return character;
}

void append_utf8(std::string& out, char32_t c) {
    const auto put = [&](char32_t byte) { out += static_cast<char>(byte); };
    if (c < 0x80) return put(c);
    if (c < 0x800) {
        put(0xC0U | (c >> 6U));
    } else {
        if (c < 0x10000) {
            put(0xE0U | (c >> 12U));
        } else {
            put(0xF0U | (c >> 18U));
            put(0x80U | ((c >> 12U) & 0x3FU));
        }
        put(0x80U | ((c >> 6U) & 0x3FU));
    }
    put(0x80U | (c & 0x3FU));
}

std::u16string to_utf16(std::string_view text) {
    std::u16string wide;
    for (std::size_t at = 0; at < text.size();) {
        char32_t c = next_character(text, at);
        if (c > 0x10FFFF || (c >= 0xD800 && c < 0xE000)) c = 0xFFFD;
        if (c < 0x10000) {
            wide += static_cast<char16_t>(c);
        } else {
            wide += static_cast<char16_t>(0xD800U + ((c - 0x10000U) >> 10U));
            wide += static_cast<char16_t>(0xDC00U + ((c - 0x10000U) & 0x3FFU));
        }
    }
    return wide;
}

std::string to_utf8(std::u16string_view text) {
    const auto is_low = [](char16_t unit) { return unit >= 0xDC00 && unit < 0xE000; };
    std::string narrow;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const char16_t unit = text[at];
        if (unit < 0xD800 || unit >= 0xE000) {
            append_utf8(narrow, unit);
        } else if (!is_low(unit) && at + 1 < text.size() && is_low(text[at + 1])) {
            append_utf8(narrow, 0x10000U + ((unit - 0xD800U) << 10U) + (text[at + 1] - 0xDC00U));
            ++at;
        } else {
            append_utf8(narrow, 0xFFFD);
        }
    }
    return narrow;
}

}  // namespace fluovox
