#pragma once

#include <cstdint>

namespace fluovox {

/// Bits that are set. (std::popcount calls a function on processors that may lack the instruction.)
constexpr int count_bits(std::uint64_t bits) {
    bits -= (bits >> 1U) & 0x5555555555555555ULL;
    bits = (bits & 0x3333333333333333ULL) + ((bits >> 2U) & 0x3333333333333333ULL);
    bits = (bits + (bits >> 4U)) & 0x0f0f0f0f0f0f0f0fULL;
    return static_cast<int>((bits * 0x0101010101010101ULL) >> 56U);
}

}  // namespace fluovox
