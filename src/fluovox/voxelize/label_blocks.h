#pragma once

// How volumes of labels become leaves and tiles of grids.

#include <openvdb/openvdb.h>

#include <cstdint>
#include <string>
#include <vector>

namespace fluovox {

/// What becomes of one label.
struct BlockLabel {
    std::uint64_t label = 0;
    int dye = -1;   ///< -1: nothing
    int grid = -1;  ///< number of its grid
    float value = 0;
};

/// A grid of one dye, or (no dye) of labels.
struct BlockGrid {
    std::string dye;
    openvdb::GridBase::Ptr grid;
};

/// Eight slices of numbered labels: a layer of leaves.
class LabelSlab {
public:
    LabelSlab(std::int64_t width, std::int64_t height);

    std::int64_t width() const { return width_; }
    std::int64_t height() const { return height_; }
    std::uint32_t* row(std::int64_t y, std::int64_t z) { return numbers_.data() + place(y, z); }
    const std::uint32_t* row(std::int64_t y, std::int64_t z) const { return numbers_.data() + place(y, z); }
    static bool is_last_of_block(std::int64_t z) { return z % kSide == kSide - 1; }

    static constexpr std::int64_t kSide = 8;

private:
    std::size_t place(std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>(((z % kSide) * height_ + y) * width_);
    }

    std::int64_t width_, height_;
    std::vector<std::uint32_t> numbers_;
};

/// Puts layers of leaves into grids.
class BlockFiller {
public:
    /// `grids`: which there shall be. `max_bytes`: an estimate above it is an InputError.
    BlockFiller(const std::vector<BlockGrid>& grids, double max_bytes);

    /// The layer that slice `z` is the last one of.
    void add(const LabelSlab& slab, std::int64_t z, const std::vector<BlockLabel>& labels);

    /// The grids, with a transform.
    std::vector<BlockGrid> finish(const openvdb::math::Transform::Ptr& transform);

private:
    std::vector<std::string> dyes_;
    std::vector<openvdb::FloatGrid::Ptr> floats_;  // of the dyes
    openvdb::Int64Grid::Ptr labels_;               // where wanted
    double max_bytes_;
    double bytes_ = 0;
};

}  // namespace fluovox
