#include "fluovox/image/sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace fluovox {
namespace {

constexpr int kPixels = 20000;
constexpr double kSigmas = 5;

/// One point of a photon-transfer curve: mean and variance of the counts of evenly lit pixels.
struct Point {
    double mean = 0, variance = 0;
};

Point measure(const std::function<double(std::uint64_t pixel)>& count) {
    Point point;
    std::vector<double> counts;
    for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
        counts.push_back(count(pixel));
        point.mean += counts.back() / kPixels;
    }
    for (const double c : counts)
        point.variance += (c - point.mean) * (c - point.mean) / (kPixels - 1);
    return point;
}

/// Straight line through points whose variances are known to variance x sqrt(2 / (n - 1)) (normal counts).
struct Line {
    double slope = 0, slope_error = 0, intercept = 0, intercept_error = 0;
};

Line fit(const std::vector<Point>& points, double dark_mean) {
    double s = 0;
    double sx = 0;
    double sy = 0;
    double sxx = 0;
    double sxy = 0;
    for (const Point& p : points) {
        const double sigma = p.variance * std::sqrt(2.0 / (kPixels - 1));
        const double weight = 1 / (sigma * sigma);
        const double x = p.mean - dark_mean;
        s += weight;
        sx += weight * x;
        sy += weight * p.variance;
        sxx += weight * x * x;
        sxy += weight * x * p.variance;
    }
    const double det = s * sxx - sx * sx;
    return {(s * sxy - sx * sy) / det, std::sqrt(s / det), (sxx * sy - sx * sxy) / det, std::sqrt(sxx / det)};
}

/// The line of EMVA 1288: variance = K^2 read^2 + 1/12 + K (mean - dark mean); multiplied electrons double the shot
/// noise, so K becomes 2 K gain. The failures, in standard errors: of the slope, of the intercept.
struct Failures {
    double slope = 0, intercept = 0;
};

Failures against_emva(const std::vector<Point>& points, const Sensor& sensor, double dark_mean) {
    const Line line = fit(points, dark_mean);
    const double gain = sensor.counts_per_electron * sensor.em_gain;
    const double slope = sensor.em_gain > 1 ? 2 * gain : gain;
    const double read = sensor.counts_per_electron * sensor.read_noise_electrons;
    return {std::abs(line.slope - slope) / line.slope_error,
            std::abs(line.intercept - (read * read + 1.0 / 12)) / line.intercept_error};
}

constexpr std::array kLevels = {0.0, 20.0, 60.0, 150.0, 400.0, 900.0, 2000.0};  // photons

std::vector<Point> transfer_curve(const Sensor& sensor) {
    std::vector<Point> points;
    for (std::size_t level = 0; level < kLevels.size(); ++level) {
        points.push_back(measure([&](std::uint64_t pixel) {
            return expose(sensor, {kLevels[level], sensor.quantum_efficiency, 0}, {7, level, pixel}).count;
        }));
    }
    return points;
}

TEST(PhotonTransfer, SlopeIsTheGainAndInterceptTheReadNoise) {
    const Sensor scmos = sensor_preset("scmos");
    const Failures failures = against_emva(transfer_curve(scmos), scmos, scmos.offset_counts);
    EXPECT_LT(failures.slope, kSigmas);
    EXPECT_LT(failures.intercept, kSigmas);
}

TEST(PhotonTransfer, MultiplicationDoublesTheShotNoise) {
    Sensor emccd = sensor_preset("emccd");
    emccd.spurious_electrons = 0;
    emccd.counts_per_electron = 0.05;  // 2000 photons stay below the converter's end
    const Failures failures = against_emva(transfer_curve(emccd), emccd, emccd.offset_counts);
    EXPECT_LT(failures.slope, kSigmas);
}

