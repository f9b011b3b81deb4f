#include "fluovox/transport/line_tracer.h"

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/path_tracer.h"
#include "fluovox/transport/roulette.h"
#include "fluovox/transport/shadow_guess.h"
#include "fluovox/transport/weight_window.h"
#include "fluovox/volume/region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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

// What goes by roulette when it is worth less, where so much of the light got to before.
double faint_worth(const LinePlan& plan, std::uint8_t level) {
    return plan.window == nullptr ? kFaintPath : plan.window->lower_bound(level);
}

// PathRecord where nothing is learned.
struct NoRecord {
    static void fly() {}
    static void leave() {}
    static void see_level(std::uint8_t /*level*/) {}
    static void scatter(double /*worth*/, double /*found*/) {}
    static void add_own(double /*light*/) {}
};

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
        even_.emplace_back();
        if (!std::isfinite(size_um_) || box.empty() || !covers(light, box)) continue;
        even_.back() = sample_light(light, box.center(), 0, 0);
        if (even_.back()) even_.back()->distance_um = kFar;  // it starts before the box, beyond which nothing is
    }
}

void LineTracer::make_plan(const PathTask& task, LinePlan& plan) const {
    const PathOptics& optics = *task.optics;
    plan.optics = &optics;
    plan.scattering.clear();
    plan.absorbing.clear();
    plan.dimming.clear();
    for (const int i : field_->gridded()) {
        const PathOptics::MediumLanes& lanes = lanes_of(optics, i);
        const bool folded = is_folded(lanes);
        if (folded) {
            plan.scattering.push_back({i, lanes.extinction[0], lanes.scattering[0] / lanes.extinction[0]});
        } else if (lanes.scattering[0] > 0) {
            plan.scattering.push_back({i, lanes.scattering[0]});
        }
        if (!folded && lanes.absorption[0] > 0) plan.absorbing.push_back({i, lanes.absorption[0]});
        if (lanes.extinction[0] > 0) plan.dimming.push_back({i, lanes.extinction[0]});
    }
    // The transmittance at a first vertex is most of the noise; a later one is one of many and need only be right on
    // average. Not so where grids absorb: what gets through there finds no other way.
    plan.dim_later = plan.absorbing.empty() ? 1 : kDim;
    plan.is_thick = is_thick(optics);
    plan.lights.clear();
    plan.seeks_sections = false;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const double photons = task.light_photons[l][0];
        if (photons <= 0) continue;
        plan.lights.push_back({l, photons, nullptr});
        plan.seeks_sections = plan.seeks_sections || even_light(plan.lights.back(), plan) == nullptr;
    }
    if (plan.lights.size() < 2) return;
    // The brightest even light first: a weight window goes by that.
    const auto brightness = [&](const LinePlan::ShiningLight& light) {
        const LightSample* even = even_light(light, plan);
        return even == nullptr ? 0 : even->fluence_per_um2 * light.photons;
    };
    std::iter_swap(plan.lights.begin(),
                   std::max_element(plan.lights.begin(), plan.lights.end(),
                                    [&](const auto& a, const auto& b) { return brightness(a) < brightness(b); }));
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

bool LineTracer::find_lit_sections(const Ray& ray, const LinePlan& plan) {
    lit_.clear();
    sections_ = 0;
    const Interval reach = field_->reach(ray, spans_);
    for (const LinePlan::ShiningLight& light : plan.lights) {
        const bool is_sought = even_light(light, plan) == nullptr;
        lit_.emplace_back(scene_->lights[light.index], ray, is_sought ? reach : Interval{0, 0});
        sections_ += lit_.back() ? 1 : 0;
    }
    return sections_ > 0;
}

// `light`: its place among those that shine.
double LineTracer::lit_pdf(std::size_t light, double t_um) const {
    return sections_ > 0 && lit_[light] ? lit_[light].pdf(t_um) / static_cast<double>(sections_) : 0;
}

