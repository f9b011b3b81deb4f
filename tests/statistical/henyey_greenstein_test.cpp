// Turns by Henyey and Greenstein's phase function: cosines and azimuths follow the density.

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/medium/phase_function.h"

#include "statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace fluovox {
namespace {

using testing::chi_squared_p;
using testing::kFiveSigma;

double henyey_greenstein_cdf(double cosine, double g) {
    if (std::abs(g) < 1e-9) return 0.5 * (1 + cosine);
    return (1 - g * g) / (2 * g) * (1 / std::sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g));
}

// The cosine below which a share `u` lies, by bisection of the closed form.
double henyey_greenstein_quantile(double u, double g) {
    double low = -1;
    double high = 1;
    for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high);
        (henyey_greenstein_cdf(middle, g) < u ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

constexpr std::array kAnisotropies = {0.0, 1e-7, 0.05, 0.75, 0.9, 0.999, -0.5, -0.95};

TEST(HenyeyGreenstein, CosinesFollowTheDensity) {
    constexpr int kBins = 100;
    constexpr int kDraws = 1000000;
    for (const double g : kAnisotropies) {
        const auto p = [&](double wrong_g) {
            std::vector<double> edges;
            for (int i = 1; i < kBins; ++i)
                edges.push_back(henyey_greenstein_quantile(static_cast<double>(i) / kBins, wrong_g));
            std::vector<double> counts(kBins, 0);
            Rng rng(12, 0, 0);
            for (int n = 0; n < kDraws; ++n) {
                const double cosine = sample_henyey_greenstein_cosine(g, rng.uniform());
                ++counts[static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), cosine) -
                                                  edges.begin())];
            }
            return chi_squared_p(counts, std::vector<double>(kBins, static_cast<double>(kDraws) / kBins));
        };
        EXPECT_GT(p(g), kFiveSigma) << g;
        const double slip = 0.02 * (1 - std::abs(g));
        EXPECT_LT(p(g < 0 ? g - slip : g + slip), kFiveSigma) << g;
    }
}

TEST(HenyeyGreenstein, DensityIsTheDerivativeOfItsDistribution) {
    for (const double g : kAnisotropies) {
        double total = 0;
        double mean = 0;
        for (int i = 0; i < 2000; ++i) {  // between quantiles, so that narrow peaks are resolved
            const double from = henyey_greenstein_quantile(i / 2000.0, g);
            const double to = henyey_greenstein_quantile((i + 1) / 2000.0, g);
            for (int j = 0; j < 20; ++j) {
                const double cosine = from + (to - from) * (j + 0.5) / 20;
                const double share = 2 * std::numbers::pi * henyey_greenstein(cosine, g) * (to - from) / 20;
                total += share;
                mean += share * cosine;
            }
        }
        EXPECT_NEAR(total, 1, 1e-4) << g;
        EXPECT_NEAR(mean, g, 1e-4) << g;
    }
}

TEST(Isotropic, DirectionsFillTheSphereEvenly) {
    // By cosine and azimuth; the twin's poles are drawn in by one per cent.
    std::vector<double> counts(256, 0);
    std::vector<double> twin(256, 0);
    const auto bin = [](double cosine, double azimuth) {
        const auto of16 = [](double share) { return static_cast<std::size_t>(std::clamp(16 * share, 0.0, 15.0)); };
        return 16 * of16(0.5 + 0.5 * cosine) + of16(0.5 + 0.5 * azimuth / std::numbers::pi);
    };
    Rng rng(14, 0, 0);
    constexpr int kSamples = 2000000;
    for (int n = 0; n < kSamples; ++n) {
        const Vec3 direction = sample_isotropic(rng);
        if (n % 1000 == 0) {
            EXPECT_NEAR(length(direction), 1, 1e-12);
        }
        const double azimuth = std::atan2(direction.y, direction.x);
        ++counts[bin(direction.z, azimuth)];
        ++twin[bin(0.99 * direction.z, azimuth)];
    }
    const std::vector<double> expected(256, kSamples / 256.0);
    EXPECT_GT(chi_squared_p(counts, expected), kFiveSigma);
    EXPECT_LT(chi_squared_p(twin, expected), kFiveSigma);
}

TEST(HenyeyGreenstein, DirectionsTurnByThatCosineAllAroundTheAxis) {
    Rng rng(13, 0, 0);
    for (int a = 0; a < 8; ++a) {
        Vec3 axis = sample_isotropic(rng.uniform(), rng.uniform());
        if (a == 0) axis = {0, 0, -1};
        if (a == 1) axis = {0, 0, 1};
        const Vec3 side = normalized(cross(axis, {0.3, 0.5, 0.1}));
        const Vec3 other = cross(axis, side);
        std::vector<double> counts(16, 0);
        for (int n = 0; n < 20000; ++n) {
            const double cosine = 1 - 2 * rng.uniform();
            const Vec3 direction = turned(axis, cosine, rng.uniform());
            EXPECT_NEAR(length(direction), 1, 1e-12);
            EXPECT_NEAR(dot(direction, axis), cosine, 1e-9);
            const double azimuth = std::atan2(dot(direction, other), dot(direction, side));
            ++counts[static_cast<std::size_t>(std::min(15.0, 8 * (1 + azimuth / std::numbers::pi)))];
        }
        EXPECT_GT(chi_squared_p(counts, std::vector<double>(16, 20000.0 / 16)), kFiveSigma);
    }
}

}  // namespace
}  // namespace fluovox
