// Conversion of excitation into emission, as the backward estimator meets it: at a point of a ray where dye glows, the
// path goes on at a wavelength that excites the dye.

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/path_tracer.h"

#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

constexpr double kSphere_sr = 4 * std::numbers::pi;

}  // namespace

void PathTracer::convert(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result) {
    if (level(depth).sources.total() <= 0) return;
    convert_where_lit(path, task, depth, rng, result);
    convert_at_source(path, task, depth, rng, result);
}

// Concentrations at a point, and for each dye concentration x yield. False when nothing glows there.
bool PathTracer::find_dye(const Stretch& path, double t_um, Level& level, Rng& rng) {
    if (!field_.concentrations(path.ray, t_um, level.spans, level.uM, rng)) return false;
    level.weights.assign(scene_->dyes.size(), 0);
    for (std::size_t i = 0; i < scene_->media.size(); ++i) {
        const int dye = scene_->media[i].dye;
        if (dye < 0) continue;
        const auto d = static_cast<std::size_t>(dye);
        level.weights[d] += level.uM[i] * scene_->dyes[d].quantum_yield;
    }
    return true;
}

const PathOptics& PathTracer::excitation_optics(const Excitation& excitation, Level& level) const {
    if (excitation.line >= 0) return line_optics_[static_cast<std::size_t>(excitation.line)];
    field_.set_optics(Wavelengths::one(excitation.wavelength_nm), level.optics);
    return level.optics;
}

// Photons s^-1 um^-2 (or per nm) that reach a point straight from a light.
double PathTracer::direct_fluence(Vec3 position, std::size_t light, const Excitation& excitation,
                                  const PathOptics& optics, Level& level, Rng& rng) {
    const double photons = illumination_->photons(static_cast<int>(light), excitation);
    if (photons <= 0) return 0;
    const auto sample = sample_light(scene_->lights[light], position, rng.uniform(), rng.uniform());
    if (!sample) return 0;
    double fluence = photons * sample->fluence_per_um2;
    if (sample->pdf_per_sr > 0) {  // a ray of the path may run into the same light
        fluence *= sample->pdf_per_sr / (sample->pdf_per_sr + direction_pdf(lobes_, sample->to_light));
    }
    return fluence * transmittance_to_light(position, *sample, optics, level, rng)[0];
}

// What each dye makes of a fluence at one wavelength: emission x yield x absorption x fluence over the sphere.
void PathTracer::add_glow(const Lanes& weight, double wavelength_nm, double fluence, const Level& level,
                          PathRadiance& result) {
    for (std::size_t d = 0; d < scene_->dyes.size(); ++d) {
        if (level.weights[d] <= 0) continue;
        const double converted =
            level.weights[d] * absorption_per_um_per_uM(scene_->dyes[d], wavelength_nm) * fluence / kSphere_sr;
        if (converted > 0) result.by_dye[d] += converted * (weight * level.emission[d]);
    }
}

void PathTracer::convert_where_lit(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng,
                                   PathRadiance& result) {
    Level& here = level(depth);
    const auto light = choose_lit_section(here, rng);
    if (!light) return;
    const double t = here.lit[*light].sample(rng.uniform());
    const double own = lit_pdf(here, *light, t);
    if (!(own > 0) || !find_dye(path, t, here, rng)) return;
    const auto excitation = illumination_->sample(here.weights, static_cast<int>(*light), rng);
    if (!excitation) return;
    const PathOptics& optics = excitation_optics(*excitation, here);
    const double fluence = direct_fluence(path.ray.at(t), *light, *excitation, optics, here, rng);
    if (fluence <= 0) return;
    const Lanes seen = field_.transmittance(path.ray, here.spans, t, *task.optics, Loss::Extinction, rng) * path.beta;
    const double density = (own + here.sources.pdf(t)) * excitation->probability;
    add_glow((1 / density) * seen, excitation->wavelength_nm, fluence, here, result);
    ++field_.counts().real_collisions;
}

// A point of the stretch where dye glows, drawn by how much.
std::optional<PathTracer::GlowPoint> PathTracer::sample_source(const Stretch& path, const PathTask& task, Level& level,
                                                               Rng& rng) {
    const double t = level.sources.sample(rng.uniform());
    const double own = level.sources.pdf(t);
    if (!(own > 0) || !find_dye(path, t, level, rng)) return std::nullopt;
    const Lanes seen = field_.transmittance(path.ray, level.spans, t, *task.optics, Loss::Extinction, rng) * path.beta;
    return GlowPoint{t, own, (1 / own) * seen};
}

void PathTracer::convert_at_source(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng,
                                   PathRadiance& result) {
    const auto point = sample_source(path, task, level(depth), rng);
    if (!point) return;
    ++field_.counts().real_collisions;
    if (point->weight.max() > 0) excite_by_lights(path, *point, depth, rng, result);
}

