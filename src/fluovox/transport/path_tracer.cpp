#include "fluovox/transport/path_tracer.h"

#include "fluovox/medium/phase_function.h"
#include "fluovox/transport/roulette.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

// Cosine between the flight of light before and after it is scattered towards the camera along `ray`:
// light flies against `to_light` and then against the ray.
double scattering_cosine(Vec3 to_light, Vec3 ray_direction) {
    return dot(to_light, ray_direction);
}

}  // namespace

Lanes PathRadiance::converted() const {
    Lanes total(elastic.count());
    for (const Lanes& dye : by_dye)
        total += dye;
    return total;
}

PathTask line_task(const Illumination::Line& line, const PathOptics& optics) {
    PathTask task;
    task.optics = &optics;
    for (const double photons : line.photons)
        task.light_photons.emplace_back(1, photons);
    return task;
}

PathTracer::PathTracer(const Scene& scene, const Illumination& illumination, const PathPrepass& prepass)
    : scene_(&scene), illumination_(&illumination), field_(scene), line_tracer_(scene, field_) {
    for (const Illumination::Line& line : illumination.lines()) {
        line_optics_.push_back(field_.optics(Wavelengths::one(line.wavelength_nm)));
    }
    for (std::size_t i = 0; i < line_optics_.size(); ++i) {
        LinePlan& plan = line_plans_.emplace_back();
        line_tracer_.make_plan(line_task(illumination.lines()[i], line_optics_[i]), plan);
        prepass.add_to(plan, i);
    }
    for (const Light& light : scene.lights) {
        has_far_lights_ = has_far_lights_ || std::holds_alternative<UniformLight>(light.shape) ||
                          std::holds_alternative<RectangleLight>(light.shape);
    }
    double g = 0;
    for (const SceneMedium& medium : scene.media)
        g = std::max(g, mean_cosine(medium.phase));
    for (const Light& light : scene.lights) {
        const auto* sheet = std::get_if<SheetLight>(&light.shape);
        const auto* beam = std::get_if<BeamLight>(&light.shape);
        if (g <= 0 || (sheet == nullptr && beam == nullptr)) continue;
        const Vec3 back = -(sheet != nullptr ? sheet->direction : beam->direction);
        lobes_.push_back({back, g});          // scattered once
        lobes_.push_back({back, g * g * g});  // a few times
    }
    for (const Dye& absorber : scene.dyes) {
        dye_to_dye_.emplace_back();
        for (const Dye& emitter : scene.dyes) {
            dye_to_dye_.back().push_back(sampling_product(emitter.emission_per_nm, absorber.molar_absorption_per_M_cm));
        }
    }
}

PathTracer::Level& PathTracer::level(std::size_t depth) {
    while (levels_.size() <= depth)
        levels_.push_back(std::make_unique<Level>());
    return *levels_[depth];
}

void PathTracer::estimate(const Ray& ray, const PathTask& task, Rng& rng, PathRadiance& result) {
    result.elastic = Lanes(task.optics->wavelengths.count());
    result.by_dye.assign(scene_->dyes.size(), result.elastic);
    trace(ray, task, 0, rng, result);
}

void PathTracer::trace(const Ray& ray, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result) {
    const int count = task.optics->wavelengths.count();
    const bool wants_light = !task.light_photons.empty();
    if (count == 1 && !converts(task)) {
        if (!wants_light) return;
        line_tracer_.make_plan(task, plan_);
        result.elastic[0] += line_tracer_.radiance(ray, plan_, task.scatterings, task.pdf_start_per_sr, rng);
        return;
    }
    Level& here = level(depth);
    if (converts(task)) weigh_dyes(*task.optics, here);

    Walk walk;
    Stretch& path = walk.stretch;
    path.ray = ray;
    path.scatterings = task.scatterings;
    path.beta = path.density = Lanes(count, 1);
    path.pdf_per_sr = task.pdf_start_per_sr;
    do {
        field_.gather(path.ray, here.spans);
        find_lights(walk, task, here);
        if (wants_light) add_rectangles(path, task, here, rng, result);
        if (wants_light && path.scatterings > 0) add_scattered_once(path, task, here, rng, result);
        if (converts(task)) convert_along(walk, task, depth, rng, result);
        walk.is_first = false;
    } while (go_on(path, task, here, rng, result));

    if (revisit(walk.later, task, here)) convert(walk.later.item, task, depth, rng, result);
    if (revisit(walk.any, task, here)) convert_again(walk.any.item, task, depth, rng, result);
}

bool PathTracer::converts(const PathTask& task) const {
    return task.orders > 0 && !scene_->dyes.empty();
}

// Where a stretch is lit: by any light where dyes may take it up, else by those that shine at the wavelengths.
void PathTracer::find_lights(const Walk& walk, const PathTask& task, Level& level) const {
    if (walk.is_first && converts(task)) {
        find_lit_sections(walk.stretch.ray, nullptr, level);
    } else if (!task.light_photons.empty()) {
        find_lit_sections(walk.stretch.ray, &task, level);
    }
}

