#pragma once

#include "fluovox/core/rng.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

namespace fluovox::testing {

/// A file with a few random edits, in its first `within` bytes (0: anywhere).
inline std::string damaged(std::string bytes, Rng& random, std::size_t within = 0) {
    const auto below = [&](std::size_t n) {
        return static_cast<std::size_t>(random.uniform() * static_cast<double>(n));
    };
    static const std::array<std::string, 12> kWords = {
        "-1", "4294967295", "9999999999999999999", "nan", "inf", "1e308", "(", "|", ")", "\n", "#", "-0"};
    const std::size_t edits = 1 + below(5);
    for (std::size_t i = 0; i < edits && !bytes.empty(); ++i) {
        const std::size_t at = below(within == 0 ? bytes.size() : std::min(within, bytes.size()));
        switch (below(6)) {
            case 0:
                bytes[at] = static_cast<char>(below(256));
                break;
            case 1:
                bytes.resize(at);
                break;
            case 2:
                bytes.erase(at, 1 + below(8));
                break;
            case 3:
                bytes.insert(at, kWords[below(kWords.size())]);
                break;
            case 4:
                bytes.insert(at, bytes.substr(below(bytes.size()), below(60)));
                break;
            default:
                bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(1U << below(8)));
                break;
        }
    }
    return bytes;
}

}  // namespace fluovox::testing
