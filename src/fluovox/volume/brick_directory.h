#pragma once

#include "fluovox/core/huge_pages.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace fluovox {

/// The bricks of a box by place. Four places in a row have the levels of their bounds side by side, and beside them the
/// first of their bricks: once the level is read, the brick is known. Level 0 where there is none.
class BrickDirectory {
public:
    static constexpr std::size_t kRun = 4;  ///< places in a row; their bricks lie one after the other

    /// Of no places, or of so many that are all empty; the number a multiple of kRun.
    explicit BrickDirectory(std::size_t places = 0) : runs_(places / kRun) {}

    /// Enters a brick with a level over 0. Places in order; false where the bricks of a run are not one after the
    /// other.
    bool add(std::size_t place, std::uint32_t brick, std::uint8_t level);

    bool empty() const { return runs_.empty(); }
    bool has(std::size_t place) const { return level(place) != 0; }
    std::uint8_t level(std::size_t place) const { return runs_[place / kRun].levels[place % kRun]; }
    /// Of a place that has one.
    std::uint32_t brick(std::size_t place) const {
        const Run& run = runs_[place / kRun];
        return run.first + filled(run, place % kRun);
    }
    /// The first place from `place` on that has a brick, of those before `end`; or `end`.
    std::size_t next_filled(std::size_t place, std::size_t end) const;
    /// The last place before `place` that has a brick, of those from `begin` on, and one more; or `begin`.
    std::size_t last_filled(std::size_t begin, std::size_t place) const;
    std::size_t memory_bytes() const { return sizeof(Run) * runs_.size(); }

private:
    struct Run {
        std::array<std::uint8_t, kRun> levels{};
        std::uint32_t first = 0;
    };
    static_assert(std::endian::native == std::endian::little);

    static std::uint32_t levels_of(const Run& run) {
        std::uint32_t levels = 0;
        std::memcpy(&levels, run.levels.data(), sizeof(levels));
        return levels;
    }
    // How many of the first `count` places of a run, fewer than all, have a brick.
    static std::uint32_t filled(const Run& run, std::size_t count) {
        const std::uint32_t levels = levels_of(run) & ((1U << (8 * count)) - 1);
        const std::uint32_t tops = ((levels & 0x7f7f7f7fU) + 0x7f7f7f7fU) | levels;  // highest bits of bytes not 0
        return (((tops >> 7U) & 0x01010101U) * 0x01010101U) >> 24U;
    }

    HugePageVector<Run> runs_;
};

inline std::size_t BrickDirectory::next_filled(std::size_t place, std::size_t end) const {
    while (place < end) {
        const std::uint32_t ahead = levels_of(runs_[place / kRun]) >> (8 * (place % kRun));
        if (ahead != 0) {
            const std::size_t found = place + static_cast<std::size_t>(std::countr_zero(ahead)) / 8;
            return found < end ? found : end;
        }
        place += kRun - place % kRun;
    }
    return end;
}

inline std::size_t BrickDirectory::last_filled(std::size_t begin, std::size_t place) const {
    while (place > begin) {
        const std::size_t last = place - 1;
        const std::uint32_t behind = levels_of(runs_[last / kRun]) << (8 * (kRun - 1 - last % kRun));
        if (behind != 0) {
            const std::size_t passed = static_cast<std::size_t>(std::countl_zero(behind)) / 8;
            return place > begin + passed ? place - passed : begin;
        }
        place = last - last % kRun;
    }
    return begin;
}

}  // namespace fluovox
