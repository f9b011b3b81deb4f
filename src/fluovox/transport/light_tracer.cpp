#include "fluovox/transport/light_tracer.h"

#include "fluovox/optics/camera_ray.h"
#include "fluovox/transport/endless.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/optical_field.h"
#include "fluovox/transport/photon_source.h"
#include "fluovox/transport/photon_tracer.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace fluovox {
namespace {

// Layers of the film, where there are dyes; otherwise there is only the first.
constexpr std::size_t kElastic = 1, kFluorescence = 2, kFirstDye = 3;

/// What one photon adds to one value of the film.
struct Splat {
    std::size_t at = 0;  // (pixel x layers + layer) x channels + channel
    double value = 0;
    bool begins_layer = false;  // the first of its photon in its pixel and layer
};

/// Splats of the photons of a batch, in their order.
using Batch = std::vector<Splat>;

/// Connects what happens to photons with the camera.
class CameraSink {
public:
    CameraSink(const Scene& scene, double photons_per_s)
        : scene_(&scene),
          camera_(scene.description.camera),
          response_(scene.description.film, scene.description.render.filter),
          field_(scene),
          photons_per_s_(photons_per_s),
          channels_(scene.description.film.channels.size()),
          values_(channels_),
          per_dye_(scene.description.film.per_dye) {
        layers_ = scene.dyes.empty() ? 1 : kFirstDye + (per_dye_ ? scene.dyes.size() : 0);
    }

    std::size_t values_per_pixel() const { return layers_ * channels_; }
    const TrackingCounts& counts() { return field_.counts(); }

    /// A photon sets out; what it comes to goes into `batch` when it is done.
    void start(const Photon& photon, const Light& light, Rng& rng) {
        rng_ = &rng;
        set_wavelength(photon);
        if (!seen_) return;
        if (const auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
            connect_surface(photon, rectangle->normal);
        } else if (!std::holds_alternative<PointLight>(light.shape)) {
            if (const auto hit = camera_.catch_ray(photon.ray)) add(photon, photon.ray.origin, *hit, hit->factor);
        }
    }
    void finish(Batch& batch) {
        std::stable_sort(splats_.begin(), splats_.end(), [](const Splat& a, const Splat& b) { return a.at < b.at; });
        const std::size_t first = batch.size();
        for (std::size_t i = 0; i < splats_.size();) {
            Splat sum = splats_[i];
            for (++i; i < splats_.size() && splats_[i].at == sum.at; ++i)
                sum.value += splats_[i].value;
            sum.begins_layer = batch.size() == first || batch.back().at / channels_ != sum.at / channels_;
            batch.push_back(sum);
        }
        splats_.clear();
    }

    void vertex(const Photon& photon, int medium) {
        if (!seen_) return;
        const auto hit = camera_.connect(photon.ray.origin, *rng_);
        if (!hit) return;
        const PhaseFunction& scattering = scene_->media[static_cast<std::size_t>(medium)].phase;
        const double phase = phase_per_sr(scattering, dot(photon.ray.direction, hit->to_camera));
        add(photon, photon.ray.origin, *hit, phase * hit->factor);
    }
    void emission(const Photon& photon) {
        set_wavelength(photon);
        if (!seen_) return;
        const auto hit = camera_.connect(photon.ray.origin, *rng_);
        if (hit) add(photon, photon.ray.origin, *hit, hit->factor / (4 * std::numbers::pi));
    }

    void flight(const Photon& /*photon*/, const Flight& /*flight*/, const Zone& /*zone*/) {}
    void absorbed(const Photon& /*photon*/, int /*medium*/, double /*weight*/) {}
    void absorbed(const Photon& /*photon*/, int /*medium*/, double /*weight*/, Vec3 /*position*/) {}
    void converted(const Photon& /*photon*/, int /*dye*/, double /*absorbed*/, double /*reemitted*/) {}
    void escaped(const Photon& /*photon*/) {}
    void cut(const Photon& /*photon*/, double /*weight*/) {}

private:
    void set_wavelength(const Photon& photon) {
        seen_ = response_.sees(photon.wavelength_nm);
        if (!seen_ || photon.wavelength_nm == optics_.wavelengths.nm[0]) return;
        Wavelengths one;
        one.count = 1;
        one.nm[0] = photon.wavelength_nm;
        one.pdf_per_nm[0] = 1;
        field_.set_optics(one, optics_);
    }

