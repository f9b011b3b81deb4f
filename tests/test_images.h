#pragma once

#include "fluovox/image/film.h"
#include "fluovox/image/film_spec.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace fluovox::testing {

/// A spectrometer of equal bins.
inline FilmSpec spectrometer(double from_nm, double to_nm, int bins) {
    FilmSpec spec;
    spec.from_nm = from_nm;
    spec.to_nm = to_nm;
    const double width = (to_nm - from_nm) / bins;
    for (int i = 0; i < bins; ++i) {
        const double low = from_nm + i * width;
        std::string name = fmt::format("{:.3f}nm", low + width / 2);
        std::replace(name.begin(), name.end(), '.', ',');
        spec.channels.push_back({name, low + width / 2, Spectrum::box(low, low + width, 1 / width)});
    }
    return spec;
}

inline FilmSpec two_detectors() {
    FilmSpec spec;
    spec.is_spectral = false;
    spec.channels.push_back({"green", 525, Spectrum::box(500, 550, 1)});
    spec.channels.push_back({"far red 1.0", 665, Spectrum({640, 650, 690}, {0, 0.9, 0.1}), true});
    return spec;
}

/// Fills a film: `sample(pixel, channel, random)` gives a value of the fluorescence, or of all light where there is no
/// such layer. Elastic light is a constant.
using PixelSampler = std::function<double(int pixel, int channel, std::mt19937_64& random)>;

inline void fill(Film& film, int samples, std::uint64_t seed, const PixelSampler& sample) {
    std::mt19937_64 random(seed);
    const auto channels = static_cast<std::size_t>(film.channels());
    std::vector<double> values(film.values_per_sample());
    for (int pixel = 0; pixel < film.pixels(); ++pixel) {
        for (int s = 0; s < samples; ++s) {
            for (std::size_t c = 0; c < channels; ++c) {
                const double x = sample(pixel, static_cast<int>(c), random);
                values[c] = x;
                for (std::size_t layer = 1; layer < film.layers().size(); ++layer)
                    values[layer * channels + c] = film.layers()[layer] == kElasticLayer ? 0.25 : x;
                if (film.layers().size() > 1) values[c] += 0.25;
            }
            film.add(pixel, values);
        }
    }
}

}  // namespace fluovox::testing
