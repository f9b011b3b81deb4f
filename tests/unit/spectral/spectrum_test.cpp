#include "fluovox/spectral/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace fluovox {
namespace {

const Spectrum kHat({400, 500, 600}, {0, 2, 0});

TEST(Spectrum, IsLinearBetweenKnotsAndZeroOutside) {
    EXPECT_DOUBLE_EQ(kHat(450), 1);
    EXPECT_DOUBLE_EQ(kHat(500), 2);
    EXPECT_EQ(kHat(399.9), 0);
    EXPECT_EQ(kHat(600.1), 0);
    EXPECT_EQ(Spectrum()(500), 0);
    EXPECT_DOUBLE_EQ(Spectrum::box(400, 500, 3)(500), 3);
}

TEST(Spectrum, Integrates) {
    EXPECT_DOUBLE_EQ(kHat.integral(), 200);
    EXPECT_DOUBLE_EQ(kHat.integral(400, 450), 25);
    EXPECT_DOUBLE_EQ(kHat.integral(0, 1000), 200);
    EXPECT_DOUBLE_EQ(kHat.integral(450, 550), 150);
}

TEST(Spectrum, ProductIntegralIsExact) {
    // Int of (x/50)^2 over 0..100, twice: 2 * 100^3 / 3 / 2500
    EXPECT_NEAR(integral_of_product(kHat, kHat), 2 * 1e6 / 3 / 2500, 1e-9);
    EXPECT_NEAR(integral_of_product(kHat, Spectrum::box(450, 550, 1)), 150, 1e-12);
    EXPECT_EQ(integral_of_product(kHat, Spectrum::box(700, 800, 1)), 0);
}

TEST(Spectrum, SampleInvertsTheIntegral) {
    for (int i = 0; i < 1000; ++i) {
        const double u = (i + 0.5) / 1000;
        EXPECT_NEAR(kHat.integral(0, kHat.sample(u)) / kHat.integral(), u, 1e-12);
    }
    EXPECT_DOUBLE_EQ(kHat.pdf(500), 0.01);
}

TEST(Spectrum, RefusesBadTables) {
    EXPECT_THROW(Spectrum({400, 400}, {1, 1}), std::invalid_argument);
    EXPECT_THROW(Spectrum({500, 400}, {1, 1}), std::invalid_argument);
    EXPECT_THROW(Spectrum({400}, {1}), std::invalid_argument);
    EXPECT_THROW(Spectrum({400, 500}, {1, std::nan("")}), std::invalid_argument);
}

TEST(Spectrum, SumsAndProducts) {
    const Spectrum total = sum(kHat, Spectrum::box(400, 600, 1));
    EXPECT_DOUBLE_EQ(total(500), 3);
    EXPECT_DOUBLE_EQ(product(kHat, Spectrum::box(450, 550, 2))(500), 4);
    EXPECT_EQ(product(kHat, Spectrum::box(450, 550, 2))(449), 0);
}

}  // namespace
}  // namespace fluovox