LineTracer::Flight LineTracer::fly(const Ray& ray, const LinePlan& plan, Rng& rng) {
    Flight flight{kFar, -1, 1, {}};
    for (const MediumSpan& s : spans_) {
        const double coefficient = lanes_of(*plan.optics, s.medium).scattering[0];
        if (coefficient <= 0) continue;
        const double t = s.span.begin + rng.exponential() / coefficient;
        if (t < s.span.end && t < flight.t_um) flight = {t, s.medium, 1, {}};
    }
    for (const LinePlan::TrackedGrid& grid : plan.scattering) {
        const GridCollision hit = field_->first_collision(grid.medium, ray, flight.t_um, grid.coefficient, rng);
        if (hit.t_um < flight.t_um) flight = {hit.t_um, grid.medium, grid.left, hit.voxel};
    }
    if (flight.medium >= 0) {
        ++field_->counts().real_collisions;
        flight.left *= absorption_left(ray, flight.t_um, plan, rng);
    }
    return flight;
}

// Of absorption alone; without that of grids where it is a factor at collisions.
double LineTracer::absorption_left(const Ray& ray, double end_um, const LinePlan& plan, Rng& rng) {
    double depth = 0;
    for (const MediumSpan& s : spans_) {
        const double coefficient = lanes_of(*plan.optics, s.medium).absorption[0];
        if (coefficient > 0) depth += coefficient * length_before(s.span, end_um);
    }
    return track_through(plan.absorbing, ray, end_um, depth, kDim, rng);
}

double LineTracer::transmittance(const Ray& ray, const std::vector<MediumSpan>& spans, double end_um, double dim,
                                 const LinePlan& plan, Rng& rng) {
    return track_through(plan.dimming, ray, end_um, hero_depth(spans, *plan.optics, end_um), dim, rng);
}

// What gets through an optical depth of constant media and through grids.
double LineTracer::track_through(const std::vector<LinePlan::TrackedGrid>& grids, const Ray& ray, double end_um,
                                 double depth, double dim, Rng& rng) {
    double left = depth > 0 ? std::exp(-depth) : 1;
    for (const LinePlan::TrackedGrid& grid : grids) {
        if (left > 0) left *= field_->ratio_transmittance(grid.medium, ray, end_um, grid.coefficient, dim, rng);
    }
    return left;
}

double LineTracer::shadow(Vec3 position, const LightSample& light, double dim, const LinePlan& plan, Rng& rng) {
    const Ray ray{position, light.to_light};
    if (field_->has_constant()) field_->gather(ray, shadow_spans_);
    return transmittance(ray, shadow_spans_, light.distance_um, dim, plan, rng);
}

// Light whose share is guessed: it is only looked up here, and added when it has come from memory.
void LineTracer::await(const Path& path, const Flight& flight, Vec3 position, const LinePlan::ShiningLight& shining,
                       double worth, const LinePlan& plan) {
    const LightSample& light = *even_[shining.index];
    if (field_->has_constant()) {
        field_->gather({position, light.to_light}, shadow_spans_);
        worth *= std::exp(-hero_depth(shadow_spans_, *plan.optics, light.distance_um));
    }
    awaited_.push_back(
        {shining.guess, shining.guess->find(position, flight.voxel), {position, light.to_light}, path.beta * worth});
}

// What was awaited: mostly guesses, sometimes one with what it was wrong by.
double LineTracer::add_awaited(const LinePlan& plan, Rng& rng) {
    double total = 0;
    for (const Awaited& light : awaited_) {
        const auto [guess, chance] = light.guess->at(light.place);
        double share = guess;
        if (rng.uniform() < chance) {
            const LinePlan::TrackedGrid& grid = plan.dimming[0];
            share += (field_->precise_transmittance(grid.medium, light.ray, grid.coefficient, rng) - guess) / chance;
        }
        total += light.worth * share;
    }
    awaited_.clear();
    return total;
}

// As OpticalField::scattering_density.
double LineTracer::scattering_density(const Ray& ray, double t_um, const LinePlan& plan) const {
    double coefficient = 0;
    double depth = 0;
    for (const MediumSpan& s : spans_) {
        const double own = lanes_of(*plan.optics, s.medium).scattering[0];
        if (own <= 0) continue;
        if (t_um >= s.span.begin && t_um <= s.span.end) coefficient += own;
        depth += own * length_before(s.span, t_um);
    }
    for (const int i : field_->gridded()) {
        const double own = lanes_of(*plan.optics, i).scattering[0];
        if (own > 0) coefficient += own * scene_->media[static_cast<std::size_t>(i)].grid->trilinear(ray.at(t_um));
    }
    return coefficient * std::exp(-depth);
}

