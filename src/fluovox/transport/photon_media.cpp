#include "fluovox/transport/photon_media.h"

#include <algorithm>
#include <utility>

namespace fluovox {

PhotonMedia::PhotonMedia(const Scene& scene, const PhotonSpace& space)
    : scene_(&scene), space_(&space), optics_(scene.media.size()) {}

void PhotonMedia::set_wavelength(double nm) {
    if (nm == nm_) return;
    nm_ = nm;
    ++epoch_;
    for (std::size_t i = 0; i < optics_.size(); ++i) {
        const SceneMedium& medium = scene_->media[i];
        if (medium.dye >= 0) {
            const Dye& dye = scene_->dyes[static_cast<std::size_t>(medium.dye)];
            optics_[i] = {0, medium.amount * absorption_per_um_per_uM(dye, nm)};
        } else {
            optics_[i] = {medium.amount * coefficient_per_um(medium.scattering, nm),
                          medium.amount * coefficient_per_um(medium.absorption, nm)};
        }
    }
}

const Zone& PhotonMedia::zone(Inside inside) {
    auto known =
        std::find_if(zones_.begin(), zones_.end(), [&](const Known& other) { return other.zone.inside == inside; });
    if (known == zones_.end()) {
        Known fresh;
        fresh.zone.inside = inside;
        fresh.zone.index = space_->refractive_index(inside);
        fresh.zone.media = space_->media(inside);
        zones_.push_back(std::move(fresh));
        known = zones_.end() - 1;
    }
    Zone& zone = known->zone;
    if (known->epoch != epoch_) {
        known->epoch = epoch_;
        zone.scattering = zone.absorption = 0;
        for (const int medium : zone.media) {
            zone.scattering += optics(medium).scattering;
            zone.absorption += optics(medium).absorption;
        }
    }
    return zone;
}

}  // namespace fluovox
