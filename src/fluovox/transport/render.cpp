#include "fluovox/transport/render.h"

#include "fluovox/transport/collision_path.h"
#include "fluovox/transport/light_tracer.h"
#include "fluovox/transport/pixel_loop.h"
#include "fluovox/transport/pixel_renderer.h"
#include "fluovox/transport/render_cached.h"
#include "fluovox/transport/samplable.h"
#include "fluovox/volume/region.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace fluovox {
namespace {

std::vector<std::string> dye_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Dye& dye : scene.dyes)
        names.push_back(dye.name);
    return names;
}

// Independent samples of each pixel.
template <class Make>
RenderResult render_by_pixels(const Scene& scene, Progress& progress, const Make& make) {
    RenderResult result{empty_film(scene), {}, false, 0};
    const int samples = scene.description.render.samples;
    progress.start("rendering", result.film.pixels());
    result.counts = for_each_pixel(result.film.pixels(), progress, make, [&](auto& renderer, int pixel) {
        for (int sample = 0; sample < samples && !progress.stopped(); ++sample)
            result.film.add(pixel, renderer.sample(pixel, sample));
        progress.advance(1);
    });
    result.film.add_bound_violations(result.counts.bound_violations);
    result.stopped = progress.stopped();
    return result;
}

}  // namespace

Film empty_film(const Scene& scene) {
    const SceneDescription& description = scene.description;
    return {description.camera.width, description.camera.height,
            film_layers(dye_names(scene), description.film.per_dye),
            static_cast<int>(description.film.channels.size())};
}

EstimatorChoice chosen_estimator(const Scene& scene) {
    const RenderDescription& render = scene.description.render;
    if (render.estimator != "auto") return {render.estimator, ""};
    bool scatters = false;
    bool refracts = false;
    bool glows = false;
    bool finite = true;
    for (const SceneMedium& medium : scene.media) {
        scatters = scatters || !is_zero(medium.scattering);
        refracts = refracts || medium.refractive_index;
        if (medium.dye < 0) continue;
        glows = render.fluorescence_orders != 0;
        finite = finite && (medium.grid ? medium.grid->background() == 0
                                        : std::isfinite(length(bounds_of(medium.region).size())));
    }
    const bool limited = render.max_scatterings && *render.max_scatterings > 0;
    if (refracts && glows) return {"cached", "surfaces refract"};
    if (!path_shows_all_lights(scene)) return {"light", "paths from the camera cannot show every light here"};
    if (!glows) return {"path", scene.dyes.empty() ? "there is no dye" : "no light is to be converted"};
    if (!scatters) return {"path", "nothing scatters"};
    if (!finite) return {"path", "a dye is infinite"};
    if (limited) return {"path", "the number of scatterings is limited"};
    return {"cached", "light is scattered on its way to the dyes"};
}

RenderResult render(const Scene& scene, Progress& progress) {
    const std::string estimator = chosen_estimator(scene).name;
    if (estimator == "light") return render_from_lights(scene, progress);
    if (estimator == "cached") return render_from_cache(scene, progress);
    const Illumination illumination(scene);
    if (estimator == "collision") {
        require_samplable_by_collisions(scene);
        return render_by_pixels(scene, progress, [&] { return CollisionPaths(scene, illumination); });
    }
    require_samplable_by_path(scene);
    const auto& camera = scene.description.camera;
    const std::int64_t pixels = std::int64_t{camera.width} * camera.height;
    const PathPrepass prepass(scene, illumination, pixels * scene.description.render.samples);
    RenderResult result =
        render_by_pixels(scene, progress, [&] { return PixelRenderer(scene, illumination, prepass); });
    result.film.add_bound_violations(prepass.counts().bound_violations);
    result.counts.bound_violations += prepass.counts().bound_violations;
    result.guess_bytes = prepass.memory_bytes();
    return result;
}

}  // namespace fluovox
