#include "fluovox/volume/brick_directory.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace fluovox {

bool BrickDirectory::fill(const std::vector<std::int32_t>& bricks, std::vector<std::uint8_t> levels) {
    offsets_.assign(bricks.size(), kNone);
    firsts_.assign((bricks.size() + kRun - 1) / kRun, std::numeric_limits<std::uint32_t>::max());
    for (std::size_t slot = 0; slot < bricks.size(); ++slot) {
        if (bricks[slot] >= 0)
            firsts_[slot / kRun] = std::min(firsts_[slot / kRun], static_cast<std::uint32_t>(bricks[slot]));
    }
    for (std::size_t slot = 0; slot < bricks.size(); ++slot) {
        if (bricks[slot] < 0) continue;
        const std::uint32_t offset = static_cast<std::uint32_t>(bricks[slot]) - firsts_[slot / kRun];
        if (offset >= kNone) return offsets_.clear(), false;
        offsets_[slot] = static_cast<std::uint16_t>(offset);
    }
    levels_ = std::move(levels);
    return true;
}

}  // namespace fluovox
