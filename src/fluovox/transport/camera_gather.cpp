#include "fluovox/transport/camera_gather.h"

#include <algorithm>
#include <numbers>

namespace fluovox {

CameraGather::CameraGather(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits,
                           const ExcitationCache& cache)
    : scene_(&scene), space_(&space), cache_(&cache), tracer_(scene, space, limits), sample_(scene) {}

std::span<const double> CameraGather::sample(int pixel, std::int64_t sample) {
    sample_.begin(pixel, sample);
    by_dye_.assign(scene_->dyes.size(), 0);
    Photon importance;
    importance.ray = sample_.ray();
    importance.wavelength_nm = sample_.wavelength_nm();
    importance.inside = space_->inside_at(importance.ray);
    camera_index_ = space_->refractive_index(importance.inside);
    Sink sink(this);
    tracer_.follow(importance, sample_.rng(), sink);
    for (std::size_t d = 0; d < by_dye_.size(); ++d) {
        if (by_dye_[d] > 0) sample_.add(d, by_dye_[d] / sample_.pdf_per_nm());
    }
    return sample_.values();
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
