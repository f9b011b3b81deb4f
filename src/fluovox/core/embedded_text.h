#pragma once

#include <string_view>

namespace fluovox {

/// A text file compiled in by `fluovox_embed` (cmake/FluovoxEmbed.cmake), named by its path below src/fluovox, or
/// below the project for a file elsewhere. An unknown name is a mistake of ours (std::logic_error).
std::string_view embedded_text(std::string_view name);

}  // namespace fluovox
