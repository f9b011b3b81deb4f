#include "fluovox/image/film.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

namespace fluovox {
namespace {

bool all_finite(std::span<const double> values) {
    // Adding x * 0 keeps the loop free of branches: only a NaN or an infinity makes the sum a NaN.
    double poison = 0;
    for (const double value : values)
        poison += value * 0;
    return poison == 0;
}

void add_atomically(std::int64_t& counter, std::int64_t how_many) {
    std::atomic_ref<std::int64_t>(counter).fetch_add(how_many, std::memory_order_relaxed);
}

}  // namespace

std::vector<std::string> film_layers(const std::vector<std::string>& dyes, bool per_dye) {
    std::vector<std::string> layers = {kTotalLayer};
    if (dyes.empty()) return layers;
    layers.insert(layers.end(), {kElasticLayer, kFluorescenceLayer});
    if (per_dye) layers.insert(layers.end(), dyes.begin(), dyes.end());
    return layers;
}

Film::Film(int width, int height, std::vector<std::string> layers, int channels)
    : width_(width), height_(height), channels_(channels), layers_(std::move(layers)) {
    if (width <= 0 || height <= 0 || channels <= 0 || layers_.empty()) throw std::invalid_argument("Film: no pixels");
    if (std::set<std::string>(layers_.begin(), layers_.end()).size() != layers_.size()) {
        throw std::invalid_argument("Film: two layers have the same name");
    }
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    moments_.resize(pixels * values_per_sample());
    squares_of_all_.resize(pixels * layers_.size());
    counts_.resize(pixels);
}

int Film::layer(const std::string& name) const {
    const auto found = std::find(layers_.begin(), layers_.end(), name);
    return found == layers_.end() ? -1 : static_cast<int>(found - layers_.begin());
}

bool Film::add(int pixel, std::span<const double> values) {
    ++counts_[static_cast<std::size_t>(pixel)];
    if (!all_finite(values)) {
        count_bad_sample();
        return false;
    }
    const std::span<Moments> to = moments(pixel);
    for (std::size_t i = 0; i < to.size(); ++i) {
        to[i].sum += values[i];
        to[i].squares += values[i] * values[i];
    }
    const auto channels = static_cast<std::size_t>(channels_);
    const std::span<double> all = squares_of_all(pixel);
    for (std::size_t layer = 0; layer < all.size(); ++layer) {
        const std::span<const double> of_layer = values.subspan(layer * channels, channels);
        const double sum = std::accumulate(of_layer.begin(), of_layer.end(), 0.0);
        all[layer] += sum * sum;
    }
    return true;
}

bool Film::add_sums(int pixel, const Sums& sums) {
    counts_[static_cast<std::size_t>(pixel)] += sums.count;
    if (!all_finite(sums.values) || !all_finite(sums.squares) || !all_finite(sums.squares_of_all)) {
        count_bad_sample();
        return false;
    }
    const std::span<Moments> to = moments(pixel);
    for (std::size_t i = 0; i < to.size(); ++i) {
        to[i].sum += sums.values[i];
        to[i].squares += sums.squares[i];
    }
    const std::span<double> all = squares_of_all(pixel);
    for (std::size_t layer = 0; layer < all.size(); ++layer)
        all[layer] += sums.squares_of_all[layer];
    return true;
}

void Film::add_shared(std::span<const double> values) {
    const std::size_t per_pixel = values_per_sample();
    const auto channels = static_cast<std::size_t>(channels_);
    const std::size_t per_layer = channels + 1;
    const FilmRegions parts = regions();
    std::vector<double> sums(region_values());
    for (int pixel = 0; pixel < pixels(); ++pixel) {
        const auto p = static_cast<std::size_t>(pixel);
        const std::span<const double> sample = values.subspan(p * per_pixel, per_pixel);
        if (!add(pixel, sample)) continue;
        const std::size_t tile = parts.tile_of(p) * layers_.size() * per_layer;
        const std::size_t whole = parts.whole() * layers_.size() * per_layer;
        for (std::size_t i = 0; i < per_pixel; ++i) {
            const std::size_t layer = i / channels * per_layer;
            for (const std::size_t region : {tile, whole}) {
                sums[region + layer + i % channels] += sample[i];
                sums[region + layer + channels] += sample[i];
            }
        }
    }
    for (double& sum : sums)
        sum *= sum;
    add_region_squares(sums);
}

void Film::add_region_squares(std::span<const double> squares) {
    region_squares_.resize(region_values());
    for (std::size_t i = 0; i < region_squares_.size(); ++i)
        region_squares_[i] += squares[i];
}

void Film::add_bound_violations(std::int64_t how_many) {
    add_atomically(bound_violations_, how_many);
}

double Film::mean(int layer, int pixel, int channel) const {
    const std::int64_t n = count(pixel);
    return n > 0 ? at(layer, pixel, channel).sum / static_cast<double>(n) : 0;
}

double Film::variance_of_mean(int layer, int pixel, int channel) const {
    return variance(at(layer, pixel, channel), pixel);
}

double Film::mean_of_all(int layer, int pixel) const {
    double sum = 0;
    for (int channel = 0; channel < channels_; ++channel)
        sum += mean(layer, pixel, channel);
    return sum;
}

double Film::variance_of_mean_of_all(int layer, int pixel) const {
    Moments all;
    for (int channel = 0; channel < channels_; ++channel)
        all.sum += at(layer, pixel, channel).sum;
    all.squares = squares_of_all_[static_cast<std::size_t>(pixel) * layers_.size() + static_cast<std::size_t>(layer)];
    return variance(all, pixel);
}

double Film::variance_of_region_mean(int layer, std::size_t region, int channel) const {
    const FilmRegions::Box box = regions().box(region);
    const bool all = channel == channels_;
    Moments moments;
    double apart = 0;  // variance of the sum, were pixels independent
    for (int y = box.y0; y < box.y1; ++y) {
        for (int pixel = y * width_ + box.x0; pixel < y * width_ + box.x1; ++pixel) {
            apart += all ? variance_of_mean_of_all(layer, pixel) : variance_of_mean(layer, pixel, channel);
            for (int c = all ? 0 : channel; c < (all ? channels_ : channel + 1); ++c)
                moments.sum += at(layer, pixel, c).sum;
        }
    }
    const double size = box.pixels();
    if (!shares_samples()) return apart / size / size;
    const std::size_t index =
        (region * layers_.size() + static_cast<std::size_t>(layer)) * (static_cast<std::size_t>(channels_) + 1) +
        static_cast<std::size_t>(channel);
    moments.squares = region_squares_[index];
    if (!std::isfinite(moments.squares)) return apart / size / size;  // of a bad sample, which its pixel has dropped
    return variance(moments, 0) / size / size;
}

double Film::variance(const Moments& moments, int pixel) const {
    if (count(pixel) < 2) return 0;
    const auto n = static_cast<double>(count(pixel));
    return std::max(0.0, (moments.squares - moments.sum * moments.sum / n) / (n - 1) / n);
}

void Film::merge(const Film& other) {
    if (other.width_ != width_ || other.height_ != height_ || other.channels_ != channels_ ||
        other.layers_ != layers_) {
        throw std::invalid_argument("Film: only films of the same size, layers and channels can be merged");
    }
    for (std::size_t i = 0; i < moments_.size(); ++i) {
        moments_[i].sum += other.moments_[i].sum;
        moments_[i].squares += other.moments_[i].squares;
    }
    for (std::size_t i = 0; i < squares_of_all_.size(); ++i)
        squares_of_all_[i] += other.squares_of_all_[i];
    if (other.shares_samples()) add_region_squares(other.region_squares_);
    for (std::size_t i = 0; i < counts_.size(); ++i)
        counts_[i] += other.counts_[i];
    nan_count_ += other.nan_count_;
    bound_violations_ += other.bound_violations_;
}

std::span<Film::Moments> Film::moments(int pixel) {
    const std::size_t n = values_per_sample();
    return {moments_.data() + static_cast<std::size_t>(pixel) * n, n};
}

std::span<double> Film::squares_of_all(int pixel) {
    return {squares_of_all_.data() + static_cast<std::size_t>(pixel) * layers_.size(), layers_.size()};
}

const Film::Moments& Film::at(int layer, int pixel, int channel) const {
    return moments_[static_cast<std::size_t>(pixel) * values_per_sample() +
                    static_cast<std::size_t>(layer) * static_cast<std::size_t>(channels_) +
                    static_cast<std::size_t>(channel)];
}

void Film::count_bad_sample() {
    add_atomically(nan_count_, 1);
}

double film_bytes(const FilmSpec& spec, int width, int height, std::size_t layers) {
    const double per_layer = 2 * static_cast<double>(spec.channels.size()) + 1;
    const double per_pixel = static_cast<double>(layers) * per_layer * sizeof(double) + sizeof(std::int64_t);
    return static_cast<double>(width) * static_cast<double>(height) * per_pixel;
}

}  // namespace fluovox
