#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/optics/camera_ray.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/deaf_sink.h"
#include "fluovox/transport/direction_lobes.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/optical_field.h"
#include "fluovox/transport/photon.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace fluovox {

/// What one photon adds to one value of the film.
struct Splat {
    std::size_t at = 0;  ///< (pixel x layers + layer) x channels + channel
    double value = 0;
    bool begins_layer = false;   ///< summed by place: the first of its photon in its pixel and layer
    bool begins_photon = false;  ///< summed by place: the first of its photon
};

/// Splats of the photons of a batch, in their order.
using Splats = std::vector<Splat>;

/// Connects what happens to photons with the camera: a sink for PhotonTracer. One per thread.
class CameraSink : public DeafSink {
public:
    /// `photons_per_s`: what the weight 1 of a photon stands for.
    CameraSink(const Scene& scene, double photons_per_s);

    std::size_t values_per_pixel() const { return layers_ * channels_; }
    const TrackingCounts& counts() { return field_.counts(); }
    OpticalField& field() { return field_; }

    /// A photon leaves a light: what of it shines into the camera. `rng` is used until the next call.
    void start(const Photon& photon, const Light& light, Rng& rng);
    /// A photon is about to leave a dye.
    void start(Rng& rng) { rng_ = &rng; }
    /// Appends what the photon came to: as it was, or summed by place on the film.
    enum class Order { AsItWas, ByPlace };
    void finish(Splats& splats, Order order);

    /// Light that is scattered forward gets to the camera from directions about that to the camera.
    std::span<const DirectionLobe> lobes(const Photon& photon) const;

    void vertex(const Photon& photon, int medium);
    void emission(const Photon& photon);

private:
    void set_wavelength(const Photon& photon);
    template <class PerSr>
    void connect(const Photon& photon, const PerSr& per_sr);
    void connect_surface(const Photon& photon, Vec3 normal);
    void add(const Photon& photon, Vec3 from, const CameraConnection& hit, double factor);

    const Scene* scene_;
    CameraRays camera_;
    FilmResponse response_;
    OpticalField field_;
    double photons_per_s_;
    std::size_t channels_, layers_;
    std::vector<double> of_one_;  // what one photon of this wavelength adds to the channels
    bool per_dye_;
    bool seen_ = false;
    double g_ = 0;  // of what scatters most forward
    mutable std::array<DirectionLobe, 2> lobes_{};
    Rng* rng_ = nullptr;
    PathOptics optics_;
    std::vector<MediumSpan> spans_;
    Splats splats_;
};

}  // namespace fluovox
