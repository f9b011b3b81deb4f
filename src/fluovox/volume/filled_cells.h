#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace fluovox {

/// A bit for each voxel of a brick of 8^3. Blocks of 4^3 and cells of 2^3 in it are numbered z fastest.
class BrickVoxels {
public:
    /// Sets the voxels of one of its blocks, whose bits are z fastest too.
    void set_block(unsigned block, std::uint64_t voxels);

    /// Bit 8 y + z of the layer x.
    std::uint64_t layer(std::size_t x) const { return layers_[x]; }

private:
    std::array<std::uint64_t, 8> layers_{};
};

/// Cells of a brick in which a trilinear field is not zero everywhere, where voxels that are not zero are set. A cell
/// reaches from its first voxel to the first ones of the next cells, so the bricks on the upper sides count: 4, 2 and 1
/// for those next along x, y and z, 0 for the brick itself.
std::uint64_t filled_cells(const std::array<const BrickVoxels*, 8>& bricks);

}  // namespace fluovox
