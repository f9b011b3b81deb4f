#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {

/// A picture for the eye: red, green, blue per pixel in sRGB, row 0 on top. `Sample` is 8 or 16 bits wide.
template <typename Sample>
struct BasicPicture {
    int width = 0;
    int height = 0;
    std::vector<Sample> rgb;  ///< 3 x width x height

    BasicPicture() = default;
    /// Black.
    BasicPicture(int width_px, int height_px)
        : width(width_px),
          height(height_px),
          rgb(3 * static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px)) {}

    /// The first of the three samples of a pixel.
    Sample* at(int x, int y) { return rgb.data() + index(x, y); }
    const Sample* at(int x, int y) const { return rgb.data() + index(x, y); }

private:
    std::size_t index(int x, int y) const {
        return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
    }
};

using Picture = BasicPicture<std::uint8_t>;
using Picture16 = BasicPicture<std::uint16_t>;

/// Short remarks in a PNG file: keyword (Latin-1, at most 79 characters) and text.
using PngRemarks = std::vector<std::pair<std::string, std::string>>;

/// The bytes of a PNG file: sRGB, no time stamp, so the same picture gives the same bytes. Throws
/// std::invalid_argument when the picture has no pixels or too few samples.
std::string to_png(const Picture& picture, const PngRemarks& remarks = {});
std::string to_png(const Picture16& picture, const PngRemarks& remarks = {});

/// Writes a PNG file by `write_atomically`; throws OutputError.
void save_png(const std::filesystem::path& path, const Picture& picture, const PngRemarks& remarks = {});
void save_png(const std::filesystem::path& path, const Picture16& picture, const PngRemarks& remarks = {});

/// The remark with a keyword in a PNG file as `save_png` writes them; nothing where there is none, or the file is not a
/// whole PNG (each of its parts is held against its check sum).
std::optional<std::string> load_png_remark(const std::filesystem::path& path, const std::string& keyword);

}  // namespace fluovox
