#include "fluovox/transport/photon_source.h"

#include "fluovox/optics/light_emission.h"

#include <fmt/format.h>

#include <cmath>

namespace fluovox {
namespace {

// Rays as they are in the medium where the light starts.
void into_medium(Light& light, const PhotonSpace& space, const SourceLocation& place) {
    const auto widen = [&](auto& beam) {
        if (!(beam.numerical_aperture > 0)) return;
        const double index = space.refractive_index(space.inside_at({beam.position, beam.direction}));
        if (beam.numerical_aperture >= index) {
            throw SceneError(place, fmt::format("numerical_aperture = {} must be below {}, the refractive index where "
                                                "this light starts",
                                                beam.numerical_aperture, index));
        }
        beam.numerical_aperture /= index;
    };
    if (auto* sheet = std::get_if<SheetLight>(&light.shape)) widen(*sheet);
    if (auto* beam = std::get_if<BeamLight>(&light.shape)) widen(*beam);
}

}  // namespace

PhotonSource::PhotonSource(const Scene& scene, const PhotonSpace& space) : lights_(scene.lights), space_(&space) {
    const SourceLocation place = scene.description.lights.empty() ? SourceLocation{scene.description.file, 1, 1}
                                                                  : scene.description.lights.front().where;
    for (Light& light : lights_) {
        into_medium(light, space, place);
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

void PhotonSource::favour(const std::vector<double>& worth_per_photon) {
    double worth = 0;
    for (std::size_t i = 0; i < rates_.size(); ++i)
        worth += rates_[i] * worth_per_photon[i];
    if (!(worth > 0)) return;
    shares_.clear();
    for (std::size_t i = 0; i < rates_.size(); ++i)
        shares_.push_back(0.5 * rates_[i] / total_ + 0.5 * rates_[i] * worth_per_photon[i] / worth);
}

Photon PhotonSource::launch(Rng& rng, std::size_t& light) const {
    light = 0;
    const std::vector<double>& likely = shares_.empty() ? rates_ : shares_;
    if (rates_.size() > 1) {
        double left = rng.uniform() * (shares_.empty() ? total_ : 1);
        for (std::size_t i = 0; i < rates_.size(); ++i) {
            if (rates_[i] <= 0) continue;
            light = i;
            left -= likely[i];
            if (left < 0) break;
        }
    }
    Photon photon;
    if (!shares_.empty()) photon.weight = photon.start_weight = rates_[light] / (total_ * shares_[light]);
    photon.ray = sample_emission(lights_[light], space_->bounds(), rng);
    photon.wavelength_nm = sample_emitted_wavelength(lights_[light], rng);
    photon.inside = space_->inside_at(photon.ray);
    photon.from_outside = space_->refractive_index(photon.inside) == 1;
    return photon;
}

Photon PhotonSource::launch(Rng& rng) const {
    std::size_t light = 0;
    return launch(rng, light);
}

}  // namespace fluovox
