#include "fluovox/transport/film_response.h"

#include <gtest/gtest.h>

#include <vector>

namespace fluovox {
namespace {

FilmSpec bins(int count, double from_nm, double width_nm) {
    FilmSpec spec;
    spec.from_nm = from_nm;
    spec.to_nm = from_nm + count * width_nm;
    for (int b = 0; b < count; ++b) {
        const double low = from_nm + b * width_nm;
        FilmChannel bin;
        bin.center_nm = low + 0.5 * width_nm;
        bin.response = Spectrum::box(low, low + width_nm, 1);
        spec.channels.push_back(bin);
    }
    return spec;
}

TEST(FilmResponse, EachOfAFewBinsHasItsOwnWavelengthOnEveryPath) {
    const FilmSpec spec = bins(kMaxLanes, 490, 4);
    const FilmResponse response(spec, std::nullopt);
    for (const double u : {0.0, 0.013, 0.4, 0.7123, 0.9999}) {
        const Wavelengths drawn = response.sample(u);
        ASSERT_EQ(drawn.count(), kMaxLanes);
        std::vector<double> values(kMaxLanes);
        response.add(drawn, Lanes(kMaxLanes, 1), values);
        for (const double value : values)
            EXPECT_GT(value, 0) << u;
        EXPECT_EQ(response.sample_one(u).nm[0], drawn.nm[0]);
    }
}

TEST(FilmResponse, APathCarriesNoMoreThanItCan) {
    const FilmSpec spec = bins(400, 400, 1);
    EXPECT_EQ(FilmResponse(spec, std::nullopt).sample(0.5).count(), kMaxLanes);
}

TEST(FilmResponse, WavelengthsAreEvenOverWhatTheFilterPasses) {
    const FilmSpec spec = bins(28, 490, 4);
    FilterDescription filter;
    filter.passes = true;
    filter.bands = {{500, 510}, {550, 580}};
    const FilmResponse response(spec, filter);
    int in_first = 0;
    constexpr int kTurns = 100;
    for (int i = 0; i < kTurns; ++i) {
        const Wavelengths drawn = response.sample((i + 0.5) / kTurns);
        for (int k = 0; k < drawn.count(); ++k) {
            EXPECT_NEAR(drawn.pdf_per_nm[k], 1.0 / 40, 1e-9);
            EXPECT_TRUE(response.sees(drawn.nm[k])) << drawn.nm[k];
            in_first += drawn.nm[k] <= 510 ? 1 : 0;
        }
    }
    EXPECT_EQ(in_first, kMaxLanes * kTurns / 4);
}

}  // namespace
}  // namespace fluovox
