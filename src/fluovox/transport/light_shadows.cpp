#include "fluovox/transport/light_shadows.h"

#include "fluovox/core/memory.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/line_tracer.h"
#include "fluovox/transport/path_tracer.h"

#include <algorithm>
#include <vector>

namespace fluovox {
namespace {

// The shadows of so many voxels take about a third of the time of one path.
constexpr double kVoxelsPerPath = 16;
// Of a wide and almost empty box the lines of light would take much more memory than the grid.
constexpr double kLinesPerVoxel = 1;
constexpr double kFewLines = 1e6;
constexpr double kMostLines = 4e9;  // they are counted in 32 bits

// The grid that alone dims and scatters the light; null where there is no such, or none to guess in.
const SparseGrid* only_grid(const Scene& scene, const LinePlan& plan) {
    if (plan.dimming.size() != 1 || plan.scattering.size() != 1) return nullptr;
    const SparseGrid& grid = *scene.media[static_cast<std::size_t>(plan.dimming[0].medium)].grid;
    if (!grid.has_directory() || grid.background() > 0) return nullptr;
    const double most = std::min(kFewLines + kLinesPerVoxel * static_cast<double>(grid.filled_voxels()), kMostLines);
    return ShadowGrid::most_lines(grid) <= most ? &grid : nullptr;
}

}  // namespace

LightShadows::LightShadows(const Scene& scene, const Illumination& illumination, std::int64_t paths) {
    const RenderDescription& render = scene.description.render;
    if (render.plain_tracking || render.max_scatterings == 0) return;
    const FilmResponse film(scene.description.film, render.filter);
    const std::vector<std::size_t> seen = illumination.lines_seen_by(film);
    OpticalField field(scene);
    const LineTracer tracer(scene, field);
    for (const std::size_t i : seen) {
        const Illumination::Line& line = illumination.lines()[i];
        const PathOptics optics = field.optics(Wavelengths::one(line.wavelength_nm));
        LinePlan plan;
        tracer.make_plan(line_task(line, optics), plan);
        const SparseGrid* grid = only_grid(scene, plan);
        const double of_the_line = static_cast<double>(paths) / static_cast<double>(seen.size());
        if (grid == nullptr || static_cast<double>(grid->filled_voxels()) > kVoxelsPerPath * of_the_line) continue;
        for (const LinePlan::ShiningLight& light : plan.lights) {
            const LightSample* even = tracer.even_light(light, plan);
            if (even == nullptr || guesses_.size() == kMost) continue;
            guesses_.try_emplace({i, light.index}, *grid, even->to_light, plan.dimming[0].coefficient);
        }
    }
    if (!guesses_.empty()) release_freed_memory();  // lines of light take more than what is made of them
}

std::size_t LightShadows::memory_bytes() const {
    std::size_t bytes = 0;
    for (const auto& [place, guess] : guesses_)
        bytes += guess.memory_bytes();
    return bytes;
}

}  // namespace fluovox
