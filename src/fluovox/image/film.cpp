#include "fluovox/image/film.h"

#include <algorithm>
#include <atomic>
#include <cmath>
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
    return true;
}

bool Film::add_sums(int pixel, std::span<const double> sums, std::span<const double> squares, std::int64_t count) {
    counts_[static_cast<std::size_t>(pixel)] += count;
    if (!all_finite(sums) || !all_finite(squares)) {
        count_bad_sample();
        return false;
    }
    const std::span<Moments> to = moments(pixel);
    for (std::size_t i = 0; i < to.size(); ++i) {
        to[i].sum += sums[i];
        to[i].squares += squares[i];
    }
    return true;
}

void Film::add_bound_violations(std::int64_t how_many) {
    add_atomically(bound_violations_, how_many);
}

double Film::mean(int layer, int pixel, int channel) const {
    const std::int64_t n = count(pixel);
    return n > 0 ? at(layer, pixel, channel).sum / static_cast<double>(n) : 0;
}

double Film::variance_of_mean(int layer, int pixel, int channel) const {
    if (count(pixel) < 2) return 0;
    const auto n = static_cast<double>(count(pixel));
    const Moments& m = at(layer, pixel, channel);
    return std::max(0.0, (m.squares - m.sum * m.sum / n) / (n - 1) / n);
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
    for (std::size_t i = 0; i < counts_.size(); ++i)
        counts_[i] += other.counts_[i];
    nan_count_ += other.nan_count_;
    bound_violations_ += other.bound_violations_;
}

std::span<Film::Moments> Film::moments(int pixel) {
    const std::size_t n = values_per_sample();
    return {moments_.data() + static_cast<std::size_t>(pixel) * n, n};
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
    const double values = static_cast<double>(layers) * static_cast<double>(spec.channels.size());
    return static_cast<double>(width) * static_cast<double>(height) *
           (values * 2 * sizeof(double) + sizeof(std::int64_t));
}

}  // namespace fluovox
