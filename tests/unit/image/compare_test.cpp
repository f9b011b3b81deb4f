#include "fluovox/image/compare.h"

#include "fluovox/core/error.h"

#include "test_images.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <span>
#include <vector>

namespace fluovox {
namespace {

using testing::PixelSampler;

constexpr int kSize = 16;
const FilmSpec kSpec = testing::spectrometer(400, 700, 3);

double uniform(std::mt19937_64& random) {
    return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Pixels of different brightness, mean 1 to 7.
double brightness(int pixel) {
    return 1 + pixel % 7;
}

/// Nearly every sample is zero, `share` of them are large; mean 1.
PixelSampler rare_spikes(double share) {
    return [share](int pixel, int /*channel*/, std::mt19937_64& random) {
        return uniform(random) < share ? brightness(pixel) / share : 0;
    };
}

/// Mean 1, relative variance exp(sigma^2) - 1.
PixelSampler log_normal(double sigma) {
    return [sigma](int pixel, int /*channel*/, std::mt19937_64& random) {
        return brightness(pixel) * std::lognormal_distribution<double>(-sigma * sigma / 2, sigma)(random);
    };
}

PixelSampler even(double mean = 1) {
    return [mean](int pixel, int /*channel*/, std::mt19937_64& random) {
        return brightness(pixel) * 2 * mean * uniform(random);
    };
}

struct Recipe {
    PixelSampler sampler;
    int samples = 64;
    std::string estimator = "path";
    int size = kSize;
};

RenderedImage render(const Recipe& recipe, std::uint64_t seed) {
    Film film(recipe.size, recipe.size, {"total"}, 3);
    testing::fill(film, recipe.samples, seed, recipe.sampler);
    Provenance from;
    from.estimator = recipe.estimator;
    return make_image(film, kSpec, from);
}

std::vector<RenderedImage> render_many(const Recipe& recipe, std::uint64_t first_seed, std::size_t count) {
    std::vector<RenderedImage> images;
    for (std::size_t i = 0; i < count; ++i)
        images.push_back(render(recipe, first_seed + i));
    return images;
}

/// How many of 15 x 15 pairs of equal scenes are called different: 225 chances for a false alarm.
int false_alarms(const Recipe& a, const Recipe& b) {
    const auto images_a = render_many(a, 1000, 15);
    const auto images_b = render_many(b, 2000, 15);
    int alarms = 0;
    for (const RenderedImage& one : images_a) {
        for (const RenderedImage& other : images_b)
            alarms += compare(one, other).same ? 0 : 1;
    }
    return alarms;
}

TEST(Compare, EqualScenesAreTheSameHoweverHeavyTheirTails) {
    for (const double share : {0.1, 0.01, 0.001, 1e-4})
        EXPECT_EQ(false_alarms({rare_spikes(share)}, {rare_spikes(share)}), 0) << "spikes in " << share;
    for (const double sigma : {0.5, 1.0, 2.0, 3.0})
        EXPECT_EQ(false_alarms({log_normal(sigma)}, {log_normal(sigma)}), 0) << "log-normal " << sigma;
}

TEST(Compare, EqualScenesAreTheSameWithFewOrDifferentlyManySamples) {
    EXPECT_EQ(false_alarms({log_normal(2), 1}, {log_normal(2), 1}), 0);
    EXPECT_EQ(false_alarms({log_normal(2), 4}, {log_normal(2), 4}), 0);
    EXPECT_EQ(false_alarms({log_normal(2), 1}, {log_normal(2), 64}), 0);
    EXPECT_EQ(false_alarms({rare_spikes(0.01), 8}, {rare_spikes(0.01), 512}), 0);
}

TEST(Compare, DifferentEstimatorsOfTheSameSceneAreTheSame) {
    EXPECT_EQ(false_alarms({rare_spikes(0.1)}, {even(), 64, "light"}), 0);
    EXPECT_EQ(false_alarms({rare_spikes(0.001)}, {even(), 64, "light"}), 0);
    EXPECT_EQ(false_alarms({rare_spikes(0.001)}, {even(), 64, "path"}), 0) << "the estimator got better";
    EXPECT_EQ(false_alarms({log_normal(2)}, {even(), 64, "light"}), 0);
}

// The twin: an ordinary z-test per pixel at the same level, as if the samples were Gaussian.
TEST(Compare, AnOrdinaryTestWouldFailHere) {
    const double limit = 5;  // two-sided p = 5.7e-7, below 1e-3 / (256 pixels x 3 channels)
    int alarms = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const RenderedImage a = render({rare_spikes(0.001)}, seed);
        const RenderedImage b = render({even()}, seed + 100);
        bool different = false;
        for (std::size_t pixel = 0; pixel < a.pixels(); ++pixel) {
            const double d = b.mean(0, pixel, 0) - a.mean(0, pixel, 0);
            different = different || std::abs(d) > limit * std::sqrt(a.variance(0, pixel, 0) + b.variance(0, pixel, 0));
        }
        alarms += different ? 1 : 0;
    }
    EXPECT_GT(alarms, 10);
}

/// Every sample is of all pixels and channels at once, as a batch or a photon out of focus is: noise is not
/// independent.
RenderedImage render_shared(double mean, std::uint64_t seed, bool told, int samples = 64) {
    Film film(kSize, kSize, {"total"}, 3);
    std::mt19937_64 random(seed);
    std::vector<double> values(static_cast<std::size_t>(film.pixels()) * 3);
    for (int sample = 0; sample < samples; ++sample) {
        const double common = uniform(random);
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = brightness(static_cast<int>(i / 3)) * mean * (common + uniform(random));
        if (told) {
            film.add_shared(values);
            continue;
        }
        for (int pixel = 0; pixel < film.pixels(); ++pixel)
            film.add(pixel, std::span(values).subspan(static_cast<std::size_t>(pixel) * 3, 3));
    }
    Provenance from;
    from.estimator = "light";
    return make_image(film, kSpec, from);
}

int shared_alarms(bool told, double mean) {
    int alarms = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed)
        alarms += compare(render_shared(1, seed, told), render_shared(mean, seed + 1000, told)).same ? 0 : 1;
    return alarms;
}

TEST(Compare, PixelsThatShareSamplesAreTheSameInEqualScenes) {
    EXPECT_EQ(shared_alarms(true, 1), 0);
    EXPECT_EQ(shared_alarms(true, 2), 100) << "and a true difference is still found";
}

// The twin: as if pixels were independent.
TEST(Compare, PixelsThatShareSamplesWithoutTellingWouldFailHere) {
    EXPECT_GT(shared_alarms(false, 1), 50);
}

// Any two of them would seem the same.
TEST(Compare, OneSampleThatAllPixelsShareCannotBeCompared) {
    EXPECT_THROW(compare(render_shared(1, 1, true, 1), render_shared(2, 2, true, 1)), InputError);
    EXPECT_THROW(compare(render_shared(1, 1, true, 64), render_shared(2, 2, true, 1)), InputError);
    EXPECT_FALSE(compare(render_shared(1, 1, false, 1), render_shared(3, 2, false, 1)).same) << "pixels apart can be";
}

TEST(Compare, SharedSamplesAgainstIndependentOnes) {
    for (std::uint64_t seed = 0; seed < 100; ++seed)
        EXPECT_TRUE(compare(render_shared(1, seed, true), render({even(), 64, "path"}, seed + 1000)).same) << seed;
}

TEST(Compare, AChannelThatAFewSamplesMissedIsNoDifference) {
    // As an estimator does whose photons have one wavelength each: here two of 256 would be of the last channel.
    const auto few_photons = [](std::uint64_t seed, bool last) {
        std::mt19937_64 random(seed);
        Film film(kSize, kSize, {"total"}, 3);
        for (int pixel = 0; pixel < film.pixels(); ++pixel) {
            film.add(pixel, std::array{0.0, 0.0, 0.0});
            const double a = uniform(random) < 0.5 ? 300 : 0;
            film.add(pixel, std::array{a, 300 - a, last && pixel % 128 == 5 ? 300.0 : 0});
        }
        Provenance from;
        from.estimator = "light";
        return make_image(film, kSpec, from);
    };
    const auto reference = [](double last) {
        return render({[last](int /*pixel*/, int channel, std::mt19937_64& random) {
                           return (channel == 2 ? last : 150) * uniform(random);
                       },
                       4000},
                      1);
    };
    EXPECT_TRUE(compare(few_photons(2, false), reference(2.3)).same);
    EXPECT_TRUE(compare(few_photons(2, true), reference(2.3)).same);
    EXPECT_FALSE(compare(few_photons(2, false), reference(150)).same) << "the twin: a channel that is really absent";
}

TEST(Compare, AnImageEqualsItself) {
    const RenderedImage a = render({log_normal(1)}, 1);
    const Comparison result = compare(a, a);
    EXPECT_TRUE(result.same);
    EXPECT_EQ(result.p_value, 1);
    EXPECT_EQ(result.pixels, 256U);
    EXPECT_EQ(result.differing, 0U);
    EXPECT_EQ(result.mean_a, result.mean_b);
}

TEST(Compare, FindsABiasOfOnePercentInTheMean) {
    const PixelSampler biased = [](int pixel, int channel, std::mt19937_64& random) {
        return log_normal(0.5)(pixel, channel, random) * (channel == 1 ? 1.01 : 1.0);
    };
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const RenderedImage a = render({log_normal(0.5), 256, "path", 32}, seed);
        const Comparison result = compare(a, render({biased, 256, "path", 32}, seed + 50));
        EXPECT_FALSE(result.same) << result.p_value;
        EXPECT_EQ(result.where, "mean of the image, total 550,000nm");
        EXPECT_EQ(result.differing, 0U) << "no pixel shows it alone";
        EXPECT_FALSE(compare(a, render({biased, 256, "light", 32}, seed + 50)).same);
    }
}

