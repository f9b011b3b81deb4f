#include "fluovox/volume/brick_directory.h"

namespace fluovox {
namespace {

std::size_t words_along(int places) {
    constexpr int kWord = BrickDirectory::kPlacesInWord;
    return static_cast<std::size_t>((places + kWord - 1) / kWord);
}

}  // namespace

BrickDirectory::BrickDirectory(Voxel count)
    : count_(count),
      words_in_column_(words_along(count.z)),
      words_(static_cast<std::size_t>(count.x) * static_cast<std::size_t>(count.y) * words_in_column_) {}

void BrickDirectory::add(Voxel at, std::uint8_t level) {
    const std::size_t to = place(at);
    Word& word = words_[to / kPlacesInWord];
    if (word.occupied == 0) word.first = static_cast<std::uint32_t>(size());
    word.occupied |= std::uint64_t{1} << (to % kPlacesInWord);
    levels_.push_back(level);
}

void BrickDirectory::finish() {
    constexpr std::size_t kPlacesPerBrick = 5;        // fewer where a step by columns saves none
    constexpr std::uint32_t kMost = (1U << 24U) - 1;  // that an entry can tell apart
    const std::size_t places =
        static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) * static_cast<std::size_t>(count_.z);
    if (size() * kPlacesPerBrick < places || size() > kMost) return;
    entries_.resize(places);
    std::size_t next = 0;
    for (Voxel at; at.x < count_.x; ++at.x) {
        for (at.y = 0; at.y < count_.y; ++at.y) {
            for (at.z = 0; at.z < count_.z; ++at.z) {
                if (!has(place(at))) continue;
                entries_[entry_place(at)] = {static_cast<std::uint32_t>(next) & kMost, levels_[next]};
                ++next;
            }
        }
    }
}

double BrickDirectory::bytes_of_words(Voxel count) {
    return static_cast<double>(sizeof(Word)) * count.x * count.y * static_cast<double>(words_along(count.z));
}

}  // namespace fluovox
