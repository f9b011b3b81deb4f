#pragma once

#include "fluovox/core/bits.h"
#include "fluovox/core/huge_pages.h"
#include "fluovox/volume/fixed_point.h"

#include <cstddef>
#include <cstdint>

namespace fluovox {

/// Which places of a box have bricks, and the levels of their bounds. Bricks are numbered as their places lie: by x, y,
/// then z. Rays through empty space read no more than a bit per place, so that most of it stays near the processor.
class BrickDirectory {
public:
    static constexpr int kPlacesInWord = 64;

    /// Places one above the other along z. A column begins with a word of its own.
    struct Word {
        std::uint64_t occupied = 0;  ///< bit by bit from the lowest place up
        std::uint32_t first = 0;     ///< of its bricks

        /// The brick at a place that has one.
        std::size_t brick(unsigned place) const {
            return first + static_cast<std::size_t>(count_bits(occupied & ((std::uint64_t{1} << place) - 1)));
        }
    };
    /// A place by itself; level 0 where it is empty.
    struct Entry {
        std::uint32_t brick : 24 = 0;
        std::uint32_t level : 8 = 0;
    };

    /// Of no places, or of a box of so many that are all empty.
    BrickDirectory() = default;
    explicit BrickDirectory(Voxel count);

    /// Enters the next brick, with a level over 0.
    void add(Voxel at, std::uint8_t level);
    /// Once all are entered: where a box is full enough, its places are listed one by one besides.
    void finish();

    bool empty() const { return words_.empty(); }
    std::size_t size() const { return levels_.size(); }
    std::uint8_t level(std::size_t brick) const { return levels_[brick]; }

    /// Number of a place, by which words are found.
    std::size_t place(Voxel at) const { return column(at) * places_in_column() + static_cast<std::size_t>(at.z); }
    /// From a column to the next one along y.
    std::size_t places_in_column() const { return words_in_column_ * kPlacesInWord; }
    const Word& word(std::size_t place) const { return words_[place / kPlacesInWord]; }
    bool has(std::size_t place) const { return (word(place).occupied >> (place % kPlacesInWord) & 1U) != 0; }
    /// Of a place that has one.
    std::size_t brick(std::size_t place) const { return word(place).brick(place % kPlacesInWord); }

    /// True where there are entries: many steps of a ray meet a brick.
    bool is_dense() const { return !entries_.empty(); }
    /// Number of a place among the entries: a column follows the one before.
    std::size_t entry_place(Voxel at) const {
        return column(at) * static_cast<std::size_t>(count_.z) + static_cast<std::size_t>(at.z);
    }
    const Entry* entries() const { return entries_.data(); }

    std::size_t memory_bytes() const {
        return sizeof(Word) * words_.size() + levels_.size() + sizeof(Entry) * entries_.size();
    }
    /// What the words of a box take.
    static double bytes_of_words(Voxel count);

private:
    std::size_t column(Voxel at) const {
        return static_cast<std::size_t>(at.x) * static_cast<std::size_t>(count_.y) + static_cast<std::size_t>(at.y);
    }

    Voxel count_;
    std::size_t words_in_column_ = 0;
    HugePageVector<Word> words_;
    HugePageVector<std::uint8_t> levels_;  // of the bricks
    HugePageVector<Entry> entries_;        // of the places of a dense box
};

}  // namespace fluovox