TEST(Compare, FindsOnePixelAndSaysWhich) {
    const PixelSampler changed = [](int pixel, int channel, std::mt19937_64& random) {
        return even()(pixel, channel, random) * (pixel == 5 * kSize + 3 && channel == 2 ? 3.0 : 1.0);
    };
    const Comparison result = compare(render({even(), 64}, 1), render({changed, 64}, 2));
    EXPECT_FALSE(result.same);
    EXPECT_EQ(result.differing, 1U);
    EXPECT_EQ(result.where.substr(0, 18), "pixel (3, 5), tota");
    EXPECT_GT(static_cast<double>(result.strongest[5 * kSize + 3]), result.z_limit);
}

TEST(Compare, FindsAFaintPatchThatNeitherPixelsNorTheMeanShow) {
    const PixelSampler patch = [](int pixel, int channel, std::mt19937_64& random) {
        const bool first_tile = pixel % 64 < 8 && pixel / 64 < 8;
        return even()(pixel, channel, random) * (first_tile ? 1.3 : 1.0);
    };
    const Comparison result = compare(render({even(), 16, "path", 64}, 1), render({patch, 16, "path", 64}, 2));
    EXPECT_FALSE(result.same);
    EXPECT_EQ(result.where.substr(0, 38), "mean of the 8 x 8 pixels from (0, 0), ");
}

