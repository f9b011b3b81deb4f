#include "fluovox/image/compare.h"

#include "fluovox/core/error.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace fluovox {
namespace {

constexpr double kRounding = 2e-6;  // of the mean: what two roundings to float and another order of sums may do
constexpr int kTile = FilmRegions::kTile;
constexpr int kReach = 3;     // of the pixels around: 7 x 7
constexpr double kSizes = 3;  // of region: pixel, tile, image

/// Sums over the pixels of a region of what z is made of. For one pixel, its own values.
struct Evidence {
    double mean_a = 0, mean_b = 0;
    double variance_a = 0, variance_b = 0;  // times nu / (nu + 1)
    double squares = 0;                     // d^2 / (nu + 1)
    double fourth = 0;                      // squares of e, the sum of the three above
    double spread_a = 0, spread_b = 0;      // variances as they are in the images

    double expected_square() const { return variance_a + variance_b + squares; }
    void operator+=(const Evidence& other) {
        mean_a += other.mean_a;
        mean_b += other.mean_b;
        variance_a += other.variance_a;
        variance_b += other.variance_b;
        squares += other.squares;
        fourth += other.fourth;
        spread_a += other.spread_a;
        spread_b += other.spread_b;
    }
};

/// Shot noise: of a render that caught less of the same light the variance is too small in the same proportion.
double brightness_factor(double mean, double other) {
    return std::abs(mean) > 0 ? std::max(1.0, std::abs(other / mean)) : 1.0;
}

/// Variance per brightness, of each image; see `Noise`.
struct NoiseLevel {
    double a = 0, b = 0;
};

double signed_z(const Evidence& e, const NoiseLevel& least) {
    const double difference = e.mean_b - e.mean_a;
    const double brightness = std::max(std::abs(e.mean_a), std::abs(e.mean_b));
    const double size = std::abs(difference) - kRounding * brightness;
    if (size <= 0) return 0;
    const double variance_a = std::max(e.variance_a * brightness_factor(e.mean_a, e.mean_b), least.a * brightness);
    const double variance_b = std::max(e.variance_b * brightness_factor(e.mean_b, e.mean_a), least.b * brightness);
    return std::copysign(size / std::sqrt(variance_a + variance_b + e.squares), difference);
}

/// Chance of a |z| this large or larger, at most.
double p_of(double z) {
    return 2 * std::exp(-z * z / 2);
}

/// The same where a few pixels may carry most of the noise: the spread itself is then as uncertain as that of Student's
/// t with as many degrees of freedom as there are pixels that matter (Satterthwaite, Biometrics Bull. 2, 1946, 110).
double p_of_few(double z, const Evidence& e) {
    const double nu = e.fourth > 0 ? e.expected_square() * e.expected_square() / e.fourth : 1;
    return 2 * std::pow(1 + z * z / nu, -nu / 2);
}

/// One layer and channel of an image; the channel after the last stands for all of them added up.
struct Plane {
    const RenderedImage& image;
    int layer = 0, channel = 0;

    bool is_all() const { return channel == image.channels(); }
    double mean(std::size_t pixel) const {
        return is_all() ? image.mean_of_all(layer, pixel) : image.mean(layer, pixel, channel);
    }
    double variance(std::size_t pixel) const {
        return is_all() ? image.variance_of_all(layer, pixel) : image.variance(layer, pixel, channel);
    }
    /// Of the sum over a region's pixels; `apart` where they are independent.
    double variance_of_sum(std::size_t region, double apart) const {
        if (!image.shares_samples()) return apart;
        const double pixels = image.regions().box(region).pixels();
        return image.variance_of_region(layer, channel, region) * pixels * pixels;
    }
    std::string name() const {
        const auto index = static_cast<std::size_t>(channel);
        return image.layers[static_cast<std::size_t>(layer)] + ' ' +
               (is_all() ? "all channels" : image.film.channels[index].name);
    }
};

/// Variance per brightness of one layer and channel of one image: around each pixel, and over the image. It stands in
/// for the variance of pixels that may not have seen their rare samples.
struct Noise {
    std::vector<double> around;
    double image = 0;
    bool saw_nothing = false;
};

struct NoiseSum {
    double variance = 0, brightness = 0;

