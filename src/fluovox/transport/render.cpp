#include "fluovox/transport/render.h"

#include "fluovox/transport/light_tracer.h"
#include "fluovox/transport/pixel_loop.h"
#include "fluovox/transport/pixel_renderer.h"
#include "fluovox/transport/render_cached.h"
#include "fluovox/transport/samplable.h"
#include "fluovox/volume/region.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace fluovox {
namespace {

std::vector<std::string> dye_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Dye& dye : scene.dyes)
        names.push_back(dye.name);
    return names;
}

}  // namespace

Film empty_film(const Scene& scene) {
    const SceneDescription& description = scene.description;
    return {description.camera.width, description.camera.height,
            film_layers(dye_names(scene), description.film.per_dye),
            static_cast<int>(description.film.channels.size())};
}

TrackingCounts for_each_pixel(const Scene& scene, const Illumination& illumination, PixelRenderer::Sought sought,
                              const Progress& progress, const std::function<void(PixelRenderer&, int)>& work) {
    // One renderer per thread, made when the thread first needs it; the film's pixels are each one thread's own.
    tbb::enumerable_thread_specific<std::unique_ptr<PixelRenderer>> renderers;
    const Camera& camera = scene.description.camera;
    tbb::parallel_for(tbb::blocked_range<int>(0, camera.width * camera.height, 16), [&](const auto& range) {
        auto& renderer = renderers.local();
        if (!renderer) renderer = std::make_unique<PixelRenderer>(scene, illumination, sought);
        for (int pixel = range.begin(); pixel < range.end() && !progress.stopped(); ++pixel)
            work(*renderer, pixel);
    });
    TrackingCounts counts;
    for (const auto& renderer : renderers)
        counts += renderer->counts();
    return counts;
}

EstimatorChoice chosen_estimator(const Scene& scene) {
    const RenderDescription& render = scene.description.render;
    if (render.estimator != "auto") return {render.estimator, ""};
    if (!path_shows_all_lights(scene)) return {"light", "paths from the camera cannot show every light here"};
    bool scatters = false;
    bool glows = false;
    bool finite = true;
    for (const SceneMedium& medium : scene.media) {
        scatters = scatters || !is_zero(medium.scattering);
        if (medium.dye < 0) continue;
        glows = true;
        finite = finite && (medium.grid ? medium.grid->background() == 0
                                        : std::isfinite(length(bounds_of(medium.region).size())));
    }
    const bool limited = render.max_scatterings && *render.max_scatterings > 0;
    if (!glows) return {"path", "there is no dye"};
    if (!scatters) return {"path", "nothing scatters"};
    if (!finite) return {"path", "a dye is infinite"};
    if (limited) return {"path", "the number of scatterings is limited"};
    return {"cached", "light is scattered on its way to the dyes"};
}

RenderResult render(const Scene& scene, Progress& progress) {
    const std::string estimator = chosen_estimator(scene).name;
    if (estimator == "light") return render_from_lights(scene, progress);
    if (estimator == "cached") return render_from_cache(scene, progress);
    require_samplable_by_path(scene);
    RenderResult result{empty_film(scene), {}, false};
    const Illumination illumination(scene);
    const int samples = scene.description.render.samples;
    progress.start("rendering", result.film.pixels());
    result.counts = for_each_pixel(scene, illumination, PixelRenderer::Sought::All, progress,
                                   [&](PixelRenderer& renderer, int pixel) {
                                       for (int s = 0; s < samples; ++s)
                                           result.film.add(pixel, renderer.sample(pixel, s));
                                       progress.advance(1);
                                   });
    result.film.add_bound_violations(result.counts.bound_violations);
    result.stopped = progress.stopped();
    return result;
}

}  // namespace fluovox
