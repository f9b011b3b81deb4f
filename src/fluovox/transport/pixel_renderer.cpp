#include "fluovox/transport/pixel_renderer.h"

#include "fluovox/image/film.h"

#include <algorithm>

namespace fluovox {

PixelRenderer::PixelRenderer(const Scene& scene, const Illumination& illumination, const PathPrepass& prepass,
                             Sought sought)
    : scene_(&scene),
      tracer_(scene, illumination, prepass),
      camera_(scene.description.camera),
      response_(scene.description.film, scene.description.render.filter),
      orders_(scene.description.render.fluorescence_orders.value_or(PathTask::kNoLimit)),
      dyes_seen_(!scene.dyes.empty() && orders_ > 0 && sought == Sought::All),
      channels_(scene.description.film.channels.size()),
      layers_(count_film_layers(scene)),
      scatterings_(scene.description.render.max_scatterings.value_or(PathTask::kNoLimit)),
      visible_lines_(illumination.lines_seen_by(response_)) {}

std::span<const double> PixelRenderer::sample(int pixel, std::int64_t sample) {
    const int width = scene_->description.camera.width;
    Rng rng(scene_->description.render.seed, static_cast<std::uint64_t>(pixel), static_cast<std::uint64_t>(sample));
    values_.assign(layers_ * channels_, 0);
    const Ray ray = camera_.sample(pixel % width, pixel / width, rng);
    add_continuum(ray, rng);
    add_line(ray, rng);
    if (layers_ > 1) split_layers();
    return values_;
}

void PixelRenderer::split_layers() {
    for (std::size_t c = 0; c < channels_; ++c)
        layer(kTotalPlace)[c] = layer(kElasticPlace)[c] + layer(kFluorescencePlace)[c];
}

// Fluorescence, and what lights with a continuous spectrum send to the film unconverted.
void PixelRenderer::add_continuum(const Ray& ray, Rng& rng) {
    const Illumination& lights = tracer_.illumination();
    if (!dyes_seen_ && !lights.has_continuous()) return;
    tracer_.field().set_optics(response_.sample(rng.uniform()), optics_);
    const PathOptics& optics = optics_;
    PathTask& task = task_;
    task.light_photons.clear();
    task.optics = &optics;
    task.orders = dyes_seen_ ? orders_ : 0;
    task.scatterings = scatterings_;
    const int count = optics.wavelengths.count();
    if (lights.has_continuous()) {
        task.light_photons.assign(scene_->lights.size(), Lanes(count));
        for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
            for (int k = 0; k < count; ++k) {
                task.light_photons[l][k] = lights.continuous_photons(static_cast<int>(l), optics.wavelengths.nm[k]);
            }
        }
    }
    tracer_.estimate(ray, task, rng, radiance_);
    response_.add(optics.wavelengths, radiance_.elastic, layer(elastic_layer()));
    for (std::size_t d = 0; d < radiance_.by_dye.size(); ++d) {
        response_.add(optics.wavelengths, radiance_.by_dye[d], layer(kFluorescencePlace));
        if (scene_->description.film.per_dye) {
            response_.add(optics.wavelengths, radiance_.by_dye[d], layer(kFirstDyePlace + d));
        }
    }
}

// Unconverted light of one of the laser lines that the film sees.
void PixelRenderer::add_line(const Ray& ray, Rng& rng) {
    if (visible_lines_.empty()) return;
    const auto lines = static_cast<double>(visible_lines_.size());
    const std::size_t line = visible_lines_[static_cast<std::size_t>(rng.uniform() * lines)];
    const Illumination::Line& light = tracer_.illumination().lines()[line];
    const double photons = tracer_.line_radiance(line, ray, scatterings_, rng);
    response_.add(light.wavelength_nm, lines * photons, layer(elastic_layer()));
}

}  // namespace fluovox
