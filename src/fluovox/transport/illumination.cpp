#include "fluovox/transport/illumination.h"

#include "fluovox/optics/light_sampling.h"
#include "fluovox/transport/film_response.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace fluovox {
namespace {

// The light's continuous photon spectrum; its knots are dense enough for drawing only.
Spectrum photon_spectrum(const Light& light) {
    const Spectrum& energy = light.spectrum.energy_per_nm;
    if (energy.empty()) return {};
    std::vector<double> photons;
    for (const double nm : energy.wavelengths_nm())
        photons.push_back(continuous_photons_per_nm(light, nm));
    return {energy.wavelengths_nm(), std::move(photons)};
}

// For choosing only: uniform light has no power, so it is taken as what a square millimetre of it sends one way.
double weight_of(const Light& light) {
    return std::holds_alternative<UniformLight>(light.shape) ? 1e6 : 1;
}

// Index drawn in proportion to the weights, or -1 when all are zero.
int pick(const std::vector<double>& weights, double total, double u) {
    double left = u * total;
    int last = -1;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] <= 0) continue;
        last = static_cast<int>(i);
        left -= weights[i];
        if (left < 0) break;
    }
    return last;
}

}  // namespace

Illumination::Illumination(const Scene& scene) : scene_(&scene) {
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const Light& light = scene.lights[l];
        continuous_.push_back(photon_spectrum(light));
        has_continuous_ = has_continuous_ || continuous_.back().integral() > 0;
        for (const LightSpectrum::Line& line : light.spectrum.lines) {
            auto known = std::find_if(lines_.begin(), lines_.end(),
                                      [&](const Line& other) { return other.wavelength_nm == line.wavelength_nm; });
            if (known == lines_.end()) {
                lines_.push_back({line.wavelength_nm, std::vector<double>(scene.lights.size(), 0)});
                known = lines_.end() - 1;
            }
            known->photons[l] += line_photons(light, line);
        }
    }
    of_light_.resize(scene.lights.size());
    for (const Dye& dye : scene.dyes) {
        of_all_.push_back(uptake(dye, std::nullopt));
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            of_light_[l].push_back(uptake(dye, static_cast<int>(l)));
        }
        strength_.push_back(dye.quantum_yield * of_all_.back().total);
    }
    // Dyes that only the glow of others excites must be chosen too, when cascades are wanted; and those that only the
    // glow of these excites, and so on.
    if (scene.description.render.fluorescence_orders.value_or(2) < 2) return;
    const std::vector<double> direct = strength_;
    for (std::size_t round = 1; round < scene.dyes.size() + 1; ++round) {
        const std::vector<double> before = strength_;
        strength_ = direct;
        for (std::size_t i = 0; i < scene.dyes.size(); ++i) {
            for (std::size_t j = 0; j < scene.dyes.size(); ++j) {
                const Dye& absorber = scene.dyes[i];
                const double overlap =
                    integral_of_product(scene.dyes[j].emission_per_nm, absorber.molar_absorption_per_M_cm) /
                    std::max(absorber.molar_absorption_per_M_cm.max(), 1e-300);
                strength_[i] += 0.1 * absorber.quantum_yield * before[j] * overlap;
            }
        }
    }
}

Illumination::Uptake Illumination::uptake(const Dye& dye, std::optional<int> light) const {
    Uptake result;
    for (const Line& line : lines_) {
        double photons = 0;
        for (std::size_t l = 0; l < line.photons.size(); ++l) {
            if (!light || static_cast<std::size_t>(*light) == l)
                photons += line.photons[l] * weight_of(scene_->lights[l]);
        }
        result.by_line.push_back(photons * absorption_per_um_per_uM(dye, line.wavelength_nm));
        result.total += result.by_line.back();
    }
    Spectrum photons;
    for (std::size_t l = 0; l < continuous_.size(); ++l) {
        if (light && static_cast<std::size_t>(*light) != l) continue;
        photons = sum(photons, continuous_[l].scaled(weight_of(scene_->lights[l])));
    }
    const double per_um = absorption_per_um_per_uM(dye, dye.molar_absorption_per_M_cm.peak_nm()) /
                          std::max(dye.molar_absorption_per_M_cm.max(), 1e-300);
    result.continuous = sampling_product(photons, dye.molar_absorption_per_M_cm.scaled(per_um));
    result.total += result.continuous.integral();
    return result;
}

double Illumination::continuous_photons(int light, double wavelength_nm) const {
    return continuous_photons_per_nm(scene_->lights[static_cast<std::size_t>(light)], wavelength_nm);
}

double Illumination::photons(int light, const Excitation& excitation) const {
    if (excitation.line < 0) return continuous_photons(light, excitation.wavelength_nm);
    return lines_[static_cast<std::size_t>(excitation.line)].photons[static_cast<std::size_t>(light)];
}

std::optional<Excitation> Illumination::sample(const std::vector<double>& weights, Rng& rng) const {
    return sample(weights, of_all_, rng);
}

std::optional<Excitation> Illumination::sample(const std::vector<double>& weights, int light, Rng& rng) const {
    return sample(weights, of_light_[static_cast<std::size_t>(light)], rng);
}

std::optional<Excitation> Illumination::sample(const std::vector<double>& weights, const std::vector<Uptake>& uptakes,
                                               Rng& rng) const {
    double total = 0;
    for (std::size_t i = 0; i < weights.size(); ++i)
        total += weights[i] * uptakes[i].total;
    if (!(total > 0)) return std::nullopt;
    double left = rng.uniform() * total;
    std::size_t chosen = weights.size();
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] * uptakes[i].total <= 0) continue;
        chosen = i;
        left -= weights[i] * uptakes[i].total;
        if (left < 0) break;
    }
    const Uptake& dye = uptakes[chosen];
    Excitation excitation;
    double lines = dye.total - dye.continuous.integral();
    if (dye.continuous.empty()) lines = dye.total;
    if (rng.uniform() * dye.total < lines) {
        excitation.line = pick(dye.by_line, lines, rng.uniform());
        if (excitation.line < 0) return std::nullopt;
        excitation.wavelength_nm = lines_[static_cast<std::size_t>(excitation.line)].wavelength_nm;
    } else {
        excitation.wavelength_nm = dye.continuous.sample(rng.uniform());
    }
    // Whichever dye chose it, the probability is that of the mixture.
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const double share = excitation.line >= 0 ? uptakes[i].by_line[static_cast<std::size_t>(excitation.line)]
                                                  : uptakes[i].continuous(excitation.wavelength_nm);
        excitation.probability += weights[i] * share / total;
    }
    if (!(excitation.probability > 0)) return std::nullopt;
    return excitation;
}

std::vector<std::size_t> Illumination::lines_seen_by(const FilmResponse& film) const {
    std::vector<std::size_t> seen;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        if (film.sees(lines_[i].wavelength_nm)) seen.push_back(i);
    }
    return seen;
}

}  // namespace fluovox
