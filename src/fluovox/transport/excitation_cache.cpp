#include "fluovox/transport/excitation_cache.h"

#include "fluovox/optics/light_emission.h"
#include "fluovox/optics/light_sampling.h"
#include "fluovox/transport/deaf_sink.h"
#include "fluovox/transport/endless.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/photon_tracer.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <variant>

namespace fluovox {
namespace {

/// Puts what photons could excite into the voxels of every lattice.
class CacheSink : public DeafSink {
public:
    CacheSink(const Scene& scene, const std::vector<std::vector<int>>& media, std::vector<VoxelTally>& tallies,
              const std::vector<bool>& direct, bool refracts)
        : scene_(&scene),
          media_(&media),
          tallies_(&tallies),
          direct_(&direct),
          refracts_(refracts),
          shares_(media.size()) {}

    void launched(const Photon& photon, std::size_t light, Rng voxel_rng) {
        left_out_ = (*direct_)[light] && !refracts_;
        voxel_rng_ = voxel_rng;
        set_wavelength(photon.wavelength_nm);
    }
    void emission(const Photon& photon) { set_wavelength(photon.wavelength_nm); }
    bool surveys(const Photon& photon) const { return photon.order > 0 || photon.scatterings > 0 || !left_out_; }
    void survey(const Photon& /*photon*/, const Flight& flight, double extinction) {
        for (std::size_t l = 0; l < tallies_->size(); ++l) {
            if (shares_[l].empty()) continue;
            const std::vector<int>& media = (*media_)[l];
            const auto uM = [&](const VoxelTally::Share& share, Vec3 place) {
                const auto medium = static_cast<std::size_t>(media[static_cast<std::size_t>(share.field)]);
                return tapped_dye_uM(*scene_, medium, place, voxel_rng_);
            };
            (*tallies_)[l].add_flight({flight.ray, flight.length_um, flight.weight, extinction}, shares_[l], uM,
                                      voxel_rng_);
        }
    }

private:
    void set_wavelength(double nm) {
        if (nm == nm_) return;
        nm_ = nm;
        for (std::size_t l = 0; l < shares_.size(); ++l) {
            shares_[l].clear();
            const std::vector<int>& media = (*media_)[l];
            for (std::size_t f = 0; f < media.size(); ++f) {
                const int dye = scene_->media[static_cast<std::size_t>(media[f])].dye;
                const double absorption = absorption_per_um_per_uM(scene_->dyes[static_cast<std::size_t>(dye)], nm);
                if (absorption > 0) shares_[l].push_back({static_cast<int>(f), absorption});
            }
        }
    }

