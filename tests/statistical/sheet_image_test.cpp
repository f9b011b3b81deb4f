// Sheets and objectives as they look in rendered images, against their formulas.

#include "fluovox/scene/scene.h"
#include "fluovox/transport/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace fluovox {
namespace {

/// The layer of the dye, all channels, row by row.
struct Image {
    int width = 0, height = 0;
    std::vector<double> values;

    double at(int x, int y) const {
        return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
};

Image render_text(const std::string& text, const std::vector<std::string>& overrides = {}) {
    const Scene scene = build_scene(parse_scene_description(text, "scene.toml", overrides));
    NoProgress progress;
    const Film film = render(scene, progress).film;
    Image image{film.width(), film.height(), {}};
    const int layer = film.layer(kFluorescenceLayer);
    for (int pixel = 0; pixel < film.pixels(); ++pixel)
        image.values.push_back(film.mean(layer, pixel, 0));
    return image;
}

// A sheet along x seen edge-on in a dilute dye: pixels of 1 um, the waist in the middle.
const std::string kEdgeOn = R"(
[[medium]]
dye           = "EGFP"
concentration = "1 nM"
region        = { box = { min = ["-400 um", "-100 um", "-100 um"], max = ["400 um", "100 um", "100 um"] } }
[[light]]
kind        = "sheet"
wavelength  = "488 nm"
power       = "1 mW"
position    = ["-500 um", "0 um", "0 um"]
direction   = [1, 0, 0]
normal      = [0, 0, 1]
width       = "100 um"
waist       = ["0 um", "0 um", "0 um"]
thickness   = "8 um"
diffraction = true
[camera]
position   = ["0 um", "-1 mm", "0 um"]
target     = ["0 um", "0 um", "0 um"]
up         = [0, 0, 1]
pixel_size = "1 um"
resolution = [320, 64]
[[film.channel]]
name = "green"
band = { center = "525 nm", width = "50 nm" }
[render]
samples = 24
)";

struct Waist {
    double thickness_um = 0, rayleigh_um = 0;
};

/// Fits sigma^2(x) = sigma0^2 + (x sigma0 / zR)^2 to the second moments of the columns.
Waist measure_waist(const Image& image) {
    double n = 0;
    double sx = 0;
    double sy = 0;
    double sxx = 0;
    double sxy = 0;
    for (int x = 0; x < image.width; ++x) {
        double light = 0;
        double second = 0;
        for (int y = 0; y < image.height; ++y) {
            const double z = y + 0.5 - 0.5 * image.height;
            light += image.at(x, y);
            second += image.at(x, y) * z * z;
        }
        const double along = x + 0.5 - 0.5 * image.width;
        const double squared = along * along;
        const double variance = second / light - 1.0 / 12;  // without the pixel's own width
        const double weight = 1 / (variance * variance);
        n += weight;
        sx += weight * squared;
        sy += weight * variance;
        sxx += weight * squared * squared;
        sxy += weight * squared * variance;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    const double waist = (sy - slope * sx) / n;
    return {4 * std::sqrt(waist), std::sqrt(waist / slope)};
}

constexpr double kRayleigh_um = 3.14159265358979 * 4 * 4 / 0.488;  // pi w0^2 / wavelength

TEST(SheetImage, ThicknessAndRayleighRangeOfAGaussianSheetAreThoseOfTheFormula) {
    const Waist measured = measure_waist(render_text(kEdgeOn));
    EXPECT_NEAR(measured.thickness_um / 8, 1, 0.01);
    EXPECT_NEAR(measured.rayleigh_um / kRayleigh_um, 1, 0.01);
}

TEST(SheetImage, ASheetOfAnotherThicknessOrConeIsFound) {
    const Waist thick = measure_waist(render_text(kEdgeOn, {"light.0.thickness=8.3um"}));
    EXPECT_GT(std::abs(thick.thickness_um / 8 - 1), 0.01);
    const Waist cone =
        measure_waist(render_text(kEdgeOn, {"light.0.diffraction=false", "light.0.rayleigh_range=106um"}));
    EXPECT_NEAR(cone.thickness_um / 8, 1, 0.01);
    EXPECT_GT(std::abs(cone.rayleigh_um / kRayleigh_um - 1), 0.01);
}

TEST(SheetImage, AScannedBeamAndAnApertureAloneMakeTheSameSheet) {
    std::string beam = kEdgeOn;
    beam.replace(beam.find("\"sheet\""), 7, "\"beam\"");
    for (const char* line : {"normal      = [0, 0, 1]\n", "width       = \"100 um\"\n", "thickness   = \"8 um\"\n"})
        beam.erase(beam.find(line), std::string(line).size());
    beam.insert(beam.find("waist "), "radius = \"4 um\"\nscan = { along = [0, 1, 0], width = \"100 um\" }\n");
    EXPECT_EQ(render_text(beam, {"render.samples=2"}).values, render_text(kEdgeOn, {"render.samples=2"}).values);

    std::string aperture = kEdgeOn;
    for (const char* line : {"thickness   = \"8 um\"\n", "diffraction = true\n"})
        aperture.erase(aperture.find(line), std::string(line).size());
    aperture.insert(aperture.find("waist "),
                    "numerical_aperture = 0.05165\nimmersion_index = 1.33\n");  // w0 = 3.0075 um
    const Waist measured = measure_waist(render_text(aperture));
    EXPECT_NEAR(measured.thickness_um / 6.015, 1, 0.01);
    EXPECT_NEAR(measured.rayleigh_um / (3.14159265358979 * 3.0075 * 3.0075 * 1.33 / 0.488), 1, 0.01);
}

TEST(SheetImage, BrightnessAlongTheSheetFallsWithTheExtinction) {
    // An absorber of 2 /mm between x = -200 and 200 um, seen from above in 20 columns.
    const std::string absorber = R"(
[[medium]]
dye           = "EGFP"
concentration = "1 nM"
region        = "everywhere"
[[medium]]
absorption = "2 /mm"
region     = { box = { min = ["-200 um", "-200 um", "-50 um"], max = ["200 um", "200 um", "50 um"] } }
[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-500 um", "0 um", "0 um"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "600 um"
thickness  = "4 um"
profile    = "box"
[camera]
position   = ["0 um", "0 um", "1 mm"]
target     = ["0 um", "0 um", "0 um"]
pixel_size = "20 um"
resolution = [20, 8]
[[film.channel]]
name = "green"
band = { center = "525 nm", width = "50 nm" }
[render]
samples = 400
)";
    const auto worst = [&](const std::string& coefficient) {
        const Image image = render_text(absorber, {"medium.1.absorption=" + coefficient, "medium.0.region=everywhere"});
        std::vector<double> columns;
        double sum = 0;
        double expected_sum = 0;
        std::vector<double> expected;
        for (int x = 0; x < image.width; ++x) {
            columns.push_back(0);
            for (int y = 0; y < image.height; ++y)
                columns.back() += image.at(x, y);
            sum += columns.back();
            expected.push_back(std::exp(-0.002 * 20 * x));
            expected_sum += expected.back();
        }
        double most = 0;
        for (std::size_t x = 0; x < columns.size(); ++x)
            most = std::max(most, std::abs(columns[x] / sum / (expected[x] / expected_sum) - 1));
        return most;
    };
    EXPECT_LT(worst("2 /mm"), 0.005);
    EXPECT_GT(worst("2.1 /mm"), 0.005);
}

// A bead of 2 um radius, 10 um behind the focal plane, evenly lit; pixels of 0.5 um.
const std::string kBead = R"(
[[medium]]
dye           = "EGFP"
concentration = "1 uM"
region        = { sphere = { center = ["0 um", "0 um", "-10 um"], radius = "2 um" } }
[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-500 um", "0 um", "-10 um"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "20 um"
thickness  = "20 um"
profile    = "box"
[camera]
position   = ["0 um", "0 um", "100 um"]
target     = ["0 um", "0 um", "0 um"]
pixel_size = "0.5 um"
resolution = [40, 40]
[[film.channel]]
name = "green"
band = { center = "500 nm", width = "50 nm" }
[render]
samples = 100
)";

/// Mean squared distance of the light from the middle of the image, um^2.
double second_moment(const Image& image) {
    double light = 0;
    double second = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const double dx = 0.5 * (x + 0.5 - 0.5 * image.width);
            const double dy = 0.5 * (y + 0.5 - 0.5 * image.height);
            light += image.at(x, y);
            second += image.at(x, y) * (dx * dx + dy * dy);
        }
    }
    return second / light;
}

