#pragma once

#include "fluovox/image/film.h"
#include "fluovox/image/film_spec.h"
#include "fluovox/image/png.h"
#include "fluovox/image/rendered_image.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// An image as the eye may look at it: linear sRGB per pixel, exposed so that bright parts are near 1.
struct Preview {
    int width = 0;
    int height = 0;
    std::vector<float> rgb;  ///< 3 x width x height, 0 or more, may exceed 1
    std::string exposure;    ///< what full brightness stands for: "true colour, white = 2.5e-05", "green = 12, red = 3"
};

/// Shows the fluorescence where there is any, otherwise all light. A spectrometer's image appears in its true colour
/// (CIE 1931) where the eye sees enough of it, otherwise (near infrared) as grey; detector channels each in the colour
/// of its wavelength, or in false colours where these are too close, each exposed by itself. Full brightness is
/// the 97th percentile of the pixels that have light, but for those that a single bright sample made.
Preview make_preview(const Film& film, const FilmSpec& spec);
Preview make_preview(const RenderedImage& image);
/// The same with the exposure that fits another image, so that several can be compared.
Preview make_preview(const RenderedImage& image, const RenderedImage& exposed_by);

/// The colour (0xRRGGBB, sRGB) that stands for each channel.
std::vector<std::uint32_t> channel_colors(const FilmSpec& spec);

/// Eight bits a sample with the sRGB curve.
Picture to_picture(const Preview& preview);

/// Writes the preview as a PNG file, with `exposure` as its description. Throws OutputError.
void save_preview(const std::filesystem::path& path, const Preview& preview);

}  // namespace fluovox