// Lights that the ray runs into, and light that is scattered once where it shines on the ray.
double LineTracer::seen_along(const Path& path, bool may_scatter, const LinePlan& plan, Rng& rng) {
    double total = has_rectangles_ ? from_rectangles(path, plan, rng) : 0;
    if (may_scatter && plan.seeks_sections && find_lit_sections(path.ray, plan))
        total += scattered_once(path, plan, rng);
    return total;
}

// Rectangles that the ray hits; they are also found by sampling them from its origin, unless that is the camera.
double LineTracer::from_rectangles(const Path& path, const LinePlan& plan, Rng& rng) {
    double total = 0;
    for (const LinePlan::ShiningLight& light : plan.lights) {
        const auto* rectangle = std::get_if<RectangleLight>(&scene_->lights[light.index].shape);
        if (rectangle == nullptr) continue;
        const auto t = hit_rectangle(*rectangle, path.ray);
        if (!t) continue;
        const double other = path.pdf_per_sr > 0 ? rectangle_pdf(*rectangle, path.ray.direction, *t) : 0;
        const double weight = path.pdf_per_sr > 0 ? path.pdf_per_sr / (path.pdf_per_sr + other) : 1;
        const double seen = transmittance(path.ray, spans_, *t, path.dim, plan, rng);
        total += weight * rectangle_radiance(*rectangle) * light.photons * seen;
    }
    return total;
}

// Uniform light where the path leaves.
double LineTracer::from_surround(const Path& path, const LinePlan& plan, Rng& rng) {
    if (!has_surround_) return 0;
    double photons = 0;
    for (const LinePlan::ShiningLight& light : plan.lights) {
        if (std::holds_alternative<UniformLight>(scene_->lights[light.index].shape)) photons += light.photons;
    }
    return photons > 0 ? photons * absorption_left(path.ray, kFar, plan, rng) : 0;
}

// Light scattered at a point drawn where it shines on the ray.
double LineTracer::scattered_once(const Path& path, const LinePlan& plan, Rng& rng) {
    auto left = static_cast<std::ptrdiff_t>(rng.uniform() * static_cast<double>(sections_));
    std::size_t chosen = 0;
    for (std::size_t i = 0; i < lit_.size(); ++i) {
        if (lit_[i] && left-- == 0) chosen = i;
    }
    const double t = lit_[chosen].sample(rng.uniform());
    const double own = lit_pdf(chosen, t);
    const Vec3 position = path.ray.at(t);
    const double u1 = rng.uniform();
    const auto light = sample_light(scene_->lights[plan.lights[chosen].index], position, u1, rng.uniform());
    if (!light || !(own > 0)) return 0;
    field_->scattering_at(path.ray, t, spans_, *plan.optics, by_medium_, rng);
    const double cosine = dot(light->to_light, path.ray.direction);
    double scattered = 0;
    for (std::size_t i = 0; i < by_medium_.size(); ++i) {
        if (by_medium_[i][0] > 0) scattered += phase_per_sr(scene_->media[i].phase, cosine) * by_medium_[i][0];
    }
    if (scattered <= 0) return 0;
    const double other = scattering_density(path.ray, t, plan);
    const double seen = transmittance(path.ray, spans_, t, path.dim, plan, rng);
    if (seen <= 0) return 0;
    return light->fluence_per_um2 / (own + other) * scattered * plan.lights[chosen].photons * seen *
           shadow(position, *light, path.dim, plan, rng);
}