TEST(PhotonTransfer, ACameraThatCountsShotNoiseInCountsInsteadOfElectronsIsFound) {
    const Sensor scmos = sensor_preset("scmos");
    std::vector<Point> points;
    std::mt19937 random(1);
    for (const double photons : kLevels) {
        const double mean = photons * scmos.quantum_efficiency * scmos.counts_per_electron;
        points.push_back(measure([&](std::uint64_t /*pixel*/) {
            const double shot = mean > 0 ? std::poisson_distribution<int>(mean)(random) : 0;
            const double read = scmos.read_noise_electrons * scmos.counts_per_electron;
            return std::round(shot + std::normal_distribution<double>(scmos.offset_counts, read)(random));
        }));
    }
    EXPECT_GT(against_emva(points, scmos, scmos.offset_counts).slope, kSigmas);
}

TEST(PhotonTransfer, ReadNoiseAppliedTwiceIsFound) {
    const Sensor scmos = sensor_preset("scmos");
    Sensor twice = scmos;
    twice.read_noise_electrons *= std::sqrt(2.0);
    EXPECT_GT(against_emva(transfer_curve(twice), scmos, scmos.offset_counts).intercept, kSigmas);
}

TEST(Sensor, CountsMeanTheElectronsAboveTheOffset) {
    Sensor sensor = sensor_preset("scmos");
    sensor.dark_electrons_per_s = 50;
    const double electrons = 300 * sensor.quantum_efficiency + 50 * 0.5;
    const Point point = measure([&](std::uint64_t pixel) {
        return expose(sensor, {300, sensor.quantum_efficiency, 0.5}, {1, 2, pixel}).count;
    });
    const double expected = sensor.offset_counts + sensor.counts_per_electron * electrons;
    EXPECT_LT(std::abs(point.mean - expected), kSigmas * std::sqrt(point.variance / kPixels));
}

TEST(Sensor, TheWellAndTheConverterEnd) {
    Sensor sensor = sensor_preset("ideal");
    sensor.full_well_electrons = 1000;
    EXPECT_EQ(expose(sensor, {1e6, 1, 1}, {1, 0, 0}).count, 1000);
    EXPECT_TRUE(expose(sensor, {1e6, 1, 1}, {1, 0, 0}).is_full);
    sensor.full_well_electrons = 1e12;
    sensor.bits = 12;
    EXPECT_EQ(expose(sensor, {1e6, 1, 1}, {1, 0, 0}).count, 4095);
    EXPECT_FALSE(expose(sensor, {100, 1, 1}, {1, 0, 0}).is_full);
}

TEST(Sensor, NoiseFollowsFromSeedPageAndPixelAlone) {
    const Sensor sensor = sensor_preset("scmos");
    const auto count = [&](std::uint64_t seed, std::uint64_t page, std::uint64_t pixel) {
        return expose(sensor, {5000, 0.8, 0.02}, {seed, page, pixel}).count;
    };
    EXPECT_EQ(count(1, 2, 3), count(1, 2, 3));
    EXPECT_NE(count(1, 2, 3), count(2, 2, 3));
    EXPECT_NE(count(1, 2, 3), count(1, 3, 3));
    EXPECT_NE(count(1, 2, 3), count(1, 2, 4));
}

StackInfo radiance_stack() {
    StackInfo info;
    info.quantity = "radiance";
    info.pixel_um = 2;
    info.numerical_aperture = 0.6;
    info.channels = {StackChannel{}};
    info.channels[0].emission_nm = 500;
    return info;
}

TEST(Sensor, PhotonsOfAPixelFollowFromRadianceApertureAreaAndExposure) {
    // 1 W/m2/sr x pi 0.6^2 sr x 4e-12 m2 x 0.1 s = 4.5239e-13 J; a photon of 500 nm has 3.97289e-19 J.
    StackInfo info = radiance_stack();
    EXPECT_NEAR(photons_per_value(info, 0, 0.1), 4.5238934e-13 / 3.9728917e-19, 1);
    info.immersion_index = 1.5;  // sin(theta) = 0.4
    EXPECT_NEAR(photons_per_value(info, 0, 0.1), 4.5238934e-13 / 3.9728917e-19 / 2.25, 1);
    info.channels[0].width_nm = 10;
    info.channels[0].counts_photons = true;
    EXPECT_NEAR(photons_per_value(info, 0, 0.1) / (4.5238934e-12 / 2.25), 1, 1e-6);
}

}  // namespace
}  // namespace fluovox
