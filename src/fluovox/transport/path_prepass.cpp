#include "fluovox/transport/path_prepass.h"

#include "fluovox/medium/phase_function.h"
#include "fluovox/optics/camera_ray.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/line_tracer.h"
#include "fluovox/transport/path_tracer.h"

#include <algorithm>
#include <numbers>
#include <optional>
#include <vector>

namespace fluovox {
namespace {

constexpr int kPairs = 2048;
constexpr double kPathsPerSurveyed = 32;

// True where what paths find depends so much on where they fly that a few thousand of them do not tell.
bool scatters_sharply(const Scene& scene) {
    constexpr double kSharp = 10;  // times as much as evenly in all directions
    return std::any_of(scene.media.begin(), scene.media.end(), [](const SceneMedium& medium) {
        const double peak = std::max(phase_per_sr(medium.phase, 1), phase_per_sr(medium.phase, -1));
        return peak * 4 * std::numbers::pi > kSharp;
    });
}

std::optional<WeightWindow> survey(const Scene& scene, const LinePlan& plan, LineTracer& tracer) {
    const SceneDescription& description = scene.description;
    const CameraRays camera(description.camera);
    const int width = description.camera.width;
    const double pixels = static_cast<double>(width) * description.camera.height;
    const int scatterings = description.render.max_scatterings.value_or(PathTask::kNoLimit);
    WeightWindow::Survey survey;
    PathRecord record;
    for (int pair = 0; pair < kPairs; ++pair) {
        Rng rng(0x77696e646f77, static_cast<std::uint64_t>(pair), 0);
        const int pixel = static_cast<int>((pair + rng.uniform()) / kPairs * pixels);
        const auto follow = [&] {
            record.clear();
            const Ray ray = camera.sample(pixel % width, pixel / width, rng);
            const double light = tracer.record(ray, plan, scatterings, rng, record);
            survey.add(record, light);
            return light;
        };
        const double light = follow();
        survey.add_pair(light, follow());
    }
    return survey.window();
}

}  // namespace

PathPrepass::PathPrepass(const Scene& scene, const Illumination& illumination, std::int64_t paths)
    : shadows_(scene, illumination, paths) {
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    const std::vector<std::size_t> seen = illumination.lines_seen_by(film);
    const double surveyed = 2.0 * kPairs * static_cast<double>(seen.size());
    const bool are_many = static_cast<double>(paths) >= kPathsPerSurveyed * surveyed;
    if (shadows_.empty() || !are_many || scatters_sharply(scene)) return;
    OpticalField field(scene);
    LineTracer tracer(scene, field);
    for (const std::size_t i : seen) {
        const Illumination::Line& line = illumination.lines()[i];
        const PathOptics optics = field.optics(Wavelengths::one(line.wavelength_nm));
        LinePlan plan;
        tracer.make_plan(line_task(line, optics), plan);
        add_to(plan, i);
        // Levels say nothing of light that is not guessed.
        const bool tells = std::all_of(plan.lights.begin(), plan.lights.end(),
                                       [](const auto& light) { return light.guess != nullptr; });
        if (plan.lights.empty() || !tells) continue;
        if (const auto window = survey(scene, plan, tracer)) windows_.emplace(i, *window);
    }
    counts_ = field.counts();
}

void PathPrepass::add_to(LinePlan& plan, std::size_t line) const {
    for (LinePlan::ShiningLight& light : plan.lights)
        light.guess = shadows_.find(line, light.index);
    const auto window = windows_.find(line);
    plan.window = window == windows_.end() ? nullptr : &window->second;
}

}  // namespace fluovox
