#include "fluovox/transport/line_tracer.h"

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/path_tracer.h"
#include "fluovox/volume/region.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

const PathOptics::MediumLanes& lanes_of(const PathOptics& optics, int medium) {
    return optics.media[static_cast<std::size_t>(medium)];
}

double length_before(const Interval& span, double end_um) {
    return std::max(0.0, std::min(span.end, end_um) - span.begin);
}

// Absorption is a factor at collisions, where little is lost by it.
bool is_folded(const PathOptics::MediumLanes& lanes) {
    return lanes.scattering[0] > 0.5 * lanes.extinction[0];
}

// True where the light has the same strength and a single direction all over the box.
bool covers(const Light& light, const Bounds& box) {
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                     (corner & 4) != 0 ? box.max.z : box.min.z};
        if (const auto* sheet = std::get_if<SheetLight>(&light.shape)) {
            const Vec3 from_waist = p - sheet->waist;
            if (sheet->profile != BeamProfile::Box || dot(p - sheet->position, sheet->direction) < 0 ||
                std::abs(dot(from_waist, sheet->normal)) > 0.5 * sheet->thickness_um ||
                std::abs(dot(from_waist, cross(sheet->direction, sheet->normal))) > 0.5 * sheet->width_um)
                return false;
        } else if (const auto* beam = std::get_if<BeamLight>(&light.shape)) {
            const Vec3 from_waist = p - beam->waist;
            const Vec3 across = from_waist - dot(from_waist, beam->direction) * beam->direction;
            if (beam->profile != BeamProfile::Box || dot(p - beam->position, beam->direction) < 0 ||
                length_squared(across) > beam->radius_um * beam->radius_um)
                return false;
        } else {
            return false;
        }
    }
    return true;
}

}  // namespace

LineTracer::LineTracer(const Scene& scene, OpticalField& field) : scene_(&scene), field_(&field) {
    Bounds box;
    for (const SceneMedium& medium : scene.media) {
        box.add(medium.grid ? medium.grid->bounds() : bounds_of(medium.region));
        if (medium.grid && medium.grid->background() > 0) box.add(Vec3{kFar, kFar, kFar});
    }
    size_um_ = length(box.size());
    for (const Light& light : scene.lights) {
        has_rectangles_ = has_rectangles_ || std::holds_alternative<RectangleLight>(light.shape);
        has_surround_ = has_surround_ || std::holds_alternative<UniformLight>(light.shape);
        broad_.push_back(std::isfinite(size_um_) && !box.empty() && covers(light, box) ? 1 : 0);
    }
}

// True where light is likely to be scattered on its way through all of the scene, at its densest.
bool LineTracer::is_thick(const PathOptics& optics) const {
    double most = 0;
    for (std::size_t i = 0; i < scene_->media.size(); ++i) {
        const auto& grid = scene_->media[i].grid;
        most += optics.media[i].scattering[0] * (grid ? grid->max() : 1);
    }
    constexpr double kThick = 2;
    return most * size_um_ > kThick;
}

bool LineTracer::find_lit_sections(const Ray& ray, const PathTask& task, bool thick) {
    sections_ = 0;
    const auto is_sought = [&](std::size_t light) {
        return task.light_photons[light][0] > 0 && !(thick && broad_[light] != 0);
    };
    const std::size_t lights = scene_->lights.size();
    bool any = false;
    for (std::size_t l = 0; l < lights; ++l)
        any = any || is_sought(l);
    if (!any) return false;
    lit_.clear();
    const Interval reach = field_->reach(ray, spans_);
    for (std::size_t l = 0; l < lights; ++l) {
        lit_.emplace_back(scene_->lights[l], ray, is_sought(l) ? reach : Interval{0, 0});
        sections_ += lit_.back() ? 1 : 0;
    }
    return sections_ > 0;
}

double LineTracer::lit_pdf(std::size_t light, double t_um) const {
    return sections_ > 0 && lit_[light] ? lit_[light].pdf(t_um) / static_cast<double>(sections_) : 0;
}

