#include "fluovox/core/error.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/exr_header.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTestFile.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

std::string text_attribute(const Imf::Header& header, const char* name) {
    const auto* const attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
    if (attribute == nullptr) throw std::runtime_error(std::string("the attribute ") + name + " is missing");
    return attribute->value();
}

template <typename Number, typename Parse>
Number number_attribute(const Imf::Header& header, const char* name, Parse parse) {
    const std::string text = text_attribute(header, name);
    std::size_t used = 0;
    const auto value = static_cast<Number>(parse(text, &used));
    if (used != text.size()) throw std::runtime_error(std::string("the attribute ") + name + " is no number");
    return value;
}

std::int64_t whole_number(const Imf::Header& header, const char* name) {
    return number_attribute<std::int64_t>(header, name,
                                          [](const std::string& t, std::size_t* u) { return std::stoll(t, u); });
}

void read_header(const Imf::Header& header, RenderedImage& image) {
    image.version = text_attribute(header, exr::kVersion);
    auto [spec, layers] = exr::film_from_json(text_attribute(header, exr::kFilm));
    image.film = std::move(spec);
    image.layers = std::move(layers);
    Provenance& from = image.provenance;
    from.scene_json = text_attribute(header, exr::kScene);
    from.seed = number_attribute<std::uint64_t>(header, exr::kSeed,
                                                [](const std::string& t, std::size_t* u) { return std::stoull(t, u); });
    from.samples = static_cast<int>(whole_number(header, exr::kSamples));
    from.estimator = text_attribute(header, exr::kEstimator);
    from.dyes = exr::names_from_json(text_attribute(header, exr::kDyes));
    const auto* const stack = header.findTypedAttribute<Imf::StringAttribute>(exr::kStack);
    if (stack != nullptr) from.stack_note = stack->value();
    image.nan_count = whole_number(header, exr::kNanCount);
    image.bound_violations = whole_number(header, exr::kBoundViolations);
    image.variance_unit = number_attribute<double>(
        header, exr::kVarianceUnit, [](const std::string& t, std::size_t* u) { return std::stod(t, u); });
}

/// The size in the header of a damaged file may be anything; a file cannot be compressed by more than deflate can.
void read_size(const Imf::Header& header, const fs::path& path, RenderedImage& image) {
    const Imath::Box2i& window = header.dataWindow();
    const auto width = static_cast<double>(window.max.x) - window.min.x + 1;
    const auto height = static_cast<double>(window.max.y) - window.min.y + 1;
    constexpr double kMostCompressed = 1100;
    std::error_code ignored;
    const auto file_bytes = static_cast<double>(fs::file_size(path, ignored));
    const double planes = 2.0 * static_cast<double>(image.layers.size() * image.film.channels.size());
    if (width < 1 || height < 1 || width * height * planes * sizeof(float) > file_bytes * kMostCompressed + 4096) {
        throw std::runtime_error("its size cannot be right for a file this long");
    }
    image.width = static_cast<int>(width);
    image.height = static_cast<int>(height);
}

void insert_plane(Imf::FrameBuffer& buffer, const Imf::Header& header, const std::string& name, float* values) {
    const Imf::Channel* const channel = header.channels().findChannel(name);
    if (channel == nullptr) throw std::runtime_error("the channel " + name + " is missing");
    if (channel->xSampling != 1 || channel->ySampling != 1) {
        throw std::runtime_error("the channel " + name + " does not have every pixel");
    }
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, values, header.dataWindow()));
}

void read_pixels(Imf::InputFile& file, RenderedImage& image) {
    const Imf::Header& header = file.header();
    const std::size_t pixels = image.pixels();
    image.means.resize(image.layers.size() * image.film.channels.size() * pixels);
    image.variances.resize(image.means.size());
    image.variances_of_all.resize(image.layers.size() * pixels);
    Imf::FrameBuffer buffer;
    std::size_t offset = 0;
    for (const std::string& layer : image.layers) {
        for (const FilmChannel& channel : image.film.channels) {
            insert_plane(buffer, header, exr_channel_name(image.film, layer, channel.name, false),
                         &image.means[offset]);
            insert_plane(buffer, header, exr_channel_name(image.film, layer, channel.name, true),
                         &image.variances[offset]);
            offset += pixels;
        }
    }
    offset = 0;
    for (const std::string& layer : image.layers) {
        const std::string name = exr_channel_name(image.film, layer, exr::kAllChannels, true);
        insert_plane(buffer, header, name, &image.variances_of_all[offset]);
        offset += pixels;
    }
    std::vector<float> counts(pixels, 0);
    const bool counts_differ = header.channels().findChannel(exr::kCountChannel) != nullptr;
    if (counts_differ) insert_plane(buffer, header, exr::kCountChannel, counts.data());
    file.setFrameBuffer(buffer);
    file.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);

    image.counts.assign(pixels, whole_number(header, exr::kCount));
    for (std::size_t i = 0; i < pixels && counts_differ; ++i)
        image.counts[i] = std::llround(counts[i]);
}

/// Files without them are of estimators whose pixels share nothing (or of versions that did not tell).
void read_regions(const Imf::Header& header, RenderedImage& image) {
    const auto* const attribute = header.findTypedAttribute<Imf::FloatVectorAttribute>(exr::kRegionVariances);
    if (attribute == nullptr) return;
    image.variances_of_regions = attribute->value();
    const std::size_t values = image.layers.size() * (image.film.channels.size() + 1) * image.regions().count();
    if (image.variances_of_regions.size() != values) {
        throw std::runtime_error(std::string("the attribute ") + exr::kRegionVariances + " has another length");
    }
}

void require_sound_values(const RenderedImage& image) {
    const auto finite = [](float value) { return std::isfinite(value); };
    const auto variance = [](float value) { return std::isfinite(value) && value >= 0; };
    if (!std::all_of(image.means.begin(), image.means.end(), finite) ||
        !std::all_of(image.variances.begin(), image.variances.end(), variance) ||
        !std::all_of(image.variances_of_all.begin(), image.variances_of_all.end(), variance) ||
        !std::all_of(image.variances_of_regions.begin(), image.variances_of_regions.end(), variance)) {
        throw std::runtime_error("a pixel is not finite or has a negative variance");
    }
}

}  // namespace

RenderedImage load_exr(const fs::path& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw InputError(path.string() + ": there is no such file");
    if (fs::is_directory(path, ignored)) throw InputError(path.string() + ": is a folder, not an image");
    if (!Imf::isOpenExrFile(path.c_str())) throw InputError(path.string() + ": is not a readable OpenEXR image");
    RenderedImage image;
    try {
        Imf::InputFile file(path.c_str());
        if (file.header().findTypedAttribute<Imf::StringAttribute>(exr::kFilm) == nullptr) {
            throw InputError(path.string() + ": an OpenEXR image, but not one that fluovox rendered");
        }
        read_header(file.header(), image);
        read_size(file.header(), path, image);
        read_pixels(file, image);
        read_regions(file.header(), image);
        require_sound_values(image);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& e) {
        throw InputError(path.string() + ": truncated or damaged: " + e.what());
    }
    return image;
}

}  // namespace fluovox