// Light scattered at the path's own vertex, but for what is awaited.
double LineTracer::scattered_here(const Path& path, const Flight& flight, const LinePlan& plan, Rng& rng) {
    const Vec3 position = path.ray.at(flight.t_um);
    const PhaseFunction& scatters = scene_->media[static_cast<std::size_t>(flight.medium)].phase;
    double total = 0;
    for (std::size_t i = 0; i < plan.lights.size(); ++i) {
        const LinePlan::ShiningLight& shining = plan.lights[i];
        if (const LightSample* even = even_light(shining, plan); even != nullptr) {
            const double phase = phase_per_sr(scatters, dot(even->to_light, path.ray.direction));
            const double worth = phase * even->fluence_per_um2 * shining.photons;
            if (shining.guess != nullptr && flight.medium == plan.dimming[0].medium) {
                await(path, flight, position, shining, worth, plan);
            } else {
                total += path.beta * worth * shadow(position, *even, path.dim, plan, rng);
            }
            continue;
        }
        const double u1 = rng.uniform();
        const auto light = sample_light(scene_->lights[shining.index], position, u1, rng.uniform());
        if (!light) continue;
        const double phase = phase_per_sr(scatters, dot(light->to_light, path.ray.direction));
        double weight = 1;
        if (light->pdf_per_sr > 0) {
            weight = light->pdf_per_sr / (light->pdf_per_sr + phase);
        } else if (const double other = lit_pdf(i, flight.t_um); other > 0) {
            const double density = scattering_density(path.ray, flight.t_um, plan);
            weight = density / (density + other);
        }
        const double seen = shadow(position, *light, path.dim, plan, rng);
        total += path.beta * weight * phase * light->fluence_per_um2 * shining.photons * seen;
    }
    return total;
}

// To where it is scattered at the end of its flight.
void LineTracer::turn(Path& path, const Flight& flight, Rng& rng) const {
    const PhaseFunction& phase = scene_->media[static_cast<std::size_t>(flight.medium)].phase;
    path.ray.origin = path.ray.at(flight.t_um);
    if (is_isotropic(phase)) {
        path.ray.direction = sample_isotropic(rng);
        path.pdf_per_sr = 1 / (4 * std::numbers::pi);
        return;
    }
    const double cosine = sample_phase_cosine(phase, rng.uniform());
    path.pdf_per_sr = has_rectangles_ ? phase_per_sr(phase, cosine) : 0;
    path.ray.direction = turned(path.ray.direction, cosine, rng.uniform());
}

template <class Record>
double LineTracer::follow(Path path, const LinePlan& plan, int scatterings, Rng& rng, Record& record) {
    int left = scatterings;
    double total = 0;
    double faint = kFaintPath;
    const auto add_own = [&](double light) {
        total += light;
        record.add_own(light);
    };
    for (;;) {
        if (field_->has_constant()) field_->gather(path.ray, spans_);
        total += path.beta * seen_along(path, left > 0, plan, rng);
        if (left == 0 && !has_surround_) break;
        const Flight flight = fly(path.ray, plan, rng);
        record.fly();
        if (!awaited_.empty()) {
            const std::uint8_t level = *awaited_.front().place.level;
            record.see_level(level);
            faint = faint_worth(plan, level);
            add_own(add_awaited(plan, rng));
        }
        if (flight.medium < 0) {
            record.leave();
            total += path.beta * from_surround(path, plan, rng);
            break;
        }
        if (left == 0) break;
        if (left != PathTask::kNoLimit) --left;
        path.beta *= flight.left;
        if (path.beta <= 0) break;
        record.scatter(path.beta, total);
        add_own(scattered_here(path, flight, plan, rng));

        if (!survives(path.beta, faint, rng)) break;
        turn(path, flight, rng);
        path.dim = plan.dim_later;
    }
    add_own(add_awaited(plan, rng));
    return total;
}

// In one function with its steps, but for the tracking of grids.
[[gnu::flatten]] double LineTracer::radiance(const Ray& ray, const LinePlan& plan, int scatterings, double pdf_per_sr,
                                             Rng& rng) {
    NoRecord record;
    return follow({ray, pdf_per_sr}, plan, scatterings, rng, record);
}

double LineTracer::record(const Ray& ray, const LinePlan& plan, int scatterings, Rng& rng, PathRecord& record) {
    return follow({ray}, plan, scatterings, rng, record);
}

}  // namespace fluovox