LineTracer::Flight LineTracer::fly(const Ray& ray, const PathOptics& optics, Rng& rng) {
    Flight flight{kFar, -1, 1};
    for (const MediumSpan& s : spans_) {
        const double coefficient = lanes_of(optics, s.medium).scattering[0];
        if (coefficient <= 0) continue;
        const double t = s.span.begin + rng.exponential() / coefficient;
        if (t < s.span.end && t < flight.t_um) flight = {t, s.medium, 1};
    }
    for (const int i : field_->gridded()) {
        const PathOptics::MediumLanes& lanes = lanes_of(optics, i);
        if (lanes.scattering[0] <= 0) continue;
        const bool folded = is_folded(lanes);
        const double coefficient = folded ? lanes.extinction[0] : lanes.scattering[0];
        const double t = field_->first_collision(i, ray, flight.t_um, coefficient, rng);
        if (t < flight.t_um) flight = {t, i, folded ? lanes.scattering[0] / lanes.extinction[0] : 1};
    }
    if (flight.medium >= 0) {
        ++field_->counts().real_collisions;
        flight.left *= absorption_left(ray, flight.t_um, optics, rng);
    }
    return flight;
}

// Of absorption alone; without that of grids where it is a factor at collisions.
double LineTracer::absorption_left(const Ray& ray, double end_um, const PathOptics& optics, Rng& rng) {
    double depth = 0;
    for (const MediumSpan& s : spans_) {
        const double coefficient = lanes_of(optics, s.medium).absorption[0];
        if (coefficient > 0) depth += coefficient * length_before(s.span, end_um);
    }
    double left = depth > 0 ? std::exp(-depth) : 1;
    for (const int i : field_->gridded()) {
        const PathOptics::MediumLanes& lanes = lanes_of(optics, i);
        if (lanes.absorption[0] <= 0 || is_folded(lanes) || left == 0) continue;
        left *= field_->ratio_transmittance(i, ray, end_um, lanes.absorption[0], rng);
    }
    return left;
}

double LineTracer::transmittance(const Ray& ray, const std::vector<MediumSpan>& spans, double end_um,
                                 const PathOptics& optics, Rng& rng) {
    double depth = 0;
    for (const MediumSpan& s : spans) {
        const double coefficient = lanes_of(optics, s.medium).extinction[0];
        if (coefficient > 0) depth += coefficient * length_before(s.span, end_um);
    }
    double left = depth > 0 ? std::exp(-depth) : 1;
    for (const int i : field_->gridded()) {
        const double coefficient = lanes_of(optics, i).extinction[0];
        if (coefficient > 0 && left > 0) left *= field_->ratio_transmittance(i, ray, end_um, coefficient, rng);
    }
    return left;
}

double LineTracer::shadow(Vec3 position, const LightSample& light, const PathOptics& optics, Rng& rng) {
    const Ray ray{position, light.to_light};
    field_->gather(ray, shadow_spans_);
    return transmittance(ray, shadow_spans_, light.distance_um, optics, rng);
}

// As OpticalField::scattering_density.
double LineTracer::scattering_density(const Ray& ray, double t_um, const PathOptics& optics) const {
    double coefficient = 0;
    double depth = 0;
    for (const MediumSpan& s : spans_) {
        const double own = lanes_of(optics, s.medium).scattering[0];
        if (own <= 0) continue;
        if (t_um >= s.span.begin && t_um <= s.span.end) coefficient += own;
        depth += own * length_before(s.span, t_um);
    }
    for (const int i : field_->gridded()) {
        const double own = lanes_of(optics, i).scattering[0];
        if (own > 0) coefficient += own * scene_->media[static_cast<std::size_t>(i)].grid->trilinear(ray.at(t_um));
    }
    return coefficient * std::exp(-depth);
}

// Rectangles that the ray hits; they are also found by sampling them from its origin, unless that is the camera.
double LineTracer::from_rectangles(const Path& path, const PathTask& task, Rng& rng) {
    double total = 0;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const auto* rectangle = std::get_if<RectangleLight>(&scene_->lights[l].shape);
        const double photons = task.light_photons[l][0];
        if (rectangle == nullptr || photons <= 0) continue;
        const auto t = hit_rectangle(*rectangle, path.ray);
        if (!t) continue;
        const double other = path.pdf_per_sr > 0 ? rectangle_pdf(*rectangle, path.ray.direction, *t) : 0;
        const double weight = path.pdf_per_sr > 0 ? path.pdf_per_sr / (path.pdf_per_sr + other) : 1;
        total +=
            weight * rectangle_radiance(*rectangle) * photons * transmittance(path.ray, spans_, *t, *task.optics, rng);
    }
    return total;
}

// Uniform light where the path leaves.
double LineTracer::from_surround(const Path& path, const PathTask& task, Rng& rng) {
    double photons = 0;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        if (std::holds_alternative<UniformLight>(scene_->lights[l].shape)) photons += task.light_photons[l][0];
    }
    return photons > 0 ? photons * absorption_left(path.ray, kFar, *task.optics, rng) : 0;
}