TEST(Compare, FindsWhatOnlyAllChannelsTogetherShow) {
    const auto image = [](double factor, std::uint64_t seed) {
        const FilmSpec spec = testing::spectrometer(400, 700, 30);
        Film film(8, 8, {"total"}, 30);
        testing::fill(film, 16, seed, [factor](int pixel, int channel, std::mt19937_64& random) {
            return factor * log_normal(1)(pixel, channel, random);
        });
        return make_image(film, spec, {});
    };
    EXPECT_TRUE(compare(image(1, 1), image(1, 2)).same);
    const Comparison result = compare(image(1, 1), image(1.1, 2));
    EXPECT_FALSE(result.same);
    EXPECT_NE(result.where.find("total all channels"), std::string::npos) << result.where;
}

TEST(Compare, ABlackImageIsNotALitOne) {
    const PixelSampler black = [](int /*pixel*/, int /*channel*/, std::mt19937_64& /*random*/) { return 0.0; };
    EXPECT_FALSE(compare(render({black}, 1), render({even()}, 2)).same);
    EXPECT_FALSE(compare(render({black}, 1), render({even(), 64, "light"}, 2)).same);
    EXPECT_TRUE(compare(render({black}, 1), render({black}, 2)).same);
}

TEST(Compare, NoiseFreeImagesDifferByMoreThanRounding) {
    const auto constant = [](double value) {
        return Recipe{
            [value](int pixel, int /*channel*/, std::mt19937_64& /*random*/) { return value * brightness(pixel); }};
    };
    const RenderedImage a = render(constant(1), 1);
    EXPECT_TRUE(compare(a, render(constant(1 + 1e-6), 2)).same);
    const Comparison result = compare(a, render(constant(1 + 1e-5), 2));
    EXPECT_FALSE(result.same);
    EXPECT_EQ(result.differing, 256U);
}

