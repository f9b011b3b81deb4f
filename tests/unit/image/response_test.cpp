#include "fluovox/image/response.h"

#include "test_images.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace fluovox {
namespace {

TEST(Response, MeanAndErrorOfARegion) {
    const FilmSpec spec = testing::spectrometer(400, 700, 2);
    Film film(3, 2, {"total"}, 2);
    for (int pixel = 0; pixel < 6; ++pixel) {
        film.add(pixel, std::array{1.0 * pixel, 10.0});
        film.add(pixel, std::array{2.0 * pixel, 10.0});
    }
    const RenderedImage image = make_image(film, spec, {});
    // Pixels 1, 2, 4, 5: means 1.5 p, variances of the mean p^2 / 4.
    const SpectralResponse part = mean_response(image, 0, {1, 0, 3, 2});
    EXPECT_NEAR(part.mean[0], 1.5 * 3, 1e-6);
    EXPECT_NEAR(part.standard_error[0], std::sqrt((1 + 4 + 16 + 25) / 4.0) / 4, 1e-6);
    EXPECT_NEAR(part.mean[1], 10, 1e-6);
    EXPECT_EQ(part.standard_error[1], 0);
    EXPECT_THROW(mean_response(image, 0, {1, 0, 4, 2}), std::invalid_argument);
    EXPECT_THROW(mean_response(image, 0, {1, 1, 1, 2}), std::invalid_argument);
    EXPECT_THROW(mean_response(image, 1, {0, 0, 3, 2}), std::invalid_argument);
}

TEST(Response, TheErrorOfTheSumKnowsThatChannelsOfAPathAreNotIndependent) {
    const FilmSpec spec = testing::spectrometer(400, 700, 3);
    Film together(2, 1, {"total"}, 3);
    Film against(2, 1, {"total"}, 3);
    for (const double x : {1.0, 2.0, 4.0}) {
        for (const int pixel : {0, 1}) {
            together.add(pixel, std::array{x, 2 * x, 3 * x});
            against.add(pixel, std::array{x, 5 - x, 7.0});
        }
    }
    const SpectralResponse one = mean_response(make_image(together, spec, {}), 0, {0, 0, 2, 1});
    EXPECT_NEAR(one.sum, 6 * 7 / 3.0, 1e-5);
    EXPECT_NEAR(one.standard_error_of_sum, 6 * one.standard_error[0], 1e-5);
    EXPECT_GT(one.standard_error_of_sum, 1.5 * std::sqrt(1.0 + 4 + 9) * one.standard_error[0]) << "in quadrature";
    const SpectralResponse other = mean_response(make_image(against, spec, {}), 0, {0, 0, 2, 1});
    EXPECT_GT(other.standard_error[0], 0.1);
    EXPECT_NEAR(other.standard_error_of_sum, 0, 1e-3);
}

TEST(Response, OneSampleTellsNoError) {
    const FilmSpec spec = testing::spectrometer(400, 700, 1);
    Film film(1, 1, {"total"}, 1);
    film.add(0, std::array{1.0});
    EXPECT_TRUE(std::isnan(mean_response(make_image(film, spec, {}), 0, {0, 0, 1, 1}).standard_error[0]));
    film.add(0, std::array{2.0});
    EXPECT_NEAR(mean_response(make_image(film, spec, {}), 0, {0, 0, 1, 1}).standard_error[0], 0.5, 1e-6);
}

TEST(Response, PixelsThatShareSamplesHaveAnErrorTogether) {
    const FilmSpec spec = testing::spectrometer(400, 700, 1);
    Film film(16, 8, {"total"}, 1);
    for (const double x : {1.0, 2.0, 4.0})
        film.add_shared(std::vector<double>(128, x));
    const RenderedImage image = make_image(film, spec, {});
    const double error = std::sqrt(film.variance_of_mean(0, 0, 0));
    EXPECT_NEAR(mean_response(image, 0, {0, 0, 16, 8}).standard_error[0] / error, 1, 1e-6) << "of one pixel, of all";
    EXPECT_NEAR(mean_response(image, 0, {8, 0, 16, 8}).standard_error[0] / error, 1, 0.01);
    EXPECT_NEAR(mean_response(image, 0, {3, 3, 4, 4}).standard_error[0] / error, 1, 1e-6);
    EXPECT_NEAR(mean_response(image, 0, {2, 2, 6, 6}).standard_error[0] / error, 1, 0.05);
    EXPECT_NEAR(mean_response(image, 0, {0, 0, 16, 8}).standard_error_of_sum / error, 1, 1e-6);
}

TEST(Response, WattsWeighTheEmissionByPhotonEnergy) {
    FilmSpec spec = testing::spectrometer(400, 800, 2);
    const Spectrum flat = Spectrum::box(400, 800, 1 / 400.0);
    // Integral of dl / l over each half: ln(600/400) and ln(800/600).
    const auto watts = emission_on_film(flat, spec);
    EXPECT_NEAR(watts[0] / watts[1], std::log(1.5) / std::log(4.0 / 3), 1e-9);
    spec.unit = FilmUnit::Photons;
    const auto photons = emission_on_film(flat, spec);
    EXPECT_NEAR(photons[0], photons[1], 1e-15);
    EXPECT_NEAR(photons[0], 0.5 / 200, 1e-15);
}

TEST(Response, EmissionBeyondItsTableIsZero) {
    const auto watts = emission_on_film(Spectrum::box(500, 550, 0.02), testing::spectrometer(400, 800, 4));
    EXPECT_EQ(watts[0], 0);
    EXPECT_GT(watts[1], 0);
    EXPECT_EQ(watts[2], 0);
}

TEST(Response, DistanceComparesShapesOnly) {
    EXPECT_NEAR(normalized_distance({1, 2, 1}, {10, 20, 10}), 0, 1e-15);
    EXPECT_NEAR(normalized_distance({1, 0}, {0, 5}), 2, 1e-15);
    EXPECT_NEAR(normalized_distance({3, 1}, {1, 1}), 0.5, 1e-15);
    EXPECT_EQ(normalized({1, 3}, 5), (std::vector<double>{0.05, 0.15}));
    EXPECT_EQ(normalized({0, 0}, 5), (std::vector<double>{0, 0}));
}

TEST(Response, NoiseAloneMakesADistanceOfTheSizeItTells) {
    std::mt19937_64 random(3);
    SpectralResponse response;
    std::vector<double> truth;
    for (int i = 0; i < 40; ++i) {
        truth.push_back(100 + i);
        response.standard_error.push_back(0.5);
    }
    double sum = 0;
    for (int trial = 0; trial < 200; ++trial) {
        response.mean.clear();
        for (const double value : truth)
            response.mean.push_back(value + std::normal_distribution<double>(0, 0.5)(random));
        sum += normalized_distance(response.mean, truth);
    }
    EXPECT_NEAR(sum / 200 / distance_from_noise(response), 1, 0.05);
}

}  // namespace
}  // namespace fluovox
