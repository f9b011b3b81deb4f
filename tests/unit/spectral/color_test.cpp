#include "fluovox/spectral/color.h"

#include "fluovox/core/csv.h"
#include "fluovox/spectral/photons.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace fluovox {
namespace {

void expect_color(const Rgb& color, double r, double g, double b, double tolerance) {
    EXPECT_NEAR(color.r, r, tolerance);
    EXPECT_NEAR(color.g, g, tolerance);
    EXPECT_NEAR(color.b, b, tolerance);
}

TEST(Color, MatchingFunctionsHaveThePublishedIntegrals) {
    const Xyz flat = to_xyz(Spectrum::box(300, 900, 1));
    EXPECT_NEAR(flat.x, 106.865, 0.005);  // CIE 1931, sums at 1 nm
    EXPECT_NEAR(flat.y, 106.857, 0.005);
    EXPECT_NEAR(flat.z, 106.892, 0.005);
    EXPECT_DOUBLE_EQ(cie_1931(200).y, 0);
    EXPECT_NEAR(cie_1931(555).y, 1, 1e-3);
}

TEST(Color, MatchingFunctionsEqualTheMeasuredTables) {
    const std::filesystem::path file = FLUOVOX_SHARED_DIR "/optics/cie1931_2deg_1nm.csv";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const CsvTable table = load_csv(file);
    for (std::size_t i = 0; i < table.rows(); ++i) {
        const double nm = table.columns[0][i];
        const double tolerance = static_cast<int>(nm) % 2 == 0 ? 0 : 4e-3;  // between our knots: linear
        EXPECT_NEAR(cie_1931(nm).x, table.column("xbar")[i], tolerance) << nm;
        EXPECT_NEAR(cie_1931(nm).y, table.column("ybar")[i], tolerance) << nm;
        EXPECT_NEAR(cie_1931(nm).z, table.column("zbar")[i], tolerance) << nm;
    }
}

TEST(Color, DaylightD65IsWhite) {
    const std::filesystem::path file = FLUOVOX_SHARED_DIR "/optics/illuminant_D65.csv";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
    const CsvTable table = load_csv(file);
    const Spectrum d65(table.columns[0], table.columns[1]);
    const Xyz white = to_xyz(d65);
    EXPECT_NEAR(white.x / (white.x + white.y + white.z), 0.31273, 2e-5);
    EXPECT_NEAR(white.y / (white.x + white.y + white.z), 0.32902, 2e-5);
    expect_color(linear_srgb(to_xyz(d65.scaled(1 / white.y))), 1, 1, 1, 1e-3);
}

TEST(Color, WhiteAndPrimariesOfSrgb) {
    expect_color(linear_srgb({0.95047, 1, 1.08883}), 1, 1, 1, 1e-4);
    expect_color(linear_srgb({0.412456, 0.212673, 0.019334}), 1, 0, 0, 1e-4);
    expect_color(linear_srgb({0.180437, 0.072175, 0.950304}), 0, 0, 1, 1e-4);
}

TEST(Color, TransferFunctionKnowsItsFixedPointsAndInverse) {
    EXPECT_EQ(srgb_encoded(-1), 0);
    EXPECT_EQ(srgb_encoded(7), 1);
    EXPECT_NEAR(srgb_encoded(0.5), 0.735357, 1e-6);
    EXPECT_NEAR(srgb_encoded(0.0031308), 0.04045, 1e-5);
    for (double linear = 0; linear <= 1; linear += 1.0 / 64)
        EXPECT_NEAR(srgb_decoded(srgb_encoded(linear)), linear, 1e-12);
}

TEST(Color, GamutMappingKeepsLuminanceAndInGamutColours) {
    const auto luminance = [](const Rgb& c) { return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b; };
    for (double nm = 400; nm <= 700; nm += 10) {
        const Rgb light = linear_srgb(cie_1931(nm));
        const Rgb shown = into_gamut(light);
        EXPECT_GE(std::min({shown.r, shown.g, shown.b}), 0) << nm;
        EXPECT_NEAR(luminance(shown), luminance(light), 1e-6) << nm;
    }
    EXPECT_EQ(into_gamut({0.2, 0.3, 0.4}), (Rgb{0.2, 0.3, 0.4}));
}

TEST(Color, DisplayColoursLookLikeTheirWavelength) {
    const Rgb blue = display_color(460);
    const Rgb green = display_color(530);
    const Rgb red = display_color(640);
    EXPECT_GT(blue.b, std::max(blue.r, blue.g));
    EXPECT_GT(green.g, std::max(green.r, green.b));
    EXPECT_GT(red.r, std::max(red.g, red.b));
    for (double nm = 200; nm < 1200; nm += 10) {
        const Rgb c = display_color(nm);
        EXPECT_GT(std::max({c.r, c.g, c.b}), 0.3) << nm;
        EXPECT_LE(std::max({c.r, c.g, c.b}), 1) << nm;
    }
}

TEST(Photons, EnergyAndPowerAgreeWithTheTextbook) {
    EXPECT_NEAR(photon_energy_J(500), 3.97289e-19, 1e-24);
    EXPECT_NEAR(photons_per_second(1e-3, 500), 2.51706e15, 1e10);
    EXPECT_NEAR(power_W(photons_per_second(0.25, 633), 633), 0.25, 1e-15);
}

}  // namespace
}  // namespace fluovox
