#include "fluovox/transport/light_tracer.h"

#include "fluovox/transport/endless.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/photon_rounds.h"
#include "fluovox/transport/photon_source.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <variant>
#include <vector>

namespace fluovox {
namespace {

/// Sums of the film's values over photons.
class FilmSums {
public:
    explicit FilmSums(const Film& film)
        : values_(film.values_per_sample()),
          layers_(film.layers().size()),
          channels_(values_ / layers_),
          sum_(static_cast<std::size_t>(film.pixels()) * values_),
          squares_(sum_.size()),
          squares_of_all_(static_cast<std::size_t>(film.pixels()) * layers_),
          region_squares_(film.region_values()),
          of_photon_(film.region_values()),
          whole_(film.regions().whole()) {
        for (int pixel = 0; pixel < film.pixels(); ++pixel)
            tiles_.push_back(film.regions().tile_of(static_cast<std::size_t>(pixel)));
    }

    void add(std::span<const Splat> batch) {
        for (std::size_t i = 0; i < batch.size();) {
            double all = 0;
            const std::size_t layer = batch[i].at / channels_;
            do {
                const Splat& splat = batch[i];
                if (splat.begins_photon) end_photon();
                add_to_regions(splat);
                sum_[splat.at] += splat.value;
                squares_[splat.at] += splat.value * splat.value;
                all += splat.value;
                ++i;
            } while (i < batch.size() && !batch[i].begins_layer);
            squares_of_all_[layer] += all * all;
        }
    }
    void put_on(Film& film, std::int64_t photons) {
        end_photon();
        film.add_region_squares(region_squares_);
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
    void add_to_regions(const Splat& splat) {
        const std::size_t layer = splat.at % values_ / channels_;
        for (const std::size_t region : {tiles_[splat.at / values_], whole_}) {
            const std::size_t at = (region * layers_ + layer) * (channels_ + 1);
            for (const std::size_t channel : {splat.at % channels_, channels_}) {
                double& sum = of_photon_[at + channel];
                if (sum == 0) touched_.push_back(at + channel);
                sum += splat.value;
            }
        }
    }
    void end_photon() {
        for (const std::size_t at : touched_) {
            region_squares_[at] += of_photon_[at] * of_photon_[at];
            of_photon_[at] = 0;
        }
        touched_.clear();
    }

    std::size_t values_, layers_, channels_;
    std::vector<double> sum_, squares_, squares_of_all_;
    std::vector<double> region_squares_, of_photon_;  // as Film::add_region_squares
    std::vector<std::size_t> touched_;                // values of `of_photon_` that are not zero
    std::vector<std::size_t> tiles_;                  // of each pixel
    std::size_t whole_;
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
                             "through a refracting surface; use the estimator \"cached\" for what the dyes send out, "
                             "leave refractive_index out, or use fluovox fluence, which "
                             "counts what leaves each face");
        }
    }
    for (const LightDescription& description : scene.description.lights) {
        if (!std::holds_alternative<UniformLight>(description.light.shape)) continue;
        if (film.sees(description.light.spectrum)) {
            throw SceneError(description.where,
                             "the camera sees uniform light directly, which the estimator \"light\" cannot show; block "
                             "its wavelengths (render.filter) or use the estimator \"path\"");
        }
    }
}

}  // namespace

RenderResult render_from_lights(const Scene& scene, Progress& progress) {
    require_connectable(scene);
    require_an_end(scene, travelling_wavelengths_nm(scene));
    const SceneDescription& description = scene.description;
    RenderResult result{empty_film(scene), {}, false};
    Film& film = result.film;
    const PhotonSpace space(scene);
    const PhotonSource source(scene, space);
    PhotonRounds rounds(scene, space, limits_of(description.render), source.photons_per_s());
    const std::int64_t photons = std::int64_t{film.pixels()} * description.render.samples;
    FilmSums sums(film);
    progress.start("photons", photons);
    const auto trace = [&](PhotonRounds::Worker& worker, std::int64_t n) {
        Rng rng(description.render.seed, static_cast<std::uint64_t>(n), 0);
        std::size_t light = 0;
        const Photon photon = source.launch(rng, light);
        worker.sink.start(photon, scene.lights[light], rng);
        worker.tracer.follow(photon, rng, worker.sink);
    };
    rounds.trace(photons, progress, CameraSink::Order::ByPlace, trace,
                 [&](std::span<const Splat> splats) { sums.add(splats); });
    sums.put_on(film, photons);
    result.counts = rounds.counts();
    film.add_bound_violations(result.counts.bound_violations);
    result.stopped = progress.stopped();
    return result;
}

}  // namespace fluovox
