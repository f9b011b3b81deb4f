#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

namespace fluovox {

/// The bricks in a box by place: two bytes per place, and one for the level of the bound, so that a walk through
/// empty space reads little.
class BrickDirectory {
public:
    static constexpr std::uint16_t kNone = 0xffff;

    bool empty() const { return offsets_.empty(); }
    bool has(std::size_t slot) const { return offsets_[slot] != kNone; }
    /// Levels of the bounds by place; 0 where there is no brick.
    const std::uint8_t* levels() const { return levels_.data(); }
    /// The first place from `slot` on that has a bound, of those before `end`; or `end`.
    std::size_t next_filled(std::size_t slot, std::size_t end) const {
        for (; slot + kWord <= end; slot += kWord) {
            if (const std::uint64_t word = levels_from(slot))
                return slot + static_cast<std::size_t>(std::countr_zero(word)) / 8;
        }
        while (slot < end && levels_[slot] == 0)
            ++slot;
        return slot;
    }
    /// The last place before `slot` that has a bound, of those from `begin` on, and one more; or `begin`.
    std::size_t last_filled(std::size_t begin, std::size_t slot) const {
        for (; slot >= begin + kWord; slot -= kWord) {
            if (const std::uint64_t word = levels_from(slot - kWord))
                return slot - static_cast<std::size_t>(std::countl_zero(word)) / 8;
        }
        while (slot > begin && levels_[slot - 1] == 0)
            --slot;
        return slot;
    }
    /// Of a place that has one.
    std::size_t brick(std::size_t slot) const { return firsts_[slot / kRun] + offsets_[slot]; }
    std::size_t memory_bytes() const { return 3 * offsets_.size() + 4 * firsts_.size(); }
    /// Per place its brick, or a negative number, and the level of its bound; false where they lie too far apart.
    bool fill(const std::vector<std::int32_t>& bricks, std::vector<std::uint8_t> levels);

private:
    static constexpr std::size_t kRun = 64;
    static constexpr std::size_t kWord = 8;  // levels looked at in one go
    static_assert(std::endian::native == std::endian::little);

    std::uint64_t levels_from(std::size_t slot) const {
        std::uint64_t word = 0;
        std::memcpy(&word, &levels_[slot], sizeof(word));
        return word;
    }

    std::vector<std::uint32_t> firsts_;  // least brick of each run of places
    std::vector<std::uint16_t> offsets_;
    std::vector<std::uint8_t> levels_;
};

}  // namespace fluovox
