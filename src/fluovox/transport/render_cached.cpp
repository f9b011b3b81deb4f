#include "fluovox/transport/render_cached.h"

#include "fluovox/transport/excitation_cache.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/pixel_loop.h"
#include "fluovox/transport/samplable.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace fluovox {
namespace {

// Enough for error bars that are themselves within 13 % or so.
constexpr int kMostBatches = 32;

// Where the scene does not say how many photons: about as much work as the gather.
constexpr double kPhotonsPerPath = 0.25, kLeastPhotons = 1e4;

}  // namespace

RenderResult render_from_cache(const Scene& scene, Progress& progress) {
    require_samplable_with_cache(scene);
    const RenderDescription& render = scene.description.render;
    RenderResult result{empty_film(scene), {}, false};
    const Illumination illumination(scene);
    ExcitationCache cache(scene);
    const int batches = std::min(kMostBatches, render.samples);
    const double paths = static_cast<double>(result.film.pixels()) * render.samples;
    const double all_photons = render.photons.value_or(std::max(kLeastPhotons, kPhotonsPerPath * paths));
    const auto photons = static_cast<std::int64_t>(std::ceil(all_photons / batches));
    progress.start("rendering", batches * photons + std::int64_t{result.film.pixels()} * render.samples);
    for (int batch = 0; batch < batches && !progress.stopped(); ++batch) {
        cache.fill(photons, static_cast<std::uint64_t>(batch), progress);
        const auto first = std::int64_t{render.samples} * batch / batches;
        const auto last = std::int64_t{render.samples} * (batch + 1) / batches;
        result.counts += for_each_pixel(scene, illumination, &cache, progress, [&](PixelRenderer& renderer, int pixel) {
            std::vector<double> mean(result.film.values_per_sample());
            for (std::int64_t s = first; s < last; ++s) {
                const auto values = renderer.sample(pixel, s);
                for (std::size_t i = 0; i < mean.size(); ++i)
                    mean[i] += values[i] / static_cast<double>(last - first);
            }
            result.film.add(pixel, mean);
            progress.advance(last - first);
        });
    }
    result.counts.bound_violations += cache.bound_violations();
    result.film.add_bound_violations(result.counts.bound_violations);
    result.stopped = progress.stopped();
    return result;
}

}  // namespace fluovox
