#include "fluovox/transport/glow_sample.h"

#include "fluovox/transport/film_layers.h"

namespace fluovox {

GlowSample::GlowSample(const Scene& scene)
    : scene_(&scene),
      camera_(scene.description.camera),
      response_(scene.description.film, scene.description.render.filter),
      channels_(scene.description.film.channels.size()),
      layers_(count_film_layers(scene)) {}

void GlowSample::begin(int pixel, std::int64_t sample) {
    const int width = scene_->description.camera.width;
    rng_ = Rng(scene_->description.render.seed, static_cast<std::uint64_t>(pixel), static_cast<std::uint64_t>(sample));
    values_.assign(layers_ * channels_, 0);
    ray_ = camera_.sample(pixel % width, pixel / width, rng_);
    const Wavelengths drawn = response_.sample_one(rng_.uniform());
    nm_ = drawn.nm[0];
    pdf_per_nm_ = drawn.pdf_per_nm[0];
}

void GlowSample::add(std::size_t dye, double photons) {
    for (const std::size_t layer : {kTotalPlace, kFluorescencePlace, kFirstDyePlace + dye}) {
        if (layer < layers_) response_.add(nm_, photons, std::span(values_).subspan(layer * channels_, channels_));
    }
}

}  // namespace fluovox