TEST(Compare, ADifferenceInTheDyeIsSeenBesideABrightLaser) {
    const auto image = [](double dye, std::uint64_t seed) {
        Film film(8, 8, film_layers({"EGFP"}, false), 1);
        std::mt19937_64 random(seed);
        for (int pixel = 0; pixel < 64; ++pixel) {
            for (int i = 0; i < 64; ++i) {
                const double elastic = 1e6 * uniform(random);
                const double fluorescence = dye * uniform(random);
                film.add(pixel, std::array{elastic + fluorescence, elastic, fluorescence});
            }
        }
        return make_image(film, testing::spectrometer(400, 700, 1), {});
    };
    EXPECT_TRUE(compare(image(1, 1), image(1, 2)).same);
    const Comparison result = compare(image(1, 1), image(1.1, 2));
    EXPECT_FALSE(result.same);
    EXPECT_NE(result.where.find("fluorescence"), std::string::npos) << result.where;
}

TEST(Compare, RefusesImagesThatCannotBeCompared) {
    const RenderedImage a = render({even(), 1}, 1);
    EXPECT_THROW(compare(a, render({even(), 1, "path", 8}, 1)), InputError);
    RenderedImage photons = a;
    photons.film.unit = FilmUnit::Photons;
    EXPECT_THROW(compare(a, photons), InputError);
    RenderedImage renamed = a;
    renamed.film.channels[0].name = "other";
    EXPECT_THROW(compare(a, renamed), InputError);
    RenderedImage fewer = a;
    fewer.film.channels.pop_back();
    EXPECT_THROW(compare(a, fewer), InputError);
}

TEST(Compare, PicturesShowTheSignOfTheDifference) {
    Comparison result;
    result.z_limit = 6;
    result.strongest = {0.0F, 7.0F, -7.0F, 1.0F};
    const Picture z = difference_picture(result, 2, 2);
    EXPECT_EQ(std::vector<std::uint8_t>(z.at(0, 0), z.at(0, 0) + 3), std::vector<std::uint8_t>({255, 255, 255}));
    EXPECT_GT(z.at(1, 0)[0], z.at(1, 0)[2]);
    EXPECT_LT(z.at(0, 1)[0], z.at(0, 1)[2]);
    const Picture p = p_value_picture(result, 2, 2);
    EXPECT_EQ(p.at(0, 0)[1], 255);
    EXPECT_EQ(p.at(1, 0)[0], 230);
    EXPECT_GT(p.at(1, 1)[0], 240);
}

}  // namespace
}  // namespace fluovox