    // Lambertian light as it leaves its surface.
    void connect_surface(const Photon& photon, Vec3 normal) {
        const auto hit = camera_.connect(photon.ray.origin, *rng_);
        if (!hit) return;
        const double cosine = dot(normal, hit->to_camera);
        if (cosine > 0) add(photon, photon.ray.origin, *hit, cosine / std::numbers::pi * hit->factor);
    }

    void add(const Photon& photon, Vec3 from, const CameraConnection& hit, double factor) {
        const Ray ray{from, hit.to_camera};
        field_.gather(ray, spans_);
        const double passed = field_.transmittance(ray, spans_, hit.distance_um, optics_, Loss::Extinction, *rng_)[0];
        if (!(passed > 0)) return;
        std::fill(values_.begin(), values_.end(), 0);
        response_.add(photon.wavelength_nm, photons_per_s_ * photon.weight * factor * passed, values_);
        const std::size_t pixel =
            static_cast<std::size_t>(hit.y) * static_cast<std::size_t>(scene_->description.camera.width) +
            static_cast<std::size_t>(hit.x);
        const bool converted = photon.order > 0;
        for (std::size_t c = 0; c < channels_; ++c) {
            if (values_[c] == 0) continue;
            splat(pixel, 0, c);
            if (layers_ > 1) splat(pixel, converted ? kFluorescence : kElastic, c);
            if (converted && per_dye_) splat(pixel, kFirstDye + static_cast<std::size_t>(photon.dye), c);
        }
    }
    void splat(std::size_t pixel, std::size_t layer, std::size_t channel) {
        splats_.push_back({pixel * values_per_pixel() + layer * channels_ + channel, values_[channel], false});
    }

    const Scene* scene_;
    CameraRays camera_;
    FilmResponse response_;
    OpticalField field_;
    double photons_per_s_;
    std::size_t channels_, layers_ = 1;
    std::vector<double> values_;
    bool per_dye_;
    bool seen_ = false;
    Rng* rng_ = nullptr;
    PathOptics optics_;
    std::vector<MediumSpan> spans_;
    std::vector<Splat> splats_;
};

struct Worker {
    Worker(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits, double photons_per_s)
        : tracer(scene, space, limits), sink(scene, photons_per_s) {}
    PhotonTracer<CameraSink> tracer;
    CameraSink sink;
};

/// Sums of the film's values over photons.
class FilmSums {
public:
    explicit FilmSums(const Film& film)
        : values_(film.values_per_sample()),
          layers_(film.layers().size()),
          channels_(values_ / layers_),
          sum_(static_cast<std::size_t>(film.pixels()) * values_),
          squares_(sum_.size()),
          squares_of_all_(static_cast<std::size_t>(film.pixels()) * layers_) {}

