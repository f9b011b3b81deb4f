#include "fluovox/image/response.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace fluovox {
namespace {

/// Integral of response x emission, divided by the wavelength. Both are linear between their points; the quotient is
/// summed by Simpson's rule in steps of at most 0.1 nm, where 1 / wavelength is a parabola to 1e-12.
double energy_overlap(const Spectrum& emission, const Spectrum& response) {
    const Spectrum common = product(emission, response);  // for its wavelengths
    const std::vector<double>& knots = common.wavelengths_nm();
    double total = 0;
    for (std::size_t i = 1; i < knots.size(); ++i) {
        const int steps = static_cast<int>(std::ceil((knots[i] - knots[i - 1]) / 0.1));
        const double step = (knots[i] - knots[i - 1]) / steps;
        const auto value = [&](double nm) {
            nm = std::min(nm, knots[i]);  // rounding must not step over the end of a table, where it jumps to zero
            return emission(nm) * response(nm) / nm;
        };
        for (int k = 0; k < steps; ++k) {
            const double from = knots[i - 1] + k * step;
            total += step / 6 * (value(from) + 4 * value(from + step / 2) + value(from + step));
        }
    }
    return total;
}

}  // namespace

namespace {

// The channel after the last stands for all of them added up.
double mean_of(const RenderedImage& image, int layer, std::size_t pixel, int channel) {
    return channel == image.channels() ? image.mean_of_all(layer, pixel) : image.mean(layer, pixel, channel);
}

double variance_of_pixel(const RenderedImage& image, int layer, std::size_t pixel, int channel) {
    return channel == image.channels() ? image.variance_of_all(layer, pixel) : image.variance(layer, pixel, channel);
}

/// Variance of a sum over pixels, as it is and were they independent.
struct SumVariance {
    double together = 0, apart = 0;
    double excess() const { return apart > 0 ? together / apart : 1; }
};

SumVariance variance_of(const RenderedImage& image, int layer, int channel, std::size_t part) {
    const FilmRegions::Box box = image.regions().box(part);
    SumVariance sum;
    for (int y = box.y0; y < box.y1; ++y) {
        for (int x = box.x0; x < box.x1; ++x) {
            const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
            sum.apart += variance_of_pixel(image, layer, row + static_cast<std::size_t>(x), channel);
        }
    }
    sum.together = image.variance_of_region(layer, channel, part) * box.pixels() * box.pixels();
    return sum;
}

/// By how much the variance of a region's mean is above that of independent pixels, where pixels share samples. Exact
/// for the whole image; otherwise it grows with the number of pixels, from one to what the tiles there have, and from
/// one to what the image has, whichever is more.
double excess_of_shared(const RenderedImage& image, int layer, int channel, const PixelRegion& region) {
    const FilmRegions parts = image.regions();
    const double pixels = static_cast<double>(region.x1 - region.x0) * (region.y1 - region.y0);
    const double all = parts.box(parts.whole()).pixels();
    const double of_image = variance_of(image, layer, channel, parts.whole()).excess();
    if (pixels >= all) return of_image;
    SumVariance tiles;
    for (std::size_t part = 0; part < parts.tiles(); ++part) {
        const FilmRegions::Box box = parts.box(part);
        if (box.x0 >= region.x1 || region.x0 >= box.x1 || box.y0 >= region.y1 || region.y0 >= box.y1) continue;
        const SumVariance tile = variance_of(image, layer, channel, part);
        tiles.together += tile.together;
        tiles.apart += tile.apart;
    }
    constexpr double kTilePixels = FilmRegions::kTile * FilmRegions::kTile;
    const auto between = [pixels](double most, double at) { return 1 + (most - 1) * std::min(1.0, (pixels - 1) / at); };
    return std::max(between(of_image, all), between(tiles.excess(), kTilePixels));
}

}  // namespace

SpectralResponse mean_response(const RenderedImage& image, int layer, const PixelRegion& region) {
    const bool inside = region.x0 >= 0 && region.y0 >= 0 && region.x0 < region.x1 && region.y0 < region.y1 &&
                        region.x1 <= image.width && region.y1 <= image.height;
    if (!inside) throw std::invalid_argument("mean_response: the region is empty or leaves the image");
    if (layer < 0 || layer >= static_cast<int>(image.layers.size())) {
        throw std::invalid_argument("mean_response: no such layer");
    }
    const double pixels = static_cast<double>(region.x1 - region.x0) * (region.y1 - region.y0);
    SpectralResponse response;
    for (int channel = 0; channel <= image.channels(); ++channel) {
        double sum = 0;
        double variance = 0;
        bool is_known = true;
        for (int y = region.y0; y < region.y1; ++y) {
            for (int x = region.x0; x < region.x1; ++x) {
                const auto pixel =
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
                sum += mean_of(image, layer, pixel, channel);
                variance += variance_of_pixel(image, layer, pixel, channel);
                is_known = is_known && image.counts[pixel] > 1;
            }
        }
        if (image.shares_samples()) variance *= excess_of_shared(image, layer, channel, region);
        response.mean.push_back(sum / pixels);
        response.standard_error.push_back(is_known ? std::sqrt(variance) / pixels
                                                   : std::numeric_limits<double>::quiet_NaN());
    }
    response.sum = response.mean.back();
    response.standard_error_of_sum = response.standard_error.back();
    response.mean.pop_back();
    response.standard_error.pop_back();
    return response;
}

std::vector<double> emission_on_film(const Spectrum& emission_per_nm, const FilmSpec& film) {
    std::vector<double> values;
    for (const FilmChannel& channel : film.channels) {
        const bool photons = film.unit == FilmUnit::Photons || channel.counts_photons;
        values.push_back(photons ? integral_of_product(emission_per_nm, channel.response)
                                 : energy_overlap(emission_per_nm, channel.response));
    }
    return values;
}

std::vector<double> normalized(const std::vector<double>& curve, double bin_nm) {
    const double area = std::accumulate(curve.begin(), curve.end(), 0.0) * bin_nm;
    std::vector<double> result = curve;
    for (double& value : result)
        value = area > 0 ? value / area : 0;
    return result;
}

double normalized_distance(const std::vector<double>& a, const std::vector<double>& b) {
    const std::vector<double> shape_a = normalized(a, 1);  // the bin width cancels
    const std::vector<double> shape_b = normalized(b, 1);
    double distance = 0;
    for (std::size_t i = 0; i < shape_a.size(); ++i)
        distance += std::abs(shape_a[i] - shape_b[i]);
    return distance;
}

double distance_from_noise(const SpectralResponse& response) {
    const double area = std::accumulate(response.mean.begin(), response.mean.end(), 0.0);
    const double errors = std::accumulate(response.standard_error.begin(), response.standard_error.end(), 0.0);
    return area > 0 ? std::sqrt(2 / std::numbers::pi) * errors / area : 0;  // mean |x| of a Gaussian
}

}  // namespace fluovox
