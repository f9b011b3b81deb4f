#pragma once

#include "fluovox/image/film_regions.h"
#include "fluovox/image/film_spec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fluovox {

inline constexpr const char* kTotalLayer = "total";                ///< all light; always the first layer
inline constexpr const char* kElasticLayer = "elastic";            ///< light at the wavelength it left its source with
inline constexpr const char* kFluorescenceLayer = "fluorescence";  ///< light that was converted at least once

/// The layers of a film: only "total" where there is no dye (all light is elastic then); otherwise "total", "elastic",
/// "fluorescence" and, when `per_dye`, one per dye, named after it.
std::vector<std::string> film_layers(const std::vector<std::string>& dyes, bool per_dye);

/// What the camera has collected: for each pixel, layer and channel the sum and the sum of squares of its samples, and
/// for each pixel their count; also, per layer, the squares of all channels together, since the channels of one sample
/// are not independent. Means, error bars, merging and comparing need nothing else.
///
/// Values are in the unit that the film is written in (FilmSpec): W m^-2 sr^-1 nm^-1 in a spectrometer's bins, or
/// photons per second instead of watts; whoever adds samples converts. Different threads may add to different pixels at
/// once; two threads must not share a pixel.
class Film {
public:
    /// `channels` per layer. Throws std::invalid_argument unless all are positive and layer names differ.
    Film(int width, int height, std::vector<std::string> layers, int channels);

    int width() const { return width_; }
    int height() const { return height_; }
    int pixels() const { return width_ * height_; }
    int channels() const { return channels_; }
    const std::vector<std::string>& layers() const { return layers_; }
    /// Index of a layer, or -1.
    int layer(const std::string& name) const;
    /// How many values one sample has: layers x channels.
    std::size_t values_per_sample() const { return layers_.size() * static_cast<std::size_t>(channels_); }

    /// Adds one sample of a pixel: all channels of the first layer, then of the second ... A sample with a NaN or an
    /// infinity becomes zero in every value, is counted in `count` and in `nan_count`, and gives false: nothing is
    /// dropped silently, and the loss is at most `nan_count` samples. `pixel` is row x width + column, row 0 on top.
    bool add(int pixel, std::span<const double> values);

    /// Sums that were made elsewhere, of `count` samples of a pixel.
    struct Sums {
        std::span<const double> values;          ///< sums of the samples, in the order of `add`
        std::span<const double> squares;         ///< sums of their squares
        std::span<const double> squares_of_all;  ///< per layer: sum of the squares of all channels added up
        std::int64_t count = 0;
    };
    /// For estimators whose sample is a photon that may reach any pixel: sum per photon first, then call this once per
    /// pixel with the number of photons sent. Sums that are not finite count as one bad sample.
    bool add_sums(int pixel, const Sums& sums);

    /// One sample of every pixel, of random numbers that pixels share: values as of `add`, pixel after pixel. The means
    /// of regions then get variances of their own. All samples of a film are added so, or none.
    void add_shared(std::span<const double> values);
    /// The same for sums that were made elsewhere (`add_sums`): for each region, layer and channel (after the last: all
    /// of them added up) the sum over samples of the square of the sample's sum over the region's pixels.
    void add_region_squares(std::span<const double> squares);
    /// How many values those are.
    std::size_t region_values() const {
        return regions().count() * layers_.size() * (static_cast<std::size_t>(channels_) + 1);
    }
    FilmRegions regions() const { return {width_, height_}; }

    /// Counts bounds that a tracking step found exceeded; from any thread.
    void add_bound_violations(std::int64_t how_many);

    std::int64_t count(int pixel) const { return counts_[static_cast<std::size_t>(pixel)]; }
    /// Mean of the samples; 0 without samples.
    double mean(int layer, int pixel, int channel) const;
    /// Variance of `mean`: the sample variance divided by the count; 0 with fewer than two samples. Differences below
    /// 1e-8 of the mean are lost in the sum of squares.
    double variance_of_mean(int layer, int pixel, int channel) const;
    /// The same for all channels of a layer added up.
    double mean_of_all(int layer, int pixel) const;
    double variance_of_mean_of_all(int layer, int pixel) const;

    /// True where pixels share samples (photons, or batches), so that their noise is not independent.
    bool shares_samples() const { return !region_squares_.empty(); }
    /// Variance of the mean over a region's pixels, of one channel or, after the last, of all added up. Without shared
    /// samples that follows from the pixels.
    double variance_of_region_mean(int layer, std::size_t region, int channel) const;

    /// Samples that were not finite, and bounds exceeded.
    std::int64_t nan_count() const { return nan_count_; }
    std::int64_t bound_violations() const { return bound_violations_; }

    /// Adds another film of the same scene with other random numbers. Throws std::invalid_argument if size, layers or
    /// channels differ.
    void merge(const Film& other);

private:
    struct Moments {
        double sum = 0;
        double squares = 0;
    };

    std::span<Moments> moments(int pixel);
    std::span<double> squares_of_all(int pixel);
    double variance(const Moments& moments, int pixel) const;
    const Moments& at(int layer, int pixel, int channel) const;
    void count_bad_sample();

    int width_;
    int height_;
    int channels_;
    std::vector<std::string> layers_;
    std::vector<Moments> moments_;        // pixel, layer, channel
    std::vector<double> squares_of_all_;  // pixel, layer
    std::vector<double> region_squares_;  // region, layer, channel and all of them; empty where pixels share nothing
    std::vector<std::int64_t> counts_;
    std::int64_t nan_count_ = 0;
    std::int64_t bound_violations_ = 0;
};

/// Memory that a Film takes, in bytes; for the check before it is made.
double film_bytes(const FilmSpec& spec, int width, int height, std::size_t layers);

}  // namespace fluovox