TEST(ObjectiveImage, OutOfFocusBlurOfABeadGrowsWithTheConeOfTheAperture) {
    const double sharp = second_moment(render_text(kBead));
    EXPECT_NEAR(sharp, 0.4 * 4 + 2 * 0.25 / 12, 0.1);  // a ball seen through: 2/5 r^2, and the pixels
    double last = sharp;
    for (const double aperture : {0.1, 0.2, 0.3, 0.4}) {
        const double blurred =
            second_moment(render_text(kBead, {"camera.numerical_aperture=" + std::to_string(aperture)}));
        EXPECT_GT(blurred, last);
        last = blurred;
        // The mean of tan^2 over a disc of direction cosines, times the distance squared.
        const double sine2 = aperture * aperture;
        EXPECT_NEAR((blurred - sharp) / (100 * (-sine2 - std::log(1 - sine2)) / sine2), 1, 0.06) << aperture;
    }
    const double immersed =
        second_moment(render_text(kBead, {"camera.numerical_aperture=0.532", "camera.immersion_index=1.33"}));
    EXPECT_NEAR(immersed / last, 1, 0.05);  // the same cone
}

TEST(ObjectiveImage, TheBlurThatStandsForDiffractionHasTheWidthItSays) {
    const double sharp = second_moment(render_text(kBead));
    const double sigma = 3.0 / 2.354820045;
    EXPECT_NEAR((second_moment(render_text(kBead, {"camera.blur=3um"})) - sharp) / (2 * sigma * sigma), 1, 0.05);
    const SceneDescription resolved =
        parse_scene_description(kBead, "scene.toml", {"camera.blur=diffraction", "camera.numerical_aperture=0.5"});
    EXPECT_NEAR(resolved.camera.blur_um, 0.5, 1e-9);  // 500 nm / (2 x 0.5)
}

TEST(SheetLights, PivotedAndTwoSidedSheetsAreTheAverageOfTheirParts) {
    const Scene scene = build_scene(
        parse_scene_description(kEdgeOn, "scene.toml", {"light.0.pivot_deg=[-3,0,3]", "light.0.two_sided=true"}));
    ASSERT_EQ(scene.lights.size(), 6U);
    for (const Light& light : scene.lights) {
        const auto& sheet = std::get<SheetLight>(light.shape);
        EXPECT_NEAR(light.power_W, 1e-3 / 6, 1e-12);
        const double along = dot(sheet.waist - sheet.position, sheet.direction);
        EXPECT_NEAR(along, 500, 1e-9);  // each goes through the waist
        EXPECT_EQ(sheet.normal, (Vec3{0, 0, 1}));
    }
    EXPECT_NEAR(std::get<SheetLight>(scene.lights[4].shape).direction.y, std::sin(3 * 3.14159265358979 / 180), 1e-9);
}

}  // namespace
}  // namespace fluovox