    const Scene* scene_;
    const std::vector<std::vector<int>>* media_;
    std::vector<VoxelTally>* tallies_;
    const std::vector<bool>* direct_;
    bool refracts_;
    bool left_out_ = false;
    double nm_ = 0;
    Rng voxel_rng_{0, 0, 0};
    std::vector<std::vector<VoxelTally::Share>> shares_;  // per lattice
};

std::vector<bool> direct_lights(const Scene& scene, const PhotonSpace& space) {
    std::vector<bool> direct;
    for (const Light& light : scene.lights) {
        direct.push_back(!is_pencil(light) && !std::holds_alternative<UniformLight>(light.shape) && !space.refracts());
    }
    return direct;
}

PhotonLimits limits_of(const RenderDescription& render, const std::vector<bool>& direct) {
    PhotonLimits limits;
    limits.minor_conversions = true;
    // The last conversion is the one that the camera sees.
    const int orders = render.fluorescence_orders.value_or(std::numeric_limits<int>::max());
    limits.orders = std::max(0, orders - 1);
    if (!render.max_scatterings) return limits;
    const bool all_direct = std::find(direct.begin(), direct.end(), false) == direct.end();
    if (*render.max_scatterings > (all_direct ? 1 : 0)) {
        throw SceneError(
            render.where,
            fmt::format("the estimator \"cached\" does not know how often light was scattered before it "
                        "excites, so max_scatterings = {} cannot be kept; give {}0 or no limit, or use the "
                        "estimator \"path\"",
                        *render.max_scatterings, all_direct ? "1, " : ""));
    }
    limits.scatterings = *render.max_scatterings;
    limits.scatterings_are_physical = true;
    return limits;
}

// About what the camera gets of a photon of each light by way of the dyes.
std::vector<double> worth_per_photon(const Scene& scene) {
    constexpr int kWavelengths = 64;
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    std::vector<double> seen;
    for (const Dye& dye : scene.dyes)
        seen.push_back(dye.quantum_yield * film.seen_part(dye.emission_per_nm).integral());
    std::vector<double> worth;
    for (const Light& light : scene.lights) {
        Rng rng(scene.description.render.seed, 0, 0);
        double& sum = worth.emplace_back(0);
        for (int i = 0; i < kWavelengths; ++i) {
            const double nm = sample_emitted_wavelength(light, rng);
            for (std::size_t d = 0; d < scene.dyes.size(); ++d)
                sum += seen[d] * absorption_per_um_per_uM(scene.dyes[d], nm);
        }
    }
    return worth;
}

VoxelLattice lattice_of_region(const Scene& scene, std::size_t medium) {
    const Bounds box = bounds_of(scene.media[medium].region);
    const RenderDescription& render = scene.description.render;
    const Vec3 size = box.size();
    const double longest = std::max({size.x, size.y, size.z});
    if (!std::isfinite(longest)) {
        throw SceneError(render.where,
                         fmt::format("the estimator \"cached\" needs a finite region for the dye of {}; give it one, "
                                     "or use the estimator \"path\"",
                                     scene.media[medium].name));
    }
    const double voxel = render.cache_voxel_um.value_or(longest * ExcitationCache::kDefaultVoxelShare);
    constexpr double kMostVoxels = 5e8;
    if (size.x * size.y * size.z / (voxel * voxel * voxel) > kMostVoxels) {
        throw SceneError(render.where,
                         fmt::format("render.cache_voxel = {:g} um makes more than 500 million voxels of the region of "
                                     "{}; make it larger",
                                     voxel, scene.media[medium].name));
    }
    return VoxelLattice::filling(box, voxel);
}

}  // namespace

ExcitationCache::ExcitationCache(const Scene& scene)
    : scene_(&scene),
      space_(scene),
      source_(scene, space_),
      direct_(direct_lights(scene, space_)),
      limits_(limits_of(scene.description.render, direct_)) {
    require_an_end(scene, travelling_wavelengths_nm(scene));
    source_.favour(worth_per_photon(scene));
    places_.resize(scene.media.size());
    for (std::size_t m = 0; m < scene.media.size(); ++m) {
        const SceneMedium& medium = scene.media[m];
        if (medium.dye < 0) continue;
        if (medium.grid && medium.grid->background() > 0) {
            throw SceneError(scene.description.render.where,
                             fmt::format("the grid of {} goes on for ever (its background is not zero), and the "
                                         "estimator \"cached\" needs finite dyes; use the estimator \"path\"",
                                         medium.name));
        }
        add_place(m, medium.grid ? VoxelLattice::with_values(*medium.grid) : lattice_of_region(scene, m));
    }
}

void ExcitationCache::add_place(std::size_t medium, VoxelLattice lattice) {
    const auto known = std::find(lattices_.begin(), lattices_.end(), lattice);
    const auto l = static_cast<std::size_t>(known - lattices_.begin());
    if (known == lattices_.end()) {
        lattices_.push_back(std::move(lattice));
        media_.emplace_back();
    }
    places_[medium] = {static_cast<int>(l), static_cast<int>(media_[l].size())};
    media_[l].push_back(static_cast<int>(medium));
}

void ExcitationCache::fill(std::int64_t photons, std::uint64_t batch, Progress& progress) {
    if (photons != photons_) {
        photons_ = photons;
        tallies_.clear();
        scale_.assign(lattices_.size(), source_.photons_per_s() / static_cast<double>(photons));
        for (std::size_t l = 0; l < lattices_.size(); ++l)
            tallies_.emplace_back(lattices_[l], static_cast<int>(media_[l].size()), static_cast<double>(photons));
    } else {
        for (VoxelTally& tally : tallies_)
            tally.clear();
    }
    struct Worker {
        PhotonTracer<CacheSink> tracer;
        CacheSink sink;
    };
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers;
    constexpr std::int64_t kGrain = 500;
    tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, photons, kGrain), [&](const auto& range) {
        auto& worker = workers.local();
        if (!worker) {
            worker = std::make_unique<Worker>(Worker{PhotonTracer<CacheSink>(*scene_, space_, limits_),
                                                     CacheSink(*scene_, media_, tallies_, direct_, space_.refracts())});
        }
        for (std::int64_t n = range.begin(); n < range.end() && !progress.stopped(); ++n) {
            const std::uint64_t seed = scene_->description.render.seed;
            // Streams of their own: no pixel of the gather has these keys.
            Rng rng(~seed, batch, static_cast<std::uint64_t>(n));
            std::size_t light = 0;
            const Photon photon = source_.launch(rng, light);
            worker->sink.launched(photon, light, Rng(~seed, ~batch, static_cast<std::uint64_t>(n)));
            worker->tracer.follow(photon, rng, worker->sink);
        }
        progress.advance(range.end() - range.begin());
    });
    for (const auto& worker : workers)
        bound_violations_ += worker->tracer.bound_violations();
}

