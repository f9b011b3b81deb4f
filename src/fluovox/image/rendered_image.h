#pragma once

#include "fluovox/image/film.h"
#include "fluovox/image/film_spec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fluovox {

/// How an image came about; nothing in it differs between two runs of the same work.
struct Provenance {
    std::string scene_json;  ///< the scene with every default, from `to_json`
    std::uint64_t seed = 0;
    int samples = 0;                ///< asked for, per pixel
    std::string estimator;          ///< "path", "cached" ...
    std::vector<std::string> dyes;  ///< names of the scene's dyes; a dye file's path for those of no library
    std::string stack_note = {};    ///< which plane of which stack it is, from `exr_plane_note`; empty: of none
};

/// A finished image in memory: for each layer and channel the mean of every pixel and the variance of that mean.
struct RenderedImage {
    int width = 0;
    int height = 0;
    FilmSpec film;
    std::vector<std::string> layers;      ///< as of Film: "total" first
    std::vector<float> means;             ///< layer, channel, pixel (row 0 on top); unit as of Film
    std::vector<float> variances;         ///< of the means, divided by `variance_unit` squared; ordered as `means`
    std::vector<float> variances_of_all;  ///< layer, pixel: of all channels added up, in the same unit
    /// Where pixels share samples (photons, or batches), and empty elsewhere: of the means over regions (FilmRegions),
    /// in the same unit; layer, channel (after the last: all added up), region.
    std::vector<float> variances_of_regions;
    double variance_unit = 1;          ///< a power of ten that keeps the variances inside the range of float
    std::vector<std::int64_t> counts;  ///< samples of each pixel
    Provenance provenance;
    std::string version;  ///< of the program that made it
    std::int64_t nan_count = 0;
    std::int64_t bound_violations = 0;

    int channels() const { return static_cast<int>(film.channels.size()); }
    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    /// Index of a layer, or -1.
    int layer(const std::string& name) const;
    /// The layer that shows the dyes: "fluorescence" where it has any light, otherwise "total".
    int display_layer() const;
    /// One value for each pixel.
    std::span<const float> mean_plane(int layer, int channel) const { return plane(means, layer, channel); }
    double mean(int layer, std::size_t pixel, int channel) const {
        return static_cast<double>(mean_plane(layer, channel)[pixel]);
    }
    double variance(int layer, std::size_t pixel, int channel) const {
        const auto stored = static_cast<double>(plane(variances, layer, channel)[pixel]);
        return stored * variance_unit * variance_unit;
    }
    /// All channels of a layer added up, and the variance of that mean.
    double mean_of_all(int layer, std::size_t pixel) const {
        double sum = 0;
        for (int channel = 0; channel < channels(); ++channel)
            sum += mean(layer, pixel, channel);
        return sum;
    }
    double variance_of_all(int layer, std::size_t pixel) const {
        const auto stored = static_cast<double>(variances_of_all[static_cast<std::size_t>(layer) * pixels() + pixel]);
        return stored * variance_unit * variance_unit;
    }

    FilmRegions regions() const { return {width, height}; }
    bool shares_samples() const { return !variances_of_regions.empty(); }
    /// Only where pixels share samples.
    double variance_of_region(int layer, int channel, std::size_t region) const {
        const auto row =
            static_cast<std::size_t>(layer) * (film.channels.size() + 1) + static_cast<std::size_t>(channel);
        const auto stored = static_cast<double>(variances_of_regions[row * regions().count() + region]);
        return stored * variance_unit * variance_unit;
    }

private:
    std::span<const float> plane(const std::vector<float>& planes, int layer, int channel) const {
        const std::size_t index =
            static_cast<std::size_t>(layer) * film.channels.size() + static_cast<std::size_t>(channel);
        return std::span(planes).subspan(index * pixels(), pixels());
    }
};

/// The image that `load_exr` would read back after `save_exr` had written the film.
RenderedImage make_image(const Film& film, const FilmSpec& spec, const Provenance& provenance);

/// The power of ten by whose square the film's variances are divided before they are stored as float: 1 unless they
/// would overflow (photons per second) or vanish.
double variance_unit(const Film& film);

/// As `RenderedImage::variances_of_regions`.
std::vector<float> stored_variances_of_regions(const Film& film, double unit);

/// The variance of a mean as it is stored: divided by the square of `unit`, and never zero where it was not.
float stored_variance(double variance, double unit);

}  // namespace fluovox