    void operator+=(const NoiseSum& other) {
        variance += other.variance;
        brightness += other.brightness;
    }
    double ratio() const { return brightness > 0 ? variance / brightness : 0; }
};

/// The largest variance per brightness among the channels of a layer: for those that saw nothing.
double noise_of_layer(const RenderedImage& image, int layer) {
    double most = 0;
    for (int channel = 0; channel < image.channels(); ++channel) {
        const Plane plane{image, layer, channel};
        NoiseSum all;
        for (std::size_t pixel = 0; pixel < image.pixels(); ++pixel)
            all += {plane.variance(pixel), std::abs(plane.mean(pixel))};
        most = std::max(most, all.ratio());
    }
    return most;
}

Noise noise_of(const Plane& plane) {
    const int width = plane.image.width;
    const int height = plane.image.height;
    const auto index = [width](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    };
    std::vector<NoiseSum> own(plane.image.pixels());
    NoiseSum all;
    for (std::size_t pixel = 0; pixel < own.size(); ++pixel) {
        own[pixel] = {plane.variance(pixel), std::abs(plane.mean(pixel))};
        all += own[pixel];
    }
    std::vector<NoiseSum> rows(own.size());
    const bool saw_nothing = !(all.brightness > 0);
    Noise noise{std::vector<double>(own.size()), saw_nothing ? noise_of_layer(plane.image, plane.layer) : all.ratio(),
                saw_nothing};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (int k = std::max(0, x - kReach); k <= std::min(width - 1, x + kReach); ++k)
                rows[index(x, y)] += own[index(k, y)];
        }
    }
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            NoiseSum sum;
            for (int k = std::max(0, y - kReach); k <= std::min(height - 1, y + kReach); ++k)
                sum += rows[index(x, k)];
            noise.around[index(x, y)] = std::max(sum.ratio(), noise.image);
        }
    }
    return noise;
}

double degrees_of_freedom(double variance_a, double variance_b, double count_a, double count_b) {
    const auto share = [](double variance, double count) {
        return count > 1 ? variance * variance / (count - 1) : 0.0;
    };
    const double below = share(variance_a, count_a) + share(variance_b, count_b);
    if (count_a < 2 || count_b < 2) return 0;  // nothing but the difference itself tells its spread
    if (below > 0) return (variance_a + variance_b) * (variance_a + variance_b) / below;
    return count_a + count_b - 2;
}

/// The rest of what follows from means and spreads.
Evidence complete(Evidence e, const RenderedImage& a, const RenderedImage& b, std::size_t pixel) {
    double variance_a = e.spread_a;
    double variance_b = e.spread_b;
    const auto count_a = static_cast<double>(a.counts[pixel]);
    const auto count_b = static_cast<double>(b.counts[pixel]);
    const double nu = degrees_of_freedom(variance_a, variance_b, count_a, count_b);
    if (count_a != count_b && count_a > 0 && count_b > 0 && count_a + count_b > 2 &&
        a.provenance.estimator == b.provenance.estimator) {
        const double squares = variance_a * count_a * (count_a - 1) + variance_b * count_b * (count_b - 1);
        const double pooled = squares / (count_a + count_b - 2);
        variance_a = std::max(variance_a, pooled / count_a);
        variance_b = std::max(variance_b, pooled / count_b);
    }
    const double known = nu > 0 ? nu / (nu + 1) : 1;
    e.variance_a = variance_a * known;
    e.variance_b = variance_b * known;
    e.squares = (e.mean_b - e.mean_a) * (e.mean_b - e.mean_a) / (nu + 1);
    e.fourth = e.expected_square() * e.expected_square();
    return e;
}

Evidence evidence_of(const Plane& a, const Plane& b, std::size_t pixel) {
    Evidence e;
    e.mean_a = a.mean(pixel);
    e.mean_b = b.mean(pixel);
    e.spread_a = a.variance(pixel);
    e.spread_b = b.variance(pixel);
    return complete(e, a.image, b.image, pixel);
}

/// Of a region, from the sum over its pixels: where pixels share samples the noise of their sum is another than that of
/// its parts, and the region is tested like one large pixel.
Evidence evidence_of_region(const Plane& a, const Plane& b, std::size_t region, const Evidence& pixels) {
    if (!a.image.shares_samples() && !b.image.shares_samples()) return pixels;
    Evidence e;
    e.mean_a = pixels.mean_a;
    e.mean_b = pixels.mean_b;
    e.spread_a = a.variance_of_sum(region, pixels.spread_a);
    e.spread_b = b.variance_of_sum(region, pixels.spread_b);
    return complete(e, a.image, b.image, 0);
}

