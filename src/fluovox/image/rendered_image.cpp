#include "fluovox/image/rendered_image.h"

#include "fluovox/core/version.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace fluovox {

int RenderedImage::layer(const std::string& name) const {
    const auto found = std::find(layers.begin(), layers.end(), name);
    return found == layers.end() ? -1 : static_cast<int>(found - layers.begin());
}

int RenderedImage::display_layer() const {
    const int fluorescence = std::max(0, layer(kFluorescenceLayer));
    for (std::size_t pixel = 0; pixel < pixels(); ++pixel)
        if (mean_of_all(fluorescence, pixel) != 0) return fluorescence;
    return 0;
}

double variance_unit(const Film& film) {
    double largest = 0;
    for (int layer = 0; layer < static_cast<int>(film.layers().size()); ++layer) {
        for (int pixel = 0; pixel < film.pixels(); ++pixel) {
            for (int channel = 0; channel < film.channels(); ++channel)
                largest = std::max(largest, film.variance_of_mean(layer, pixel, channel));
            largest = std::max(largest, film.variance_of_mean_of_all(layer, pixel));
        }
    }
    if (largest == 0 || (largest > 1e-20 && largest < 1e36)) return 1;
    return std::pow(10, std::floor(std::log10(largest) / 2));
}

float stored_variance(double variance, double unit) {
    const auto stored = static_cast<float>(variance / unit / unit);
    return variance > 0 ? std::max(stored, std::numeric_limits<float>::min()) : stored;
}

std::vector<float> stored_variances_of_regions(const Film& film, double unit) {
    std::vector<float> variances;
    if (!film.shares_samples()) return variances;
    variances.reserve(film.region_values());
    for (int layer = 0; layer < static_cast<int>(film.layers().size()); ++layer) {
        for (int channel = 0; channel <= film.channels(); ++channel) {
            for (std::size_t region = 0; region < film.regions().count(); ++region)
                variances.push_back(stored_variance(film.variance_of_region_mean(layer, region, channel), unit));
        }
    }
    return variances;
}

RenderedImage make_image(const Film& film, const FilmSpec& spec, const Provenance& provenance) {
    if (static_cast<int>(spec.channels.size()) != film.channels()) {
        throw std::invalid_argument("make_image: the film has other channels than its description");
    }
    RenderedImage image;
    image.width = film.width();
    image.height = film.height();
    image.film = spec;
    image.layers = film.layers();
    image.variance_unit = variance_unit(film);
    image.provenance = provenance;
    image.version = version();
    image.nan_count = film.nan_count();
    image.bound_violations = film.bound_violations();
    for (int pixel = 0; pixel < film.pixels(); ++pixel)
        image.counts.push_back(film.count(pixel));
    image.means.reserve(film.values_per_sample() * image.pixels());
    image.variances.reserve(image.means.capacity());
    for (int layer = 0; layer < static_cast<int>(image.layers.size()); ++layer) {
        for (int channel = 0; channel < film.channels(); ++channel) {
            for (int pixel = 0; pixel < film.pixels(); ++pixel) {
                image.means.push_back(static_cast<float>(film.mean(layer, pixel, channel)));
                image.variances.push_back(
                    stored_variance(film.variance_of_mean(layer, pixel, channel), image.variance_unit));
            }
        }
        for (int pixel = 0; pixel < film.pixels(); ++pixel) {
            image.variances_of_all.push_back(
                stored_variance(film.variance_of_mean_of_all(layer, pixel), image.variance_unit));
        }
    }
    image.variances_of_regions = stored_variances_of_regions(film, image.variance_unit);
    return image;
}

}  // namespace fluovox
