#include "fluovox/transport/collision_path.h"

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/endless.h"
#include "fluovox/transport/roulette.h"
#include "fluovox/volume/region.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <variant>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr double kSphere_sr = 4 * std::numbers::pi;

bool holds(const Bounds& outer, const Bounds& inner) {
    for (int axis = 0; axis < 3; ++axis) {
        if (inner.min[axis] < outer.min[axis] || inner.max[axis] > outer.max[axis]) return false;
    }
    return true;
}

}  // namespace

CollisionPaths::CollisionPaths(const Scene& scene, const Illumination& illumination)
    : scene_(&scene), illumination_(&illumination), field_(scene), sample_(scene) {}

std::span<const double> CollisionPaths::sample(int pixel, std::int64_t sample) {
    sample_.begin(pixel, sample);
    field_.set_optics(Wavelengths::one(sample_.wavelength_nm()), optics_);
    trace(sample_.ray(), sample_.rng());
    return sample_.values();
}

void CollisionPaths::trace(Ray ray, Rng& rng) {
    double weight = 1;
    Lanes likeness;
    while (survives(weight, kFaintPath, rng)) {
        field_.gather(ray, spans_);
        const auto hit = field_.sample_scattering(ray, spans_, optics_, rng, likeness);
        if (!hit) return;
        weight *= field_.transmittance(ray, spans_, hit->t_um, optics_, Loss::Absorption, rng)[0];
        const double scattering = field_.scattering_at(ray, hit->t_um, spans_, optics_, by_medium_, rng)[0];
        if (field_.concentrations(ray, hit->t_um, spans_, concentrations_, rng))
            score(ray, hit->t_um, weight / (scattering * sample_.pdf_per_nm()), rng);
        const PhaseFunction& phase = scene_->media[static_cast<std::size_t>(hit->medium)].phase;
        const double cosine = sample_phase_cosine(phase, rng.uniform());
        ray = {ray.at(hit->t_um), turned(ray.direction, cosine, rng.uniform())};
    }
}

void CollisionPaths::score(const Ray& ray, double t_um, double weight, Rng& rng) {
    weights_.assign(scene_->dyes.size(), 0);
    for (std::size_t m = 0; m < scene_->media.size(); ++m) {
        const int dye = scene_->media[m].dye;
        if (dye < 0) continue;
        weights_[static_cast<std::size_t>(dye)] +=
            concentrations_[m] * scene_->dyes[static_cast<std::size_t>(dye)].quantum_yield;
    }
    const auto excitation = illumination_->sample(weights_, rng);
    if (!excitation) return;
    const double found = weight * fluence(ray.at(t_um), *excitation, rng) / (excitation->probability * kSphere_sr);
    if (!(found > 0)) return;
    for (std::size_t d = 0; d < scene_->dyes.size(); ++d) {
        const Dye& dye = scene_->dyes[d];
        const double absorbed = absorption_per_um_per_uM(dye, excitation->wavelength_nm);
        sample_.add(d, found * weights_[d] * absorbed * dye.emission_per_nm(sample_.wavelength_nm()));
    }
}

// Photons s^-1 um^-2 (or per nm) straight from all lights, and from one even direction over the sphere.
double CollisionPaths::fluence(Vec3 position, const Excitation& excitation, Rng& rng) {
    field_.set_optics(Wavelengths::one(excitation.wavelength_nm), exciting_);
    double total = 0;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const auto light = sample_light(scene_->lights[l], position, rng.uniform(), rng.uniform());
        if (light) total += straight(position, l, excitation, *light, rng);
    }
    double weight = kSphere_sr;
    Ray ray{position, sample_isotropic(rng)};
    Lanes likeness;
    while (survives(weight, kFaintPath, rng)) {
        field_.gather(ray, spans_);
        const auto hit = field_.sample_scattering(ray, spans_, exciting_, rng, likeness);
        if (!hit) {
            for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
                if (!std::holds_alternative<UniformLight>(scene_->lights[l].shape)) continue;
                total += weight * illumination_->photons(static_cast<int>(l), excitation) *
                         field_.transmittance(ray, spans_, kFar, exciting_, Loss::Absorption, rng)[0];
            }
            break;
        }
        weight *= field_.transmittance(ray, spans_, hit->t_um, exciting_, Loss::Absorption, rng)[0];
        const PhaseFunction& phase = scene_->media[static_cast<std::size_t>(hit->medium)].phase;
        const Vec3 here = ray.at(hit->t_um);
        for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
            const auto light = sample_light(scene_->lights[l], here, rng.uniform(), rng.uniform());
            if (!light) continue;
            total += weight * phase_per_sr(phase, dot(light->to_light, ray.direction)) *
                     straight(here, l, excitation, *light, rng);
        }
        const double cosine = sample_phase_cosine(phase, rng.uniform());
        ray = {here, turned(ray.direction, cosine, rng.uniform())};
    }
    return total;
}

double CollisionPaths::straight(Vec3 position, std::size_t light, const Excitation& excitation,
                                const LightSample& sample, Rng& rng) {
    const double photons = illumination_->photons(static_cast<int>(light), excitation);
    if (photons <= 0) return 0;
    const Ray shadow{position, sample.to_light};
    field_.gather(shadow, shadow_spans_);
    return photons * sample.fluence_per_um2 *
           field_.transmittance(shadow, shadow_spans_, sample.distance_um, exciting_, Loss::Extinction, rng)[0];
}

void require_samplable_by_collisions(const Scene& scene) {
    const RenderDescription& render = scene.description.render;
    const auto require = [&](bool fits, const std::string& what) {
        if (fits) return;
        throw SceneError(render.where, fmt::format("the estimator \"collision\" is only for comparison and {}; use "
                                                   "\"path\", or \"auto\"",
                                                   what));
    };
    const FilmResponse film(scene.description.film, render.filter);
    for (const Light& light : scene.lights) {
        require(!is_pencil(light), "cannot find light without width");
        require(!film.sees(light.spectrum), "does not show light that was not converted, which this film would see");
    }
    require(!render.max_scatterings, "does not count scatterings");
    require(render.fluorescence_orders.value_or(1) == 1, "knows no cascades");
    for (const SceneMedium& medium : scene.media) {
        require(!medium.refractive_index, "does not know refracting surfaces");
        require(!medium.grid || is_zero(medium.scattering), "needs hosts that scatter alike everywhere");
        if (medium.dye < 0) continue;
        const Bounds dye = medium.grid ? medium.grid->bounds() : bounds_of(medium.region);
        require(std::any_of(scene.media.begin(), scene.media.end(),
                            [&](const SceneMedium& host) {
                                return host.dye < 0 && !host.grid && !is_zero(host.scattering) &&
                                       holds(bounds_of(host.region), dye);
                            }),
                "finds dye only where a host scatters, which leaves some of " + medium.name + " out");
    }
    require_an_end(scene, travelling_wavelengths_nm(scene));
}

}  // namespace fluovox
