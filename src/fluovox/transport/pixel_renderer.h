#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/optics/camera_ray.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/film_layers.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/path_tracer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace fluovox {

/// Samples of the pixels of a film, by paths from the camera. What it has of its own is scratch space, so one per
/// thread.
class PixelRenderer {
public:
    /// What of the light is looked for; layers of other light stay zero.
    enum class Sought { All, Elastic };

    /// `prepass`: see PathTracer; it must outlive it.
    PixelRenderer(const Scene& scene, const Illumination& illumination, const PathPrepass& prepass = {},
                  Sought sought = Sought::All);

    /// One sample of a pixel (row x width + column) with the random numbers of number `sample`: a value for each layer
    /// and channel, in the order of Film::add. Holds until the next call.
    std::span<const double> sample(int pixel, std::int64_t sample);

    const TrackingCounts& counts() { return tracer_.field().counts(); }

private:
    void add_continuum(const Ray& ray, Rng& rng);
    void add_line(const Ray& ray, Rng& rng);

    std::size_t elastic_layer() const { return scene_->dyes.empty() ? kTotalPlace : kElasticPlace; }
    std::span<double> layer(std::size_t index) { return {values_.data() + index * channels_, channels_}; }
    void split_layers();

    const Scene* scene_;
    PathTracer tracer_;
    CameraRays camera_;
    FilmResponse response_;
    int orders_;
    bool dyes_seen_;
    std::size_t channels_, layers_;
    int scatterings_;
    std::vector<std::size_t> visible_lines_;
    std::vector<double> values_;
    PathOptics optics_;
    PathTask task_;
    PathRadiance radiance_;
};

}  // namespace fluovox
