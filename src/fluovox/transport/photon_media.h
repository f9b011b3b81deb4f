#pragma once

#include "fluovox/scene/scene.h"
#include "fluovox/transport/photon_space.h"

#include <vector>

namespace fluovox {

/// What a medium does to light of one wavelength, per micrometre: where it is constant, or per unit of its grid.
struct MediumOptics {
    double scattering = 0, absorption = 0;
};

/// A place between surfaces: which constant media overlap there and what they add up to.
struct Zone {
    Inside inside = 0;
    double index = 1;
    double scattering = 0, absorption = 0;  // per um, at the present wavelength
    std::vector<int> media;
};

/// The media of a scene at the one wavelength that a photon has. Zones are found as photons come upon them; one of
/// these per thread, as it remembers.
class PhotonMedia {
public:
    PhotonMedia(const Scene& scene, const PhotonSpace& space);

    void set_wavelength(double nm);
    /// The zone behind these surfaces. The reference holds until the next call.
    const Zone& zone(Inside inside);
    const MediumOptics& optics(int medium) const { return optics_[static_cast<std::size_t>(medium)]; }

private:
    struct Known {
        Zone zone;
        unsigned epoch = 0;  // of the wavelength that its sums are for
    };

    const Scene* scene_;
    const PhotonSpace* space_;
    std::vector<MediumOptics> optics_;
    std::vector<Known> zones_;
    double nm_ = 0;
    unsigned epoch_ = 0;
};

}  // namespace fluovox
