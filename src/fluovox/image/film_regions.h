#pragma once

#include <algorithm>
#include <cstddef>

namespace fluovox {

/// The parts of an image whose mean has a variance of its own where pixels share samples: tiles of 8 x 8 pixels (fewer
/// at the right and at the bottom), row by row, and after them the whole image.
class FilmRegions {
public:
    static constexpr int kTile = 8;

    FilmRegions(int width, int height)
        : width_(width),
          height_(height),
          tiles_x_((width + kTile - 1) / kTile),
          tiles_y_((height + kTile - 1) / kTile) {}

    int tiles_x() const { return tiles_x_; }
    std::size_t tiles() const { return static_cast<std::size_t>(tiles_x_) * static_cast<std::size_t>(tiles_y_); }
    std::size_t whole() const { return tiles(); }
    std::size_t count() const { return tiles() + 1; }

    /// The tile of a pixel (row x width + column).
    std::size_t tile_of(std::size_t pixel) const {
        const auto width = static_cast<std::size_t>(width_);
        return pixel / width / kTile * static_cast<std::size_t>(tiles_x_) + pixel % width / kTile;
    }
    /// Columns x0 up to but not x1, rows likewise.
    struct Box {
        int x0, y0, x1, y1;
        double pixels() const { return static_cast<double>(x1 - x0) * (y1 - y0); }
    };
    Box box(std::size_t region) const {
        if (region == whole()) return {0, 0, width_, height_};
        const int x = static_cast<int>(region) % tiles_x_ * kTile;
        const int y = static_cast<int>(region) / tiles_x_ * kTile;
        return {x, y, std::min(width_, x + kTile), std::min(height_, y + kTile)};
    }

private:
    int width_, height_, tiles_x_, tiles_y_;
};

}  // namespace fluovox