double ExcitationCache::absorbed_per_s(std::size_t medium, std::size_t brick, int in_brick) const {
    const Place place = places_[medium];
    const auto l = static_cast<std::size_t>(place.lattice);
    return scale_[l] * tallies_[l].at(brick, in_brick, place.field);
}

double ExcitationCache::absorbed_along(std::size_t medium, const Ray& ray, double length_um, double weight,
                                       double absorption) const {
    const Place place = places_[medium];
    const VoxelTally& tally = tallies_[static_cast<std::size_t>(place.lattice)];
    double sum = 0;
    tally.for_each_voxel(ray, length_um, [&](std::size_t brick, int in_brick, Interval stretch) {
        const double absorbed = tally.at(brick, in_brick, place.field);
        if (!(absorbed > 0)) return;
        const double middle = 0.5 * (stretch.begin + stretch.end);
        sum += absorbed * stretch.length() * std::exp(-absorption * middle);
    });
    return weight * scale_[static_cast<std::size_t>(place.lattice)] * sum / tally.voxel_volume_um3();
}

double dye_uM(const Scene& scene, std::size_t medium, Vec3 position_um) {
    const SceneMedium& dye = scene.media[medium];
    if (dye.grid) return dye.amount * dye.grid->trilinear(position_um);
    if (!contains(dye.region, position_um)) return 0;
    const bool cut = std::any_of(dye.cut_by.begin(), dye.cut_by.end(), [&](int inner) {
        return contains(scene.media[static_cast<std::size_t>(inner)].region, position_um);
    });
    return cut ? 0 : dye.amount;
}

double tapped_dye_uM(const Scene& scene, std::size_t medium, Vec3 position_um, Rng& rng) {
    const SceneMedium& dye = scene.media[medium];
    if (!dye.grid) return dye_uM(scene, medium, position_um);
    const Vec3 index = dye.grid->index_from_world().point(position_um);
    return dye.amount * static_cast<double>(dye.grid->tap(index, rng.bits()));
}

std::size_t ExcitationCache::bytes() const {
    std::size_t total = 0;
    for (std::size_t l = 0; l < lattices_.size(); ++l)
        total += static_cast<std::size_t>(VoxelTally::bytes(lattices_[l], static_cast<int>(media_[l].size())));
    return total;
}

}  // namespace fluovox
