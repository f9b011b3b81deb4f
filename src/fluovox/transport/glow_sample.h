#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/optics/camera_ray.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/film_response.h"

#include <cstdint>
#include <span>
#include <vector>

namespace fluovox {

/// One sample after the other of what dyes send to the pixels of a film, each with a ray from the camera and a single
/// wavelength. One per thread.
class GlowSample {
public:
    explicit GlowSample(const Scene& scene);

    /// Begins number `sample` of a pixel (row x width + column): nothing is seen yet.
    void begin(int pixel, std::int64_t sample);

    const Ray& ray() const { return ray_; }
    double wavelength_nm() const { return nm_; }
    double pdf_per_nm() const { return pdf_per_nm_; }
    /// What the rest of the sample is to be drawn with.
    Rng& rng() { return rng_; }

    /// Adds light of a dye, photons s^-1 um^-2 sr^-1 nm^-1 over the density of the wavelength.
    void add(std::size_t dye, double photons);

    /// A value for each layer and channel, in the order of Film::add.
    std::span<const double> values() const { return values_; }

private:
    const Scene* scene_;
    CameraRays camera_;
    FilmResponse response_;
    std::size_t channels_, layers_;
    Rng rng_{0, 0, 0};
    Ray ray_;
    double nm_ = 0, pdf_per_nm_ = 0;
    std::vector<double> values_;
};

}  // namespace fluovox
