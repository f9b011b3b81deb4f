#include "fluovox/image/preview.h"

#include "fluovox/spectral/color.h"
#include "fluovox/spectral/photons.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

namespace fluovox {
namespace {

/// What the preview needs of a film or an image: the layer to show.
struct Source {
    int width = 0;
    int height = 0;
    const FilmSpec& spec;
    std::function<double(int pixel, int channel)> value;
    std::function<bool(int pixel)> is_known;  ///< its light to better than half of itself

    int pixels() const { return width * height; }
};

/// The 97th percentile of the pixels that have light; 0 when there are none. Pixels that one bright sample made are
/// left out, unless nearly all are such.
double bright_value(const std::vector<double>& brightness, const Source& source) {
    std::vector<double> lit;
    std::vector<double> values;
    for (std::size_t i = 0; i < brightness.size(); ++i) {
        if (!(brightness[i] > 0)) continue;
        lit.push_back(brightness[i]);
        if (source.is_known(static_cast<int>(i))) values.push_back(brightness[i]);
    }
    if (values.size() < 4 || 100 * values.size() < lit.size()) values = std::move(lit);
    if (values.empty()) return 0;
    const auto rank = static_cast<std::ptrdiff_t>(0.97 * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
}

void add_scaled(Xyz& sum, const Xyz& color, double factor) {
    sum.x += factor * color.x;
    sum.y += factor * color.y;
    sum.z += factor * color.z;
}

/// The colour of each pixel in true colour, and how much of the light the eye sees.
struct TrueColor {
    std::vector<Rgb> pixels;
    std::vector<double> power;  // per area and solid angle, all wavelengths
    double visible = 0;         // share of the power, weighted by the eye's sensitivity
};

TrueColor true_color(const Source& source) {
    std::vector<Xyz> colors;
    std::vector<double> powers;
    for (const FilmChannel& channel : source.spec.channels) {
        // A bin's value is a density per nm: constant over the bin. Photons are shown as the power they carry.
        const Spectrum bin = Spectrum::box(channel.response.first_nm(), channel.response.last_nm(), 1);
        const double factor = source.spec.unit == FilmUnit::Photons ? photon_energy_J(channel.center_nm) : 1;
        colors.emplace_back();
        add_scaled(colors.back(), to_xyz(bin), factor);
        powers.push_back(bin.integral() * factor);
    }
    TrueColor result;
    double luminous = 0;
    double total = 0;
    for (int pixel = 0; pixel < source.pixels(); ++pixel) {
        Xyz color;
        double power = 0;
        for (std::size_t c = 0; c < colors.size(); ++c) {
            const double value = std::max(0.0, source.value(pixel, static_cast<int>(c)));
            add_scaled(color, colors[c], value);
            power += value * powers[c];
        }
        luminous += color.y;
        total += power;
        result.pixels.push_back(into_gamut(linear_srgb(color)));
        result.power.push_back(power);
    }
    result.visible = total > 0 ? luminous / total : 0;
    return result;
}

Preview spectral_preview(const Source& source, const Source& exposed_by) {
    constexpr double kLeastVisible = 1e-3;  // the eye's sensitivity at 720 nm
    const TrueColor image = true_color(source);
    const TrueColor bright = true_color(exposed_by);
    const bool grey = bright.visible < kLeastVisible;
    std::vector<double> brightness = bright.power;
    for (std::size_t i = 0; i < bright.pixels.size() && !grey; ++i)
        brightness[i] = std::max({bright.pixels[i].r, bright.pixels[i].g, bright.pixels[i].b});
    const double white = bright_value(brightness, exposed_by);
    Preview preview{source.width, source.height, {}, "no light"};
    if (white > 0) preview.exposure = fmt::format("{}, white = {:.4g}", grey ? "grey" : "true colour", white);
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const Rgb color = grey ? Rgb{image.power[i], image.power[i], image.power[i]} : image.pixels[i];
        for (const double component : {color.r, color.g, color.b})
            preview.rgb.push_back(white > 0 ? static_cast<float>(component / white) : 0.0F);
    }
    return preview;
}

/// A colour for each detector channel, linear, its strongest component 1.
std::vector<Rgb> colors_of_channels(const FilmSpec& spec) {
    constexpr double kTooClose_nm = 40;
    static constexpr std::array<Rgb, 6> kFalseColors = {
        {{0, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 0}, {1, 0, 0}, {0.1, 0.1, 1}}};
    std::vector<double> centers;
    for (const FilmChannel& channel : spec.channels)
        centers.push_back(channel.center_nm);
    std::sort(centers.begin(), centers.end());
    // Bins of a spectrometer have the hue of their wavelength, however close they are.
    bool close = false;
    for (std::size_t i = 1; i < centers.size() && !spec.is_spectral; ++i)
        close = close || centers[i] - centers[i - 1] < kTooClose_nm;

    std::vector<Rgb> colors;
    for (std::size_t i = 0; i < spec.channels.size(); ++i) {
        Rgb color = kFalseColors[i % kFalseColors.size()];
        if (!close) {
            const Rgb shown = display_color(spec.channels[i].center_nm);
            color = {srgb_decoded(shown.r), srgb_decoded(shown.g), srgb_decoded(shown.b)};
        }
        const double strongest = std::max({color.r, color.g, color.b, 1e-6});
        colors.push_back({color.r / strongest, color.g / strongest, color.b / strongest});
    }
    return colors;
}

Preview channel_preview(const Source& source, const Source& exposed_by) {
    const std::vector<Rgb> colors = colors_of_channels(source.spec);
    Preview preview{source.width, source.height, {}, ""};
    preview.rgb.assign(3 * static_cast<std::size_t>(source.pixels()), 0.0F);
    for (std::size_t c = 0; c < colors.size(); ++c) {
        const auto values_of = [c](const Source& of) {
            std::vector<double> values;
            values.reserve(static_cast<std::size_t>(of.pixels()));
            for (int pixel = 0; pixel < of.pixels(); ++pixel)
                values.push_back(std::max(0.0, of.value(pixel, static_cast<int>(c))));
            return values;
        };
        const std::vector<double> values = values_of(source);
        const double white = bright_value(values_of(exposed_by), exposed_by);
        preview.exposure += fmt::format("{}{} = {:.4g}", c > 0 ? ", " : "", source.spec.channels[c].name, white);
        for (std::size_t i = 0; i < values.size() && white > 0; ++i) {
            preview.rgb[3 * i] += static_cast<float>(values[i] / white * colors[c].r);
            preview.rgb[3 * i + 1] += static_cast<float>(values[i] / white * colors[c].g);
            preview.rgb[3 * i + 2] += static_cast<float>(values[i] / white * colors[c].b);
        }
    }
    return preview;
}

Preview preview_of(const Source& source, const Source& exposed_by) {
    return source.spec.is_spectral ? spectral_preview(source, exposed_by) : channel_preview(source, exposed_by);
}

Source source_of(const RenderedImage& image) {
    const int layer = image.display_layer();
    const auto is_known = [&image, layer](int pixel) {
        const double mean = image.mean_of_all(layer, static_cast<std::size_t>(pixel));
        return 4 * image.variance_of_all(layer, static_cast<std::size_t>(pixel)) < mean * mean;
    };
    const auto value = [&image, layer](int pixel, int channel) {
        return image.mean(layer, static_cast<std::size_t>(pixel), channel);
    };
    return {image.width, image.height, image.film, value, is_known};
}

int display_layer(const Film& film) {
    const int fluorescence = std::max(0, film.layer(kFluorescenceLayer));
    for (int pixel = 0; pixel < film.pixels(); ++pixel)
        if (film.mean_of_all(fluorescence, pixel) != 0) return fluorescence;
    return 0;
}

}  // namespace

Preview make_preview(const Film& film, const FilmSpec& spec) {
    const int layer = display_layer(film);
    const auto is_known = [&film, layer](int pixel) {
        const double mean = film.mean_of_all(layer, pixel);
        return 4 * film.variance_of_mean_of_all(layer, pixel) < mean * mean;
    };
    const Source source{film.width(), film.height(), spec,
                        [&film, layer](int pixel, int channel) { return film.mean(layer, pixel, channel); }, is_known};
    return preview_of(source, source);
}

Preview make_preview(const RenderedImage& image) {
    return make_preview(image, image);
}

Preview make_preview(const RenderedImage& image, const RenderedImage& exposed_by) {
    return preview_of(source_of(image), source_of(exposed_by));
}

std::vector<std::uint32_t> channel_colors(const FilmSpec& spec) {
    std::vector<std::uint32_t> colors;
    const auto byte = [](double linear) { return static_cast<std::uint32_t>(std::lround(255 * srgb_encoded(linear))); };
    for (const Rgb& color : colors_of_channels(spec))
        colors.push_back((byte(color.r) << 16U) | (byte(color.g) << 8U) | byte(color.b));
    return colors;
}

Picture to_picture(const Preview& preview) {
    Picture picture(preview.width, preview.height);
    for (std::size_t i = 0; i < picture.rgb.size(); ++i)
        picture.rgb[i] =
            static_cast<std::uint8_t>(std::lround(255 * srgb_encoded(static_cast<double>(preview.rgb[i]))));
    return picture;
}

void save_preview(const std::filesystem::path& path, const Preview& preview) {
    save_png(path, to_picture(preview), {{"Description", preview.exposure}});
}

}  // namespace fluovox
