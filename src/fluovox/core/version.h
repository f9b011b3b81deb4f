#pragma once

namespace fluovox {

/// The version of the library, "major.minor.patch".
const char* version();

}  // namespace fluovox
