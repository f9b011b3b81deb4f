#include "fluovox/volume/brick_directory.h"

namespace fluovox {

bool BrickDirectory::add(std::size_t place, std::uint32_t brick, std::uint8_t level) {
    Run& run = runs_[place / kRun];
    if (levels_of(run) == 0) run.first = brick;
    run.levels[place % kRun] = level;
    return level != 0 && this->brick(place) == brick;
}

}  // namespace fluovox
