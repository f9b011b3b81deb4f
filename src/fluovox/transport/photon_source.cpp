#include "fluovox/transport/photon_source.h"

#include "fluovox/optics/light_emission.h"

#include <cmath>

namespace fluovox {

PhotonSource::PhotonSource(const Scene& scene, const PhotonSpace& space) : scene_(&scene), space_(&space) {
    const SourceLocation place = scene.description.lights.empty() ? SourceLocation{scene.description.file, 1, 1}
                                                                  : scene.description.lights.front().where;
    for (const Light& light : scene.lights) {
        rates_.push_back(emitted_photons(light, space.bounds()));
        total_ += rates_.back();
        if (!std::isfinite(rates_.back())) {
            throw SceneError(place,
                             "uniform light comes in through the box around all media, but a medium here is infinite; "
                             "give every medium a finite region, or use another light");
        }
    }
    if (!(total_ > 0)) throw SceneError(place, "no light sends out any photons; give the scene a light with power");
}

Photon PhotonSource::launch(Rng& rng, std::size_t& light) const {
    light = 0;
    if (rates_.size() > 1) {
        double left = rng.uniform() * total_;
        for (std::size_t i = 0; i < rates_.size(); ++i) {
            if (rates_[i] <= 0) continue;
            light = i;
            left -= rates_[i];
            if (left < 0) break;
        }
    }
    Photon photon;
    photon.ray = sample_emission(scene_->lights[light], space_->bounds(), rng);
    photon.wavelength_nm = sample_emitted_wavelength(scene_->lights[light], rng);
    photon.inside = space_->inside_at(photon.ray);
    photon.from_outside = space_->refractive_index(photon.inside) == 1;
    return photon;
}

Photon PhotonSource::launch(Rng& rng) const {
    std::size_t light = 0;
    return launch(rng, light);
}

}  // namespace fluovox