    void add(const Batch& batch) {
        for (std::size_t i = 0; i < batch.size();) {
            double all = 0;
            const std::size_t layer = batch[i].at / channels_;
            do {
                const Splat& splat = batch[i];
                sum_[splat.at] += splat.value;
                squares_[splat.at] += splat.value * splat.value;
                all += splat.value;
                ++i;
            } while (i < batch.size() && !batch[i].begins_layer);
            squares_of_all_[layer] += all * all;
        }
    }
    void put_on(Film& film, std::int64_t photons) const {
        for (int pixel = 0; pixel < film.pixels(); ++pixel) {
            const auto p = static_cast<std::size_t>(pixel);
            Film::Sums sums;
            sums.values = std::span(sum_).subspan(p * values_, values_);
            sums.squares = std::span(squares_).subspan(p * values_, values_);
            sums.squares_of_all = std::span(squares_of_all_).subspan(p * layers_, layers_);
            sums.count = photons;
            film.add_sums(pixel, sums);
        }
    }

private:
    std::size_t values_, layers_, channels_;
    std::vector<double> sum_, squares_, squares_of_all_;
};

PhotonLimits limits_of(const RenderDescription& render) {
    PhotonLimits limits;
    limits.orders = render.fluorescence_orders.value_or(std::numeric_limits<int>::max());
    if (render.max_scatterings) {
        limits.scatterings = *render.max_scatterings;
        limits.scatterings_are_physical = true;
    }
    return limits;
}

void require_connectable(const Scene& scene) {
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    for (const MediumDescription& medium : scene.description.media) {
        if (medium.refractive_index) {
            throw SceneError(medium.where,
                             "the estimator \"light\" connects photons straight to the camera and cannot find the way "
                             "through a refracting surface; leave refractive_index out, or use fluovox fluence, which "
                             "counts what leaves each face");
        }
    }
    for (const LightDescription& description : scene.description.lights) {
        if (!std::holds_alternative<UniformLight>(description.light.shape)) continue;
        const auto& spectrum = description.light.spectrum;
        const auto& knots = spectrum.energy_per_nm.wavelengths_nm();
        const bool seen = std::any_of(spectrum.lines.begin(), spectrum.lines.end(),
                                      [&](const auto& line) { return film.sees(line.wavelength_nm); }) ||
                          std::any_of(knots.begin(), knots.end(), [&](double nm) { return film.sees(nm); });
        if (seen) {
            throw SceneError(description.where,
                             "the camera sees uniform light directly, which the estimator \"light\" cannot show; block "
                             "its wavelengths (render.filter) or use the estimator \"path\"");
        }
    }
}

std::vector<std::string> dye_names(const Scene& scene) {
    std::vector<std::string> names;
    for (const Dye& dye : scene.dyes)
        names.push_back(dye.name);
    return names;
}

void trace_batch(const Scene& scene, const PhotonSource& source, std::int64_t first, std::int64_t last, Worker& worker,
                 Batch& batch) {
    for (std::int64_t n = first; n < last; ++n) {
        Rng rng(scene.description.render.seed, static_cast<std::uint64_t>(n), 0);
        std::size_t light = 0;
        const Photon photon = source.launch(rng, light);
        worker.sink.start(photon, scene.lights[light], rng);
        worker.tracer.follow(photon, rng, worker.sink);
        worker.sink.finish(batch);
    }
}

}  // namespace

RenderResult render_from_lights(const Scene& scene, Progress& progress) {
    require_connectable(scene);
    require_an_end(scene, travelling_wavelengths_nm(scene));
    const SceneDescription& description = scene.description;
    const Camera& camera = description.camera;
    RenderResult result{Film(camera.width, camera.height, film_layers(dye_names(scene), description.film.per_dye),
                             static_cast<int>(description.film.channels.size())),
                        {},
                        false};
    Film& film = result.film;
    const PhotonSpace space(scene);
    const PhotonSource source(scene, space);
    const PhotonLimits limits = limits_of(description.render);
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers;
    const std::int64_t photons = std::int64_t{film.pixels()} * description.render.samples;
    FilmSums sums(film);
    progress.start("photons", photons);
    // Batches are traced in any order but added up in theirs, so the sums do not depend on the threads.
    constexpr std::int64_t kBatch = 1000, kRound = 64;
    std::vector<Batch> batches(kRound);
    for (std::int64_t round = 0; round < photons && !progress.stopped(); round += kBatch * kRound) {
        tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, kRound, 1), [&](const auto& range) {
            auto& worker = workers.local();
            if (!worker) worker = std::make_unique<Worker>(scene, space, limits, source.photons_per_s());
            for (std::int64_t b = range.begin(); b < range.end() && !progress.stopped(); ++b) {
                Batch& batch = batches[static_cast<std::size_t>(b)];
                batch.clear();
                const std::int64_t first = std::min(photons, round + b * kBatch);
                const std::int64_t last = std::min(photons, first + kBatch);
                trace_batch(scene, source, first, last, *worker, batch);
                progress.advance(last - first);
            }
        });
        if (progress.stopped()) break;
        for (const Batch& batch : batches)
            sums.add(batch);
    }
    sums.put_on(film, photons);
    for (const auto& worker : workers) {
        result.counts += worker->sink.counts();
        result.counts.real_collisions += worker->tracer.scatterings();
        result.counts.bound_violations += worker->tracer.bound_violations();
    }
    film.add_bound_violations(result.counts.bound_violations);
    result.stopped = progress.stopped();
    return result;
}

}  // namespace fluovox
