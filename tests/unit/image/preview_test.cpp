#include "fluovox/image/preview.h"

#include "test_images.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace fluovox {
namespace {

/// A dye's line in one channel of a spectrometer, brightness growing from pixel to pixel.
Film line(const FilmSpec& spec, int lit_channel) {
    Film film(16, 16, film_layers({"dye"}, false), static_cast<int>(spec.channels.size()));
    testing::fill(film, 1, 1, [lit_channel](int pixel, int channel, std::mt19937_64& /*random*/) {
        return channel == lit_channel ? 1e-6 * pixel : 0.0;
    });
    return film;
}

std::array<double, 3> brightest(const Preview& preview) {
    std::array<double, 3> most{};
    for (std::size_t i = 0; i < preview.rgb.size(); ++i)
        most[i % 3] = std::max(most[i % 3], static_cast<double>(preview.rgb[i]));
    return most;
}

TEST(Preview, ShowsTheFluorescenceInItsColourAndNotTheLaser) {
    const FilmSpec spec = testing::spectrometer(400, 700, 30);
    const auto green = brightest(make_preview(line(spec, 12), spec));  // 525 nm
    EXPECT_GT(green[1], 0.95);
    EXPECT_GT(green[1], 2 * green[0]);
    const auto red = brightest(make_preview(line(spec, 23), spec));  // 635 nm
    EXPECT_GT(red[0], 0.95);
    EXPECT_GT(red[0], 5 * red[1]);
    const Preview dark = make_preview(line(spec, 12), spec);
    EXPECT_EQ(dark.rgb[0], 0);  // elastic light is everywhere in the film, but not here
    EXPECT_EQ(dark.exposure.substr(0, 11), "true colour");
}

TEST(Preview, BrightPartsAreNearOneWhateverTheUnit) {
    FilmSpec spec = testing::spectrometer(400, 700, 30);
    for (const FilmUnit unit : {FilmUnit::Watts, FilmUnit::Photons}) {
        spec.unit = unit;
        const auto most = brightest(make_preview(line(spec, 12), spec));
        EXPECT_NEAR(most[1], 1, 0.05);
    }
}

TEST(Preview, NearInfraredIsGreyNotBlack) {
    const FilmSpec spec = testing::spectrometer(760, 860, 10);
    const Preview preview = make_preview(line(spec, 8), spec);
    const auto most = brightest(preview);
    EXPECT_NEAR(most[0], 1, 0.05);
    EXPECT_EQ(most[0], most[1]);
    EXPECT_EQ(most[0], most[2]);
    EXPECT_EQ(preview.exposure.substr(0, 4), "grey");
}

TEST(Preview, AnImageWithoutLightIsBlack) {
    for (const FilmSpec& spec : {testing::spectrometer(400, 700, 3), testing::two_detectors()}) {
        const Film film(4, 4, {"total"}, static_cast<int>(spec.channels.size()));
        const Picture picture = to_picture(make_preview(film, spec));
        EXPECT_EQ(picture.rgb, std::vector<std::uint8_t>(48, 0));
    }
}

TEST(Preview, DetectorChannelsHaveTheirColoursAndExposures) {
    const FilmSpec spec = testing::two_detectors();
    Film film(2, 1, {"total"}, 2);
    film.add(0, std::array{1e-9, 0.0});
    film.add(1, std::array{0.0, 1e20});
    const Preview preview = make_preview(film, spec);
    EXPECT_GT(preview.rgb[1], 0.99);  // green
    EXPECT_LT(preview.rgb[2], 0.3);
    EXPECT_GT(preview.rgb[3], 0.99);  // red
    EXPECT_LT(preview.rgb[4], 0.3);
    EXPECT_EQ(preview.exposure, "green = 1e-09, far red 1.0 = 1e+20");
}

TEST(Preview, ChannelsOfTheSameColourAreToldApart) {
    FilmSpec spec = testing::two_detectors();
    spec.channels[1].center_nm = spec.channels[0].center_nm + 10;
    Film film(2, 1, {"total"}, 2);
    film.add(0, std::array{1.0, 0.0});
    film.add(1, std::array{0.0, 1.0});
    const Preview preview = make_preview(film, spec);
    EXPECT_NE(std::vector<float>(preview.rgb.begin(), preview.rgb.begin() + 3),
              std::vector<float>(preview.rgb.begin() + 3, preview.rgb.end()));
}

TEST(Preview, BinsOfASpectrometerHaveTheHueOfTheirWavelengthHoweverClose) {
    const std::vector<std::uint32_t> colors = channel_colors(testing::spectrometer(450, 650, 20));
    const auto part = [&](std::size_t bin, unsigned shift) { return (colors[bin] >> shift) & 0xFFU; };
    EXPECT_GT(part(0, 0), part(0, 8));     // 455 nm: blue over green
    EXPECT_GT(part(7, 8), part(7, 16));    // 525 nm: green over red ...
    EXPECT_GT(part(7, 8), part(7, 0));     // ... and blue
    EXPECT_GT(part(19, 16), part(19, 8));  // 645 nm: red over green
}

TEST(Preview, ANoisySpikeDoesNotDarkenThePicture) {
    const FilmSpec spec = testing::spectrometer(400, 700, 3);
    Film film(32, 32, {"total"}, 3);
    testing::fill(film, 1, 1,
                  [](int pixel, int /*channel*/, std::mt19937_64& /*random*/) { return pixel == 500 ? 1e6 : 1.0; });
    const Picture picture = to_picture(make_preview(film, spec));
    EXPECT_GT(*std::max_element(picture.at(0, 0), picture.at(0, 0) + 3), 250);
}

TEST(Preview, PixelsOfOneBrightSampleDoNotDarkenThePicture) {
    const FilmSpec spec = testing::spectrometer(400, 700, 3);
    Film film(32, 32, {"total"}, 3);
    int sample = 0;
    testing::fill(film, 16, 1, [&sample](int pixel, int /*channel*/, std::mt19937_64& random) {
        const bool spike = pixel % 16 == 0 && sample++ % 48 < 3;  // a hundred times as bright as the rest
        return std::uniform_real_distribution<double>(0.9, 1.1)(random) + (spike ? 1600.0 : 0.0);
    });
    const Picture picture = to_picture(make_preview(film, spec));
    EXPECT_GT(*std::max_element(picture.at(1, 0), picture.at(1, 0) + 3), 240);
}

TEST(Preview, FilmAndImageLookTheSame) {
    const FilmSpec spec = testing::spectrometer(400, 700, 3);
    const Film film = line(spec, 1);
    EXPECT_EQ(to_picture(make_preview(film, spec)).rgb, to_picture(make_preview(make_image(film, spec, {}))).rgb);
}

}  // namespace
}  // namespace fluovox
