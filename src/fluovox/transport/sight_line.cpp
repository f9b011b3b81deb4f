#include "fluovox/transport/sight_line.h"

#include "fluovox/optics/light_sampling.h"
#include "fluovox/volume/majorant_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {

SightLine::SightLine(const Scene& scene, const Illumination& illumination, const ExcitationCache& cache)
    : scene_(&scene), illumination_(&illumination), cache_(&cache) {}

// Photons absorbed per second, um^3 and umol/L, before what lies between the lights and here takes its part.
double SightLine::excitation(std::size_t medium, Vec3 position_um) const {
    double rate = cache_->rate_per_uM(medium, position_um);
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        if (!cache_->leaves_out_direct(l)) continue;
        const double uptake = illumination_->uptake(static_cast<int>(l), scene_->media[medium].dye);
        if (uptake <= 0) continue;
        const auto light = sample_light(scene_->lights[l], position_um, 0.5, 0.5);
        if (light) rate += uptake * light->fluence_per_um2;
    }
    return rate;
}

void SightLine::build(OpticalField& field, const std::vector<double>& brightness, const Ray& ray,
                      const std::vector<MediumSpan>& spans, const PathOptics& optics, Rng& rng) {
    places_.clear();
    total_ = 0;
    constexpr double kDarkest = 30;  // beyond it nothing is seen, but all must stay possible
    for (std::size_t m = 0; m < scene_->media.size(); ++m) {
        const SceneMedium& medium = scene_->media[m];
        if (medium.dye < 0 || !medium.grid) continue;
        const double bright = brightness[static_cast<std::size_t>(medium.dye)] * medium.amount;
        if (bright <= 0) continue;
        const double voxels_per_um = length(medium.grid->index_from_world().direction(ray.direction));
        MajorantWalk walk(*medium.grid, ray, {0, std::numeric_limits<double>::infinity()});
        for (MajorantWalk::Segment segment; walk.next(segment) && std::isfinite(segment.end);) {
            const double steps = std::ceil((segment.end - segment.begin) * voxels_per_um);
            const double step = (segment.end - segment.begin) / steps;
            for (int i = 0; i < static_cast<int>(steps); ++i) {
                const double t = segment.begin + (i + rng.uniform()) * step;
                const double value = field.tap(*medium.grid, walk.index_at(t), segment.bound, rng);
                if (value <= 0) continue;
                const double depth = std::min(kDarkest, hero_depth(spans, optics, t));
                const double likely = bright * value * step * excitation(m, ray.at(t)) * std::exp(-depth);
                if (!(likely > 0)) continue;
                total_ += likely;
                places_.push_back({t, step, value * medium.amount, likely, m});
            }
        }
    }
}

const SightLine::Place& SightLine::choose(double u) const {
    double left = u * total_;
    for (const Place& place : places_) {
        left -= place.likely;
        if (left < 0) return place;
    }
    return places_.back();
}

}  // namespace fluovox