/// The smallest p-value among all tests, and where it was.
struct Strongest {
    double p = 1;
    std::string where = "nowhere";

    template <typename Where>
    void offer(double p_value, const Where& place) {
        if (p_value >= p) return;
        p = p_value;
        where = place();
    }
};

class Comparing {
public:
    Comparing(const RenderedImage& a, const RenderedImage& b, double significance) : a_(a), b_(b) {
        for (const std::string& layer : a.layers) {
            if (b.layer(layer) >= 0) layers_.push_back(layer);
        }
        // All light is the sum of the layers, and a bright laser line would hide the dye in it.
        const bool parted = a.layer(kFluorescenceLayer) >= 0 && b.layer(kFluorescenceLayer) >= 0;
        if (parted) layers_.erase(std::find(layers_.begin(), layers_.end(), kTotalLayer));
        planes_ = static_cast<double>(layers_.size()) * (a.channels() + 1);
        tiles_x_ = (a.width + kTile - 1) / kTile;
        tiles_y_ = (a.height + kTile - 1) / kTile;
        result_.pixels = a.pixels();
        result_.strongest.assign(a.pixels(), 0.0F);
        result_.z_limit =
            std::sqrt(2 * std::log(2 * kSizes * planes_ * static_cast<double>(a.pixels()) / significance));
    }

    Comparison run(double significance) {
        for (const std::string& layer : layers_) {
            for (int channel = 0; channel <= a_.channels(); ++channel)
                test_plane({a_, a_.layer(layer), channel}, {b_, b_.layer(layer), channel});
        }
        result_.p_value = best_.p;
        result_.where = best_.where;
        result_.same = best_.p >= significance;
        const auto beyond = [this](float z) { return std::abs(static_cast<double>(z)) > result_.z_limit; };
        result_.differing =
            static_cast<std::size_t>(std::count_if(result_.strongest.begin(), result_.strongest.end(), beyond));
        result_.mean_a = mean_of_all_light(a_);
        result_.mean_b = mean_of_all_light(b_);
        return std::move(result_);
    }

private:
    void test_plane(const Plane& a, const Plane& b) {
        const auto named = [&](const std::string& region) { return region + ", " + a.name(); };
        const Noise noise_a = noise_of(a);
        const Noise noise_b = noise_of(b);
        const bool alike = same_noise(noise_a.image, noise_b.image);
        Evidence whole;
        std::vector<Evidence> tiles(static_cast<std::size_t>(tiles_x_ * tiles_y_));
        for (std::size_t pixel = 0; pixel < a_.pixels(); ++pixel) {
            const auto x = static_cast<int>(pixel) % a_.width;
            const auto y = static_cast<int>(pixel) / a_.width;
            const Evidence e = evidence_of(a, b, pixel);
            whole += e;
            const int tile = (y / kTile) * tiles_x_ + x / kTile;
            tiles[static_cast<std::size_t>(tile)] += e;
            const double z =
                signed_z(e, alike ? NoiseLevel{} : NoiseLevel{noise_a.around[pixel], noise_b.around[pixel]});
            float& strongest = result_.strongest[pixel];
            if (std::abs(z) > std::abs(static_cast<double>(strongest))) strongest = static_cast<float>(z);
            best_.offer(family_p(p_of(z), static_cast<double>(a_.pixels())),
                        [&] { return named(fmt::format("pixel ({}, {})", x, y)); });
        }
        for (std::size_t i = 0; i < tiles.size(); ++i) {
            const int x = static_cast<int>(i) % tiles_x_ * kTile;
            const int y = static_cast<int>(i) / tiles_x_ * kTile;
            const Evidence e = evidence_of_region(a, b, i, tiles[i]);
            const double z = signed_z(e, alike ? NoiseLevel{} : NoiseLevel{noise_a.image, noise_b.image});
            const double p = alike ? p_of(z) : p_of_few(z, tiles[i]);
            best_.offer(family_p(p, static_cast<double>(tiles.size())), [&] {
                return named(fmt::format("mean of the {0} x {0} pixels from ({1}, {2})", kTile, x, y));
            });
        }
        const NoiseLevel unseen{noise_a.saw_nothing ? noise_a.image : 0, noise_b.saw_nothing ? noise_b.image : 0};
        const double z = signed_z(evidence_of_region(a, b, a_.regions().whole(), whole), unseen);
        best_.offer(family_p(alike ? p_of(z) : p_of_few(z, whole), 1), [&] { return named("mean of the image"); });
    }

