#include "fluovox/transport/render_cached.h"

#include "fluovox/transport/camera_gather.h"
#include "fluovox/transport/dye_glow.h"
#include "fluovox/transport/excitation_cache.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/photon_rounds.h"
#include "fluovox/transport/pixel_loop.h"
#include "fluovox/transport/pixel_renderer.h"
#include "fluovox/transport/samplable.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace fluovox {
namespace {

// Enough for error bars that are themselves within 13 % or so.
constexpr int kMostBatches = 32;

// Where the scene does not say how many photons. Far from a sheet most of the noise is theirs.
constexpr double kPhotonsPerSample = 1, kLeastPhotons = 1e4;

bool film_sees_lights(const Scene& scene) {
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    return std::any_of(scene.lights.begin(), scene.lights.end(),
                       [&](const Light& light) { return film.sees(light.spectrum); });
}

// The cache has all conversions but the last.
PhotonLimits limits_after_the_dye(const RenderDescription& render) {
    PhotonLimits limits;
    limits.orders = 1;
    limits.minor_conversions = true;
    if (render.max_scatterings) {
        limits.scatterings = *render.max_scatterings;
        limits.scatterings_are_physical = true;
    }
    return limits;
}

// Importance is not converted.
PhotonLimits limits_from_the_camera(const RenderDescription& render) {
    PhotonLimits limits = limits_after_the_dye(render);
    limits.orders = 0;
    return limits;
}

/// The passes of the estimator, batch by batch.
class CachedRender {
public:
    CachedRender(const Scene& scene, Progress& progress)
        : scene_(&scene),
          progress_(&progress),
          result_{empty_film(scene), {}, false},
          space_(scene),
          illumination_(scene),
          cache_(scene),
          glow_(scene, space_, illumination_, cache_),
          rounds_(scene, space_, limits_after_the_dye(scene.description.render), 1),
          elastic_(film_sees_lights(scene)),
          glows_(scene.description.render.fluorescence_orders.value_or(1) > 0),
          sums_(static_cast<std::size_t>(result_.film.pixels()) * result_.film.values_per_sample()) {}

    RenderResult run() {
        const RenderDescription& render = scene_->description.render;
        const int batches = std::min(kMostBatches, render.samples);
        const double paths = static_cast<double>(result_.film.pixels()) * render.samples;
        const double all_photons = render.photons.value_or(std::max(kLeastPhotons, kPhotonsPerSample * paths));
        const auto photons = static_cast<std::int64_t>(std::ceil(all_photons / batches));
        const std::int64_t passes = (glows_ ? 1 : 0) + (elastic_ ? 1 : 0);
        progress_->start("rendering", (glows_ ? batches * photons : 0) +
                                          passes * result_.film.pixels() * std::int64_t{render.samples});
        for (int batch = 0; batch < batches && !progress_->stopped(); ++batch) {
            const Samples samples{std::int64_t{render.samples} * batch / batches,
                                  std::int64_t{render.samples} * (batch + 1) / batches};
            std::fill(sums_.begin(), sums_.end(), 0);
            if (elastic_) add_elastic(samples);
            if (glows_) {
                cache_.fill(photons, static_cast<std::uint64_t>(batch), *progress_);
                add_fluorescence(static_cast<std::uint64_t>(batch), samples);
            }
            result_.film.add_shared(sums_);
        }
        result_.counts += rounds_.counts();
        result_.counts.bound_violations += cache_.bound_violations();
        result_.film.add_bound_violations(result_.counts.bound_violations);
        result_.stopped = progress_->stopped();
        return std::move(result_);
    }

private:
    struct Samples {
        std::int64_t first, last;
    };

    std::span<double> values_of(int pixel) {
        const std::size_t values = result_.film.values_per_sample();
        return std::span(sums_).subspan(static_cast<std::size_t>(pixel) * values, values);
    }

    // Paths from the camera.
    template <class Make>
    void add_paths(Samples samples, const Make& make) {
        const auto count = static_cast<double>(samples.last - samples.first);
        result_.counts += for_each_pixel(result_.film.pixels(), *progress_, make, [&](auto& renderer, int pixel) {
            const std::span<double> sums = values_of(pixel);
            for (std::int64_t s = samples.first; s < samples.last && !progress_->stopped(); ++s) {
                const auto values = renderer.sample(pixel, s);
                for (std::size_t i = 0; i < sums.size(); ++i)
                    sums[i] += values[i] / count;
            }
            progress_->advance(samples.last - samples.first);
        });
    }

    // Light that was not converted.
    void add_elastic(Samples samples) {
        add_paths(samples, [&] { return PixelRenderer(*scene_, illumination_, {}, PixelRenderer::Sought::Elastic); });
    }

    void add_fluorescence(std::uint64_t batch, Samples samples) {
        if (space_.refracts()) {
            const PhotonLimits limits = limits_from_the_camera(scene_->description.render);
            add_paths(samples, [&] { return CameraGather(*scene_, space_, limits, cache_); });
        } else {
            add_photons(batch, samples);
        }
    }

    // As many photons leave the dyes as there are samples.
    void add_photons(std::uint64_t batch, Samples samples) {
        const std::int64_t photons = result_.film.pixels() * (samples.last - samples.first);
        glow_.place(batch, photons, *progress_);
        if (!glow_.glows()) {
            progress_->advance(photons);
            return;
        }
        const auto trace = [&](PhotonRounds::Worker& worker, std::int64_t n) { emit(worker, batch, n, photons); };
        rounds_.trace(photons, *progress_, CameraSink::Order::AsItWas, trace, [&](std::span<const Splat> splats) {
            for (const Splat& splat : splats)
                sums_[splat.at] += splat.value;
        });
    }

    void emit(PhotonRounds::Worker& worker, std::uint64_t batch, std::int64_t n, std::int64_t of_all) {
        const RenderDescription& render = scene_->description.render;
        Rng rng(render.seed, ~batch - kMostBatches, static_cast<std::uint64_t>(n));
        DyeGlow::Emission emission = glow_.emit(n, of_all, worker.sink.field(), rng);
        Photon& photon = emission.photon;
        if (!(photon.weight > 0)) return;
        worker.sink.start(rng);
        worker.sink.emission(photon);
        // What the cache holds was scattered: where that is limited to once, it must not be again.
        if (render.max_scatterings && emission.scattered) return;
        worker.tracer.emit(photon, rng, worker.sink);
        worker.tracer.follow(photon, rng, worker.sink);
    }

    const Scene* scene_;
    Progress* progress_;
    RenderResult result_;
    PhotonSpace space_;
    Illumination illumination_;
    ExcitationCache cache_;
    DyeGlow glow_;
    PhotonRounds rounds_;
    bool elastic_, glows_;
    std::vector<double> sums_;  // of a batch: pixel, layer, channel
};

}  // namespace

RenderResult render_from_cache(const Scene& scene, Progress& progress) {
    require_samplable_with_cache(scene);
    return CachedRender(scene, progress).run();
}

}  // namespace fluovox
