#pragma once

#include "fluovox/image/png.h"

#include <filesystem>
#include <vector>

namespace fluovox {

/// The bytes of an animated PNG: the frames one after the other, for ever, each shown for `delay_ms`. Programs that do
/// not know animation show the first one. Throws std::invalid_argument unless there are frames, all of one size.
std::string to_apng(const std::vector<Picture>& frames, int delay_ms);

/// Writes it by `write_atomically`; throws OutputError.
void save_apng(const std::filesystem::path& path, const std::vector<Picture>& frames, int delay_ms);

}  // namespace fluovox