    /// Equal estimators with about equal noise: then samples could be exchanged, and no stand-in is needed for those
    /// that one of the images did not see.
    bool same_noise(double level_a, double level_b) const {
        const double per_sample_a = level_a * static_cast<double>(a_.counts.front());
        const double per_sample_b = level_b * static_cast<double>(b_.counts.front());
        return a_.provenance.estimator == b_.provenance.estimator && per_sample_a <= 2 * per_sample_b &&
               per_sample_b <= 2 * per_sample_a;
    }

    double family_p(double p, double regions) const { return std::min(1.0, p * kSizes * planes_ * regions); }

    static double mean_of_all_light(const RenderedImage& image) {
        double sum = 0;
        for (int channel = 0; channel < image.channels(); ++channel) {
            for (const float value : image.mean_plane(0, channel))
                sum += static_cast<double>(value);
        }
        return sum / static_cast<double>(image.pixels()) / image.channels();
    }

    const RenderedImage& a_;
    const RenderedImage& b_;
    std::vector<std::string> layers_;
    double planes_ = 1;
    int tiles_x_ = 1;
    int tiles_y_ = 1;
    Comparison result_;
    Strongest best_;
};

void require_comparable(const RenderedImage& a, const RenderedImage& b) {
    if (a.width != b.width || a.height != b.height) {
        throw InputError(
            fmt::format("the images differ in size: {} x {} and {} x {} pixels", a.width, a.height, b.width, b.height));
    }
    if (a.film.unit != b.film.unit) throw InputError("one image is in watts and the other in photons");
    if (a.channels() != b.channels()) {
        throw InputError(fmt::format("the images have {} and {} channels", a.channels(), b.channels()));
    }
    for (std::size_t i = 0; i < a.film.channels.size(); ++i) {
        const std::string& name_a = a.film.channels[i].name;
        const std::string& name_b = b.film.channels[i].name;
        if (name_a != name_b) {
            throw InputError(fmt::format(R"(the images have different channels: "{}" and "{}")", name_a, name_b));
        }
    }
}

// Pixels that share photons tell their noise by the spread between batches; of one batch nothing is known, and whatever
// it is compared with would seem to be the same.
void require_known_noise(const RenderedImage& image) {
    if (!image.shares_samples() || image.pixels() == 0 || image.counts.front() > 1) return;
    throw InputError(
        fmt::format("an image of the estimator {} with one sample per pixel says nothing about its noise, so that it "
                    "cannot be compared: render it with --samples 2 or more",
                    image.provenance.estimator));
}

std::uint8_t to_byte(double value) {
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

}  // namespace

Comparison compare(const RenderedImage& a, const RenderedImage& b, double significance) {
    require_comparable(a, b);
    require_known_noise(a);
    require_known_noise(b);
    return Comparing(a, b, significance).run(significance);
}

Picture difference_picture(const Comparison& comparison, int width, int height) {
    Picture picture(width, height);
    for (std::size_t i = 0; i < comparison.strongest.size(); ++i) {
        const double share = std::clamp(static_cast<double>(comparison.strongest[i]) / comparison.z_limit, -1.0, 1.0);
        const double fade = 1 - std::abs(share);
        std::uint8_t* const rgb = &picture.rgb[3 * i];
        rgb[0] = to_byte(share > 0 ? 1 - 0.30 * share : fade);
        rgb[1] = to_byte(share > 0 ? fade : 1 + 0.65 * share);
        rgb[2] = to_byte(share > 0 ? fade : 1 + 0.25 * share);
    }
    return picture;
}

Picture p_value_picture(const Comparison& comparison, int width, int height) {
    Picture picture(width, height);
    for (std::size_t i = 0; i < comparison.strongest.size(); ++i) {
        const double z = std::abs(static_cast<double>(comparison.strongest[i])) / comparison.z_limit;
        const bool beyond = z > 1;
        const std::uint8_t grey = to_byte(1 - z * z);  // the logarithm of p goes with the square of z
        std::uint8_t* const rgb = &picture.rgb[3 * i];
        rgb[0] = beyond ? std::uint8_t{230} : grey;
        rgb[1] = beyond ? std::uint8_t{30} : grey;
        rgb[2] = beyond ? std::uint8_t{30} : grey;
    }
    return picture;
}

}  // namespace fluovox
