#include "fluovox/image/plot.h"

#include "fluovox/core/error.h"
#include "fluovox/image/plot_axis.h"

#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace fluovox {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Plot example() {
    Plot plot;
    plot.title = "A title";
    plot.x_label = "wavelength (nm)";
    plot.y_label = "y";
    plot.curves.push_back({"one", {400, 500, 600}, {1, 1, 1}});
    plot.curves.back().color = {1, 0, 0};
    plot.y_range = {0, 2};
    return plot;
}

struct Pixels {
    int width = 0, height = 0;
    std::vector<unsigned char> rgb;

    std::array<int, 3> at(double x, double y) const {
        const auto i =
            3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
        return {rgb[i], rgb[i + 1], rgb[i + 2]};
    }
};

Pixels decoded(const std::string& png) {
    png_image image = {};
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&image, png.data(), png.size()), 0);
    image.format = PNG_FORMAT_RGB;
    Pixels pixels{static_cast<int>(image.width), static_cast<int>(image.height), {}};
    pixels.rgb.resize(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, pixels.rgb.data(), 0, nullptr), 0);
    return pixels;
}

TEST(PlotAxis, TicksAreRoundNumbersWithEnoughDigits) {
    const AxisTicks tenths = axis_ticks(0, 1.1, 6);
    EXPECT_EQ(tenths.labels, (std::vector<std::string>{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"}));
    EXPECT_EQ(axis_ticks(398, 702, 6).labels, (std::vector<std::string>{"400", "500", "600", "700"}));
    EXPECT_EQ(axis_ticks(-0.05, 0.05, 4).labels.front(), "-0.05");
    EXPECT_EQ(axis_ticks(0, 3e-9, 3).labels.back(), "3e-09");
    EXPECT_EQ(axis_ticks(0, 2e12, 2).labels.back(), "2e+12");
    EXPECT_TRUE(axis_ticks(1, 1, 5).at.empty());
    EXPECT_TRUE(axis_ticks(0, kNan, 5).at.empty());
}

TEST(PlotAxis, RangeIgnoresWhatIsNotFinite) {
    EXPECT_EQ(finite_range({kNan, 3, -2, 1.0 / 0.0 * 1}), (std::pair{-2.0, 3.0}));
    EXPECT_EQ(finite_range({kNan}), (std::pair{0.0, 1.0}));
}

TEST(Plot, SvgIsTheSameTextEveryTime) {
    const std::string svg = plot_svg(example());
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    EXPECT_TRUE(svg == plot_svg(example()));
    Plot other = example();
    other.curves.front().y.back() = 1.5;
    EXPECT_FALSE(svg == plot_svg(other));
}

TEST(Plot, PngShowsTheCurveWhereItBelongs) {
    const Pixels pixels = decoded(plot_png(example()));
    EXPECT_EQ(pixels.width, 1800);
    EXPECT_EQ(pixels.height, 1040);
    // The curve is half way up: the only pure red in this column, and in its middle.
    int first = pixels.height;
    int last = -1;
    for (int y = 0; y < pixels.height; ++y) {
        if (pixels.at(700, y) != std::array{255, 0, 0}) continue;
        first = std::min(first, y);
        last = std::max(last, y);
    }
    ASSERT_LE(first, last);
    EXPECT_LE(last - first, 5);
    const int top = 74 * 2;
    const int bottom = (520 - 58) * 2;
    EXPECT_NEAR(0.5 * (first + last), 0.5 * (top + bottom), 2);
}

TEST(Plot, WavelengthsColourTheirAxis) {
    Plot plot = example();
    plot.x_is_wavelength = true;
    plot.x_range = {400, 700};
    const Pixels pixels = decoded(plot_png(plot));
    const auto at_nm = [&](double nm) {
        return pixels.at(2 * (72 + (900 - 24 - 72) * (nm - 400) / 300), 2 * (450 + 7));
    };
    const auto blue = at_nm(455);
    const auto green = at_nm(535);
    const auto red = at_nm(640);
    EXPECT_GT(blue[2], blue[1] + 100);
    EXPECT_GT(green[1], green[0] + 100);
    EXPECT_GT(red[0], red[2] + 100);
}

TEST(Plot, OddDataAreDrawnWithoutATrap) {
    EXPECT_FALSE(plot_svg({}).empty());
    Plot plot = example();
    plot.y_range.reset();
    plot.curves.front().y = {kNan, 2, 1.0 / 0.0};
    plot.curves.front().error = {1, kNan, 1};
    plot.curves.front().steps = true;
    plot.curves.push_back({"", {}, {}});
    plot.curves.push_back({"point", {450}, {0.5}, {0.1}});
    plot.curves.back().steps = true;
    plot.curves.back().filled = true;
    EXPECT_FALSE(plot_png(plot).empty());
    plot.curves.front().x.pop_back();
    EXPECT_THROW(plot_svg(plot), std::logic_error);
}

TEST(Plot, OtherEndingsAndMissingFoldersAreRefused) {
    EXPECT_TRUE(is_plot_path("a/b.SVG"));
    EXPECT_FALSE(is_plot_path("png"));
    EXPECT_THROW(save_plot(example(), testing::TempDir() + "plot.pdf"), OutputError);
    EXPECT_THROW(save_plot(example(), testing::TempDir() + "no-such-folder/plot.png"), OutputError);
}

}  // namespace
}  // namespace fluovox
