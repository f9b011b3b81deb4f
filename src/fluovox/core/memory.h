#pragma once

#include <cstdint>

namespace fluovox {

/// The most memory that this process ever held at once, in bytes (resident set).
std::uint64_t peak_resident_bytes();

/// Gives memory that was freed back to the system, where the C library keeps it for later: for those who have just
/// freed much more than what they made.
void release_freed_memory();

}  // namespace fluovox
