#include "fluovox/transport/render.h"

#include "fluovox/optics/camera_ray.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/light_tracer.h"
#include "fluovox/transport/path_tracer.h"
#include "fluovox/transport/samplable.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace fluovox {
namespace {

/// Renders pixels of one film. What it has of its own is scratch space, so one per thread.
class PixelRenderer {
public:
    PixelRenderer(const Scene& scene, const Illumination& illumination)
        : scene_(&scene),
          tracer_(scene, illumination),
          camera_(scene.description.camera),
          response_(scene.description.film, scene.description.render.filter),
          dyes_seen_(!scene.dyes.empty() && orders(scene) > 0),
          channels_(scene.description.film.channels.size()) {
        for (std::size_t i = 0; i < illumination.lines().size(); ++i) {
            if (response_.sees(illumination.lines()[i].wavelength_nm)) visible_lines_.push_back(i);
        }
        scatterings_ = scene.description.render.max_scatterings.value_or(PathTask::kNoLimit);
    }

    void render(int x, int y, Film& film) {
        const RenderDescription& settings = scene_->description.render;
        const int pixel = y * film.width() + x;
        for (int s = 0; s < settings.samples; ++s) {
            Rng rng(settings.seed, static_cast<std::uint64_t>(pixel), static_cast<std::uint64_t>(s));
            values_.assign(film.values_per_sample(), 0);
            const Ray ray = camera_.sample(x, y, rng);
            add_continuum(ray, rng);
            add_line(ray, rng);
            if (film.layers().size() > 1) split_layers();
            film.add(pixel, values_);
        }
    }

    const TrackingCounts& counts() { return tracer_.field().counts(); }

private:
    static int orders(const Scene& scene) {
        return scene.description.render.fluorescence_orders.value_or(PathTask::kNoLimit);
    }

    std::span<double> layer(std::size_t index) { return {values_.data() + index * channels_, channels_}; }

    // Fluorescence, and what lights with a continuous spectrum send to the film unconverted.
    void add_continuum(const Ray& ray, Rng& rng) {
        const Illumination& lights = tracer_.illumination();
        if (!dyes_seen_ && !lights.has_continuous()) return;
        tracer_.field().set_optics(response_.sample(rng.uniform()), optics_);
        const PathOptics& optics = optics_;
        PathTask& task = task_;
        task.light_photons.clear();
        task.optics = &optics;
        task.orders = dyes_seen_ ? orders(*scene_) : 0;
        task.scatterings = scatterings_;
        const int count = optics.wavelengths.count;
        if (lights.has_continuous()) {
            task.light_photons.assign(scene_->lights.size(), Lanes{});
            for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
                for (int k = 0; k < count; ++k) {
                    task.light_photons[l][k] = lights.continuous_photons(static_cast<int>(l), optics.wavelengths.nm[k]);
                }
            }
        }
        tracer_.estimate(ray, task, rng, radiance_);
        for (int k = 0; k < count; ++k) {
            const double nm = optics.wavelengths.nm[k];
            const double density = count * optics.wavelengths.pdf_per_nm[k];
            response_.add(nm, radiance_.elastic[k] / density, layer(elastic_layer()));
            for (std::size_t d = 0; d < radiance_.by_dye.size(); ++d) {
                response_.add(nm, radiance_.by_dye[d][k] / density, layer(kFluorescence));
                if (scene_->description.film.per_dye) {
                    response_.add(nm, radiance_.by_dye[d][k] / density, layer(kFirstDye + d));
                }
            }
        }
    }

    // Unconverted light of one of the laser lines that the film sees.
    void add_line(const Ray& ray, Rng& rng) {
        if (visible_lines_.empty()) return;
        const auto lines = static_cast<double>(visible_lines_.size());
        const std::size_t line = visible_lines_[static_cast<std::size_t>(rng.uniform() * lines)];
        const Illumination::Line& light = tracer_.illumination().lines()[line];
        PathTask& task = task_;
        task.optics = &tracer_.line_optics(line);
        task.orders = 0;
        task.scatterings = scatterings_;
        task.light_photons.assign(scene_->lights.size(), Lanes{});
        for (std::size_t l = 0; l < scene_->lights.size(); ++l)
            task.light_photons[l][0] = light.photons[l];
        tracer_.estimate(ray, task, rng, radiance_);
        response_.add(light.wavelength_nm, lines * radiance_.elastic[0], layer(elastic_layer()));
    }

    // Layers are total, elastic, fluorescence, dyes; without dyes there is only the total.
    std::size_t elastic_layer() const { return scene_->dyes.empty() ? 0 : kElastic; }
    void split_layers() {
        for (std::size_t c = 0; c < channels_; ++c)
            layer(0)[c] = layer(kElastic)[c] + layer(kFluorescence)[c];
    }

    static constexpr std::size_t kElastic = 1, kFluorescence = 2, kFirstDye = 3;

    const Scene* scene_;
    PathTracer tracer_;
    CameraRays camera_;
    FilmResponse response_;
    bool dyes_seen_;
    std::size_t channels_;
    int scatterings_ = 0;
    std::vector<std::size_t> visible_lines_;
    std::vector<double> values_;
    PathOptics optics_;
    PathTask task_;
    PathRadiance radiance_;
};

std::vector<std::string> dye_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Dye& dye : scene.dyes)
        names.push_back(dye.name);
    return names;
}

}  // namespace

std::string chosen_estimator(const Scene& scene) {
    const std::string& wanted = scene.description.render.estimator;
    return wanted == "auto" ? "path" : wanted;
}

RenderResult render(const Scene& scene, Progress& progress) {
    if (chosen_estimator(scene) == "light") return render_from_lights(scene, progress);
    require_samplable_by_path(scene);
    const SceneDescription& description = scene.description;
    const Camera& camera = description.camera;
    RenderResult result{Film(camera.width, camera.height, film_layers(dye_names(scene), description.film.per_dye),
                             static_cast<int>(description.film.channels.size())),
                        {},
                        false};
    const Illumination illumination(scene);
    // One renderer per thread, made when the thread first needs it; the film's pixels are each one thread's own.
    tbb::enumerable_thread_specific<std::unique_ptr<PixelRenderer>> renderers;
    progress.start("rendering", result.film.pixels());
    tbb::parallel_for(tbb::blocked_range<int>(0, result.film.pixels(), 16), [&](const tbb::blocked_range<int>& range) {
        auto& renderer = renderers.local();
        if (!renderer) renderer = std::make_unique<PixelRenderer>(scene, illumination);
        for (int pixel = range.begin(); pixel < range.end() && !progress.stopped(); ++pixel) {
            renderer->render(pixel % camera.width, pixel / camera.width, result.film);
            progress.advance(1);
        }
    });
    for (const auto& renderer : renderers)
        result.counts += renderer->counts();
    result.film.add_bound_violations(result.counts.bound_violations);
    result.stopped = progress.stopped();
    return result;
}

}  // namespace fluovox