// Converts on the first stretch; the others are drawn from when all are known.
void PathTracer::convert_along(Walk& walk, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result) {
    const Stretch& path = walk.stretch;
    Level& here = level(depth);
    here.sources.build(field_, here.brightness, path.ray, here.spans, *task.optics);
    const double weight = path.beta.mean() * here.sources.total();
    if (walk.is_first) {
        convert(path, task, depth, rng, result);
    } else {
        walk.later.offer(path, weight, rng);
    }
    if (task.orders > 1) walk.any.offer(path, weight, rng);
}

// Notes what each dye emits at the wavelengths, and how bright that makes it.
void PathTracer::weigh_dyes(const PathOptics& optics, Level& level) const {
    level.emission.clear();
    level.brightness.clear();
    for (std::size_t d = 0; d < scene_->dyes.size(); ++d) {
        level.emission.push_back(scene_->dyes[d].emission_per_nm(optics.wavelengths.nm));
        level.brightness.push_back(illumination_->strength(static_cast<int>(d)) * level.emission[d].sum());
    }
}

// From a stretch to the one behind its scattering; false where the path ends.
bool PathTracer::go_on(Stretch& path, const PathTask& task, Level& level, Rng& rng, PathRadiance& result) {
    const PathOptics& optics = *task.optics;
    const bool wants_light = !task.light_photons.empty();
    const auto vertex = next_vertex(path, task, level, rng);
    if (!vertex) {
        if (wants_light) add_surround(path, task, level, rng, result);
        return false;
    }
    if (path.scatterings == 0) return false;
    path.beta *= field_.transmittance(path.ray, level.spans, vertex->at.t_um, optics, Loss::Absorption, rng);
    if (path.scatterings != PathTask::kNoLimit) --path.scatterings;
    if (wants_light) add_lights_at(path, *vertex, task, level, rng, result);
    if (!survives(path.beta, kFaintPath, rng)) return false;

    const PhaseFunction& phase = scene_->media[static_cast<std::size_t>(vertex->at.medium)].phase;
    const double cosine = sample_phase_cosine(phase, rng.uniform());
    path.pdf_per_sr = phase_per_sr(phase, cosine);
    path.ray = {path.ray.at(vertex->at.t_um), turned(path.ray.direction, cosine, rng.uniform())};
    return true;
}

// Where the stretch is scattered, if it is; the worth of the path at each wavelength follows the outcome.
std::optional<PathTracer::Vertex> PathTracer::next_vertex(Stretch& path, const PathTask& task, Level& level, Rng& rng) {
    const PathOptics& optics = *task.optics;
    Lanes likeness;
    const auto scattering = field_.sample_scattering(path.ray, level.spans, optics, rng, likeness);
    std::optional<Vertex> vertex;
    if (scattering) {
        vertex = {*scattering, 0};
        // The density that lights are weighed by is that before this stretch's own outcome.
        if (!task.light_photons.empty())
            vertex->density =
                (path.density * field_.scattering_density(path.ray, scattering->t_um, level.spans, optics)).mean();
    }
    if (!optics.grey_scattering) {
        path.density *= likeness;
        const double mean_density = path.density.mean();
        path.beta = (1 / mean_density) * (path.beta * likeness);
        path.density *= 1 / mean_density;
    }
    return vertex;
}

// Gets the level ready for the stretch that was drawn; false when there is none.
bool PathTracer::revisit(Drawn<Stretch>& drawn, const PathTask& task, Level& level) {
    if (!(drawn.weight > 0)) return false;
    drawn.item.beta *= drawn.all / drawn.weight;
    field_.gather(drawn.item.ray, level.spans);
    find_lit_sections(drawn.item.ray, nullptr, level);
    level.sources.build(field_, level.brightness, drawn.item.ray, level.spans, *task.optics);
    return true;
}

// Of all lights or, where there is a task, of those that shine at its wavelengths.
void PathTracer::find_lit_sections(const Ray& ray, const PathTask* task, Level& level) const {
    level.lit.clear();
    const Interval reach = field_.reach(ray, level.spans);
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const bool shines = task == nullptr || task->light_photons[l].max() > 0;
        level.lit.emplace_back(scene_->lights[l], ray, shines ? reach : Interval{0, 0});
    }
}

// Density with which choose_lit_section and the section's own sample find a point.
double PathTracer::lit_pdf(const Level& level, std::size_t light, double t_um) {
    if (!level.lit[light]) return 0;
    const auto sections = std::count_if(level.lit.begin(), level.lit.end(), [](const auto& s) { return bool(s); });
    return level.lit[light].pdf(t_um) / static_cast<double>(sections);
}

