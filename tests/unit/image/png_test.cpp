#include "fluovox/image/png.h"

#include "fluovox/core/error.h"

#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace fluovox {
namespace {

/// Reads with libpng's own simple reader.
std::vector<std::uint8_t> decode(const std::string& bytes, int& width, int& height) {
    png_image image;
    std::memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0) << image.message;
    image.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr), 0) << image.message;
    width = static_cast<int>(image.width);
    height = static_cast<int>(image.height);
    return rgb;
}

TEST(Png, EightBitsComeBackAsTheyWere) {
    Picture picture(5, 3);
    for (std::size_t i = 0; i < picture.rgb.size(); ++i)
        picture.rgb[i] = static_cast<std::uint8_t>(i * 37);
    int width = 0;
    int height = 0;
    EXPECT_EQ(decode(to_png(picture), width, height), picture.rgb);
    EXPECT_EQ(width, 5);
    EXPECT_EQ(height, 3);
}

TEST(Png, SixteenBitsHaveTheRightByteOrder) {
    Picture16 picture(2, 1);
    picture.rgb = {0x1234, 0xffff, 0, 0x8000, 0x00ff, 0xff00};
    const std::string bytes = to_png(picture);
    int width = 0;
    int height = 0;
    const auto eight_bit = decode(bytes, width, height);
    for (std::size_t i = 0; i < eight_bit.size(); ++i)
        EXPECT_EQ(eight_bit[i], std::lround(picture.rgb[i] / 257.0)) << i;
    EXPECT_EQ(bytes[24], 16);  // IHDR's bit depth
}

TEST(Png, TheSamePictureGivesTheSameBytesAndCarriesItsRemarks) {
    const Picture picture(4, 4);
    const PngRemarks remarks = {{"Description", "white = 0.5 W m^-2 sr^-1"}};
    const std::string bytes = to_png(picture, remarks);
    EXPECT_EQ(bytes, to_png(picture, remarks));
    EXPECT_NE(bytes.find(remarks[0].second), std::string::npos);
    EXPECT_EQ(bytes.find("tIME"), std::string::npos);
}

TEST(Png, RefusesAnEmptyPictureAndAMissingFolder) {
    EXPECT_THROW(to_png(Picture()), std::invalid_argument);
    Picture wrong(2, 2);
    wrong.rgb.pop_back();
    EXPECT_THROW(to_png(wrong), std::invalid_argument);
    EXPECT_THROW(save_png("no/such/folder/a.png", Picture(1, 1)), OutputError);
}

}  // namespace
}  // namespace fluovox