// Light scattered at a point drawn where it shines on the ray.
double LineTracer::scattered_once(const Path& path, const PathTask& task, Rng& rng) {
    const PathOptics& optics = *task.optics;
    auto left = static_cast<std::ptrdiff_t>(rng.uniform() * static_cast<double>(sections_));
    std::size_t chosen = 0;
    for (std::size_t i = 0; i < lit_.size(); ++i) {
        if (lit_[i] && left-- == 0) chosen = i;
    }
    const double t = lit_[chosen].sample(rng.uniform());
    const double own = lit_pdf(chosen, t);
    const Vec3 position = path.ray.at(t);
    const double u1 = rng.uniform();
    const auto light = sample_light(scene_->lights[chosen], position, u1, rng.uniform());
    if (!light || !(own > 0)) return 0;
    field_->scattering_at(path.ray, t, spans_, optics, by_medium_, rng);
    const double cosine = dot(light->to_light, path.ray.direction);
    double scattered = 0;
    for (std::size_t i = 0; i < by_medium_.size(); ++i) {
        if (by_medium_[i][0] > 0) scattered += phase_per_sr(scene_->media[i].phase, cosine) * by_medium_[i][0];
    }
    if (scattered <= 0) return 0;
    const double other = scattering_density(path.ray, t, optics);
    const double seen = transmittance(path.ray, spans_, t, optics, rng);
    if (seen <= 0) return 0;
    return light->fluence_per_um2 / (own + other) * scattered * task.light_photons[chosen][0] * seen *
           shadow(position, *light, optics, rng);
}

// Light scattered at the path's own vertex.
double LineTracer::scattered_here(const Path& path, const Flight& flight, const PathTask& task, Rng& rng) {
    const PathOptics& optics = *task.optics;
    const Vec3 position = path.ray.at(flight.t_um);
    const PhaseFunction& scatters = scene_->media[static_cast<std::size_t>(flight.medium)].phase;
    double density = -1;
    double total = 0;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const double photons = task.light_photons[l][0];
        if (photons <= 0) continue;
        const double u1 = rng.uniform();
        const auto light = sample_light(scene_->lights[l], position, u1, rng.uniform());
        if (!light) continue;
        const double phase = phase_per_sr(scatters, dot(light->to_light, path.ray.direction));
        double weight = 1;
        if (light->pdf_per_sr > 0) {
            weight = light->pdf_per_sr / (light->pdf_per_sr + phase);
        } else if (const double other = lit_pdf(l, flight.t_um); other > 0) {
            if (density < 0) density = scattering_density(path.ray, flight.t_um, optics);
            weight = density / (density + other);
        }
        total += weight * phase * light->fluence_per_um2 * photons * shadow(position, *light, optics, rng);
    }
    return total;
}

double LineTracer::radiance(const Ray& ray, const PathTask& task, Rng& rng) {
    const PathOptics& optics = *task.optics;
    const bool thick = is_thick(optics);
    Path path{ray, task.pdf_start_per_sr};
    int left = task.scatterings;
    double beta = 1;
    double total = 0;
    for (;;) {
        field_->gather(path.ray, spans_);
        if (has_rectangles_) total += beta * from_rectangles(path, task, rng);
        if (left == 0 && !has_surround_) break;
        if (left > 0 && find_lit_sections(path.ray, task, thick)) total += beta * scattered_once(path, task, rng);
        const Flight flight = fly(path.ray, optics, rng);
        if (flight.medium < 0) {
            if (has_surround_) total += beta * from_surround(path, task, rng);
            break;
        }
        if (left == 0) break;
        if (left != PathTask::kNoLimit) --left;
        beta *= flight.left;
        if (beta <= 0) break;
        total += beta * scattered_here(path, flight, task, rng);

        constexpr double kFaint = 0.05;
        if (beta < kFaint) {
            if (rng.uniform() * kFaint >= beta) break;
            beta = kFaint;
        }
        const PhaseFunction& phase = scene_->media[static_cast<std::size_t>(flight.medium)].phase;
        const double cosine = sample_phase_cosine(phase, rng.uniform());
        path.pdf_per_sr = phase_per_sr(phase, cosine);
        path.ray = {path.ray.at(flight.t_um), turned(path.ray.direction, cosine, rng.uniform())};
    }
    return total;
}

}  // namespace fluovox