// Conversion of light that was converted before.
void PathTracer::convert_again(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng,
                               PathRadiance& result) {
    const auto point = sample_source(path, task, level(depth), rng);
    if (point && point->weight.max() > 0) excite_by_dyes(path, *point, task, depth, rng, result);
}

void PathTracer::excite_by_lights(const Stretch& path, const GlowPoint& point, std::size_t depth, Rng& rng,
                                  PathRadiance& result) {
    Level& here = level(depth);
    const auto excitation = illumination_->sample(here.weights, rng);
    if (!excitation) return;
    const PathOptics& optics = excitation_optics(*excitation, here);
    const Vec3 position = path.ray.at(point.t_um);
    const double own = point.density;
    double fluence = 0;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const double share = own / (own + lit_pdf(here, l, point.t_um));  // the rest is convert_where_lit's
        fluence += share * direct_fluence(position, l, *excitation, optics, here, rng);
    }
    if (path.scatterings > 0 || has_far_lights_) {
        PathTask& onward = here.task;
        onward.optics = &optics;
        onward.light_photons.assign(scene_->lights.size(), Lanes(1));
        for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
            onward.light_photons[l][0] = illumination_->photons(static_cast<int>(l), *excitation);
        }
        onward.orders = 0;
        onward.scatterings = path.scatterings;
        const Vec3 direction = sample_direction(lobes_, rng);
        onward.pdf_start_per_sr = direction_pdf(lobes_, direction);
        here.radiance.elastic = Lanes(1);
        here.radiance.by_dye.clear();
        trace({position, direction}, onward, depth + 1, rng, here.radiance);
        fluence += here.radiance.elastic[0] / onward.pdf_start_per_sr;
    }
    add_glow((1 / excitation->probability) * point.weight, excitation->wavelength_nm, fluence, here, result);
}

// A wavelength in proportion to what the dyes here, by their weights, would take of each other's light.
Excitation PathTracer::excitation_by_dyes(const std::vector<double>& weights, Rng& rng) const {
    const std::size_t dyes = scene_->dyes.size();
    Excitation excitation;
    double total = 0;
    for (std::size_t a = 0; a < dyes; ++a) {
        for (const Spectrum& overlap : dye_to_dye_[a])
            total += weights[a] * overlap.integral();
    }
    if (!(total > 0)) return excitation;
    double left = rng.uniform() * total;
    const Spectrum* chosen = nullptr;
    for (std::size_t a = 0; a < dyes && left >= 0; ++a) {
        for (const Spectrum& overlap : dye_to_dye_[a]) {
            if (weights[a] * overlap.integral() <= 0) continue;
            chosen = &overlap;
            left -= weights[a] * overlap.integral();
            if (left < 0) break;
        }
    }
    excitation.wavelength_nm = chosen->sample(rng.uniform());
    for (std::size_t a = 0; a < dyes; ++a) {
        for (const Spectrum& overlap : dye_to_dye_[a])
            excitation.probability += weights[a] * overlap(excitation.wavelength_nm) / total;
    }
    return excitation;
}

// Light that another conversion made: a wavelength that some dye emits and one of those here absorbs.
void PathTracer::excite_by_dyes(const Stretch& path, const GlowPoint& point, const PathTask& task, std::size_t depth,
                                Rng& rng, PathRadiance& result) {
    // A cascade without end goes on by roulette.
    constexpr double kGoOn = 0.7;
    double roulette = 1;
    if (task.orders == PathTask::kNoLimit) {
        if (rng.uniform() >= kGoOn) return;
        roulette = 1 / kGoOn;
    }
    Level& here = level(depth);
    const Excitation excitation = excitation_by_dyes(here.weights, rng);
    if (!(excitation.probability > 0)) return;
    PathTask& onward = here.task;
    onward.optics = &excitation_optics(excitation, here);
    onward.light_photons.clear();
    onward.orders = task.orders == PathTask::kNoLimit ? PathTask::kNoLimit : task.orders - 1;
    onward.scatterings = path.scatterings;
    onward.pdf_start_per_sr = 0;
    here.radiance.elastic = Lanes(1);
    here.radiance.by_dye.assign(scene_->dyes.size(), Lanes(1));
    const Vec3 direction = sample_isotropic(rng);
    trace({path.ray.at(point.t_um), direction}, onward, depth + 1, rng, here.radiance);
    const double fluence = kSphere_sr * here.radiance.converted()[0];
    add_glow((roulette / excitation.probability) * point.weight, excitation.wavelength_nm, fluence, here, result);
}

}  // namespace fluovox
