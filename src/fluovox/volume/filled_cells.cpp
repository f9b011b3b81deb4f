#include "fluovox/volume/filled_cells.h"

namespace fluovox {
namespace {

// The 16 bits z fastest, four to a row, at the beginnings of rows of eight.
std::uint64_t in_rows_of_8(std::uint64_t bits) {
    bits = (bits | bits << 8U) & 0x00ff00ffU;
    return (bits | bits << 4U) & 0x0f0f0f0fU;
}

// Of a layer: at even places, what is set there or at the next two along z; `above` is the layer of the next brick.
std::uint64_t paired_along_z(std::uint64_t layer, std::uint64_t above) {
    constexpr std::uint64_t kFirst = 0x0101010101010101;
    constexpr std::uint64_t kEven = 0x5555555555555555;
    const std::uint64_t two_on = (layer >> 2U & ~(kFirst << 6U | kFirst << 7U)) | (above & kFirst) << 6U;
    return (layer | layer >> 1U | two_on) & kEven;
}

// The same for even rows.
std::uint64_t paired_along_y(std::uint64_t layer, std::uint64_t above) {
    constexpr std::uint64_t kEvenRows = 0x00ff00ff00ff00ff;
    return (layer | layer >> 8U | layer >> 16U | (above & 0xffU) << 48U) & kEvenRows;
}

// The bits at even places of even rows, 16 of them, side by side.
std::uint64_t side_by_side(std::uint64_t bits) {
    bits = (bits | bits >> 1U) & 0x0033003300330033;
    bits = (bits | bits >> 2U) & 0x000f000f000f000f;
    return (bits | bits >> 12U | bits >> 24U | bits >> 36U) & 0xffffU;
}

}  // namespace

void BrickVoxels::set_block(unsigned block, std::uint64_t voxels) {
    const std::size_t first = block & 4U;
    const unsigned corner = (block & 2U) << 4U | (block & 1U) << 2U;
    for (std::size_t x = 0; x < 4; ++x)
        layers_[first + x] |= in_rows_of_8(voxels >> (16 * x) & 0xffffU) << corner;
}

std::uint64_t filled_cells(const std::array<const BrickVoxels*, 8>& bricks) {
    const auto layer = [&](std::size_t x) {
        const std::size_t next = x < 8 ? 0 : 4;
        const auto along_z = [&](std::size_t y) {
            return paired_along_z(bricks[next + y]->layer(x & 7U), bricks[next + y + 1]->layer(x & 7U));
        };
        return paired_along_y(along_z(0), along_z(2));
    };
    std::uint64_t cells = 0;
    std::uint64_t first = layer(0);
    for (std::size_t x = 0; x < 8; x += 2) {
        const std::uint64_t last = layer(x + 2);
        cells |= side_by_side(first | layer(x + 1) | last) << (8 * x);
        first = last;
    }
    return cells;
}

}  // namespace fluovox