std::optional<std::size_t> PathTracer::choose_lit_section(const Level& level, Rng& rng) {
    const auto sections = std::count_if(level.lit.begin(), level.lit.end(), [](const auto& s) { return bool(s); });
    if (sections == 0) return std::nullopt;
    auto left = static_cast<std::ptrdiff_t>(rng.uniform() * static_cast<double>(sections));
    for (std::size_t i = 0; i < level.lit.size(); ++i) {
        if (level.lit[i] && left-- == 0) return i;
    }
    return std::nullopt;
}

Lanes PathTracer::transmittance_to_light(Vec3 position, const LightSample& light, const PathOptics& optics,
                                         Level& level, Rng& rng) {
    const Ray shadow{position, light.to_light};
    field_.gather(shadow, level.shadow_spans);
    return field_.transmittance(shadow, level.shadow_spans, light.distance_um, optics, Loss::Extinction, rng);
}

void PathTracer::add_rectangles(const Stretch& path, const PathTask& task, Level& level, Rng& rng,
                                PathRadiance& result) {
    const double pdf_per_sr = path.pdf_per_sr;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const auto* rectangle = std::get_if<RectangleLight>(&scene_->lights[l].shape);
        if (rectangle == nullptr) continue;
        const auto t = hit_rectangle(*rectangle, path.ray);
        if (!t) continue;
        // The same light is also found by sampling the rectangle from the ray's origin, unless that is the camera.
        const double other = pdf_per_sr > 0 ? rectangle_pdf(*rectangle, path.ray.direction, *t) : 0;
        const double weight = pdf_per_sr > 0 ? pdf_per_sr / (pdf_per_sr + other) : 1;
        const Lanes seen =
            field_.transmittance(path.ray, level.spans, *t, *task.optics, Loss::Extinction, rng) * path.beta;
        result.elastic += (weight * rectangle_radiance(*rectangle)) * (seen * task.light_photons[l]);
    }
}

void PathTracer::add_surround(const Stretch& path, const PathTask& task, Level& level, Rng& rng, PathRadiance& result) {
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        if (!std::holds_alternative<UniformLight>(scene_->lights[l].shape)) continue;
        const Lanes seen =
            field_.transmittance(path.ray, level.spans, kFar, *task.optics, Loss::Absorption, rng) * path.beta;
        result.elastic += seen * task.light_photons[l];
    }
}

void PathTracer::add_scattered_once(const Stretch& path, const PathTask& task, Level& level, Rng& rng,
                                    PathRadiance& result) {
    const auto chosen = choose_lit_section(level, rng);
    if (!chosen) return;
    const PathOptics& optics = *task.optics;
    const double t = level.lit[*chosen].sample(rng.uniform());
    const double own = lit_pdf(level, *chosen, t);
    const Vec3 position = path.ray.at(t);
    const auto light = sample_light(scene_->lights[*chosen], position, rng.uniform(), rng.uniform());
    if (!light || !(own > 0)) return;
    field_.scattering_at(path.ray, t, level.spans, optics, level.by_medium, rng);
    const double cosine = scattering_cosine(light->to_light, path.ray.direction);
    Lanes scattered(optics.wavelengths.count());
    for (std::size_t i = 0; i < level.by_medium.size(); ++i) {
        if (level.by_medium[i].max() <= 0) continue;
        scattered += phase_per_sr(scene_->media[i].phase, cosine) * level.by_medium[i];
    }
    if (scattered.max() <= 0) return;
    const double other = (path.density * field_.scattering_density(path.ray, t, level.spans, optics)).mean();
    const Lanes seen = field_.transmittance(path.ray, level.spans, t, optics, Loss::Extinction, rng) *
                       transmittance_to_light(position, *light, optics, level, rng) * path.beta;
    result.elastic += (light->fluence_per_um2 / (own + other)) * (seen * scattered * task.light_photons[*chosen]);
}

void PathTracer::add_lights_at(const Stretch& path, const Vertex& vertex, const PathTask& task, Level& level, Rng& rng,
                               PathRadiance& result) {
    const Vec3 position = path.ray.at(vertex.at.t_um);
    const PhaseFunction& scatters = scene_->media[static_cast<std::size_t>(vertex.at.medium)].phase;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        if (task.light_photons[l].max() <= 0) continue;
        const auto light = sample_light(scene_->lights[l], position, rng.uniform(), rng.uniform());
        if (!light) continue;
        const double phase = phase_per_sr(scatters, scattering_cosine(light->to_light, path.ray.direction));
        const double weight = light->pdf_per_sr > 0
                                  ? light->pdf_per_sr / (light->pdf_per_sr + phase)
                                  : vertex.density / (vertex.density + lit_pdf(level, l, vertex.at.t_um));
        const Lanes seen = transmittance_to_light(position, *light, *task.optics, level, rng) * path.beta;
        result.elastic += (weight * phase * light->fluence_per_um2) * (seen * task.light_photons[l]);
    }
}

}  // namespace fluovox
