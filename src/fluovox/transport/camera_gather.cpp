#include "fluovox/transport/camera_gather.h"

#include <algorithm>
#include <numbers>

namespace fluovox {
namespace {

// Layers of a film with dyes: total, elastic, fluorescence, dyes.
constexpr std::size_t kFluorescence = 2, kFirstDye = 3;

}  // namespace

CameraGather::CameraGather(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits,
                           const ExcitationCache& cache)
    : scene_(&scene),
      space_(&space),
      cache_(&cache),
      tracer_(scene, space, limits),
      camera_(scene.description.camera),
      response_(scene.description.film, scene.description.render.filter),
      channels_(scene.description.film.channels.size()),
      layers_(kFirstDye + (scene.description.film.per_dye ? scene.dyes.size() : 0)) {}

std::span<const double> CameraGather::sample(int pixel, std::int64_t sample) {
    const int width = scene_->description.camera.width;
    Rng rng(scene_->description.render.seed, static_cast<std::uint64_t>(pixel), static_cast<std::uint64_t>(sample));
    values_.assign(layers_ * channels_, 0);
    by_dye_.assign(scene_->dyes.size(), 0);
    Photon importance;
    importance.ray = camera_.sample(pixel % width, pixel / width, rng);
    const Wavelengths drawn = response_.sample_one(rng.uniform());
    importance.wavelength_nm = drawn.nm[0];
    importance.inside = space_->inside_at(importance.ray);
    camera_index_ = space_->refractive_index(importance.inside);
    Sink sink{this};
    tracer_.follow(importance, rng, sink);
    for (std::size_t d = 0; d < by_dye_.size(); ++d) {
        if (!(by_dye_[d] > 0)) continue;
        const double photons = by_dye_[d] / drawn.pdf_per_nm[0];
        for (const std::size_t layer : {std::size_t{0}, kFluorescence, kFirstDye + d}) {
            if (layer < layers_)
                response_.add(drawn.nm[0], photons, std::span(values_).subspan(layer * channels_, channels_));
        }
    }
    return values_;
}

TrackingCounts CameraGather::counts() const {
    TrackingCounts counts;
    counts.real_collisions = tracer_.scatterings();
    counts.bound_violations = tracer_.bound_violations();
    return counts;
}

void CameraGather::collect(const Photon& photon, const Flight& flight, const Zone& zone) {
    const double index = camera_index_ / zone.index;
    for (std::size_t m = 0; m < scene_->media.size(); ++m) {
        if (scene_->media[m].dye < 0) continue;
        const auto d = static_cast<std::size_t>(scene_->media[m].dye);
        const Dye& dye = scene_->dyes[d];
        const double emitted = dye.quantum_yield * dye.emission_per_nm(photon.wavelength_nm);
        if (!(emitted > 0)) continue;
        const double glow = cache_->absorbed_along(m, flight.ray, flight.length_um, flight.weight, zone.absorption);
        by_dye_[d] += index * index * emitted * glow / (4 * std::numbers::pi);
    }
}

}  // namespace fluovox
