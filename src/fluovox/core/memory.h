#pragma once

#include <cstdint>

namespace fluovox {

/// The most memory that this process ever held at once, in bytes (resident set).
std::uint64_t peak_resident_bytes();

}  // namespace fluovox
