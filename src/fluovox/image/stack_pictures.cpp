#include "fluovox/image/stack_pictures.h"

#include "fluovox/image/preview.h"
#include "fluovox/image/rendered_image.h"

#include <algorithm>
#include <cstddef>

namespace fluovox {
namespace {

constexpr int kLargestFrame = 256;  // pixels along the longer side
constexpr int kMostFrames = 64;

RenderedImage black(const FilmSpec& film, int width, int height) {
    RenderedImage image;
    image.width = width;
    image.height = height;
    image.film = film;
    image.layers = {kTotalLayer};
    image.means.resize(image.pixels() * film.channels.size());
    image.variances.resize(image.means.size());
    image.variances_of_all.resize(image.pixels());
    image.counts.assign(image.pixels(), 1);
    return image;
}

std::span<float> plane_of(RenderedImage& image, int channel) {
    return std::span(image.means).subspan(static_cast<std::size_t>(channel) * image.pixels(), image.pixels());
}

RenderedImage project(const StackInfo& info, const FilmSpec& film, const PlaneSource& source) {
    RenderedImage projection = black(film, info.width, info.height);
    std::vector<float> values(info.pixels());
    for (int plane = 0; plane < info.planes; ++plane) {
        for (int channel = 0; channel < projection.channels(); ++channel) {
            source(plane, channel, values);
            const std::span<float> brightest = plane_of(projection, channel);
            for (std::size_t i = 0; i < values.size(); ++i)
                brightest[i] = std::max(brightest[i], values[i]);
        }
    }
    return projection;
}

/// Blocks of `factor` x `factor` pixels averaged.
void shrink(std::span<const float> values, const StackInfo& info, int factor, RenderedImage& frame, int channel) {
    const std::span<float> small = plane_of(frame, channel);
    const auto width = static_cast<std::size_t>(info.width);
    for (int y = 0; y < frame.height; ++y) {
        for (int x = 0; x < frame.width; ++x) {
            float sum = 0;
            int count = 0;
            for (int j = y * factor; j < std::min((y + 1) * factor, info.height); ++j) {
                for (int i = x * factor; i < std::min((x + 1) * factor, info.width); ++i, ++count)
                    sum += values[static_cast<std::size_t>(j) * width + static_cast<std::size_t>(i)];
            }
            small[static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(x)] =
                sum / static_cast<float>(count);
        }
    }
}

}  // namespace

StackPictures make_stack_pictures(const StackInfo& info, const FilmSpec& film, const PlaneSource& source) {
    StackPictures pictures;
    const RenderedImage projection = project(info, film, source);
    const Preview shown = make_preview(projection);
    pictures.projection = to_picture(shown);
    pictures.exposure = shown.exposure;

    const int factor = (std::max(info.width, info.height) + kLargestFrame - 1) / kLargestFrame;
    RenderedImage frame = black(film, (info.width + factor - 1) / factor, (info.height + factor - 1) / factor);
    std::vector<float> values(info.pixels());
    const int every = (info.planes + kMostFrames - 1) / kMostFrames;
    for (int plane = 0; plane < info.planes; plane += every) {
        for (int channel = 0; channel < projection.channels(); ++channel) {
            source(plane, channel, values);
            shrink(values, info, factor, frame, channel);
        }
        pictures.frames.push_back(to_picture(make_preview(frame, projection)));
    }
    return pictures;
}

}  // namespace fluovox
