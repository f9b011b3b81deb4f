#include "fluovox/transport/stack_view.h"

#include "fluovox/image/preview.h"
#include "fluovox/image/relative_error.h"
#include "fluovox/scene/stack.h"
#include "fluovox/transport/darkness.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/illumination.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace fluovox {
namespace {

/// The dye that lights most of a channel, judged by how strongly it is excited; -1: none.
int brightest_dye(const Scene& scene, const Illumination& lights, const FilmChannel& channel) {
    int best = -1;
    double most = 0;
    for (std::size_t d = 0; d < scene.dyes.size(); ++d) {
        const double seen =
            integral_of_product(scene.dyes[d].emission_per_nm, channel.response) * lights.strength(static_cast<int>(d));
        if (seen <= most) continue;
        most = seen;
        best = static_cast<int>(d);
    }
    return best;
}

/// The laser line that excites a dye most; 0 where none does.
double exciting_line_nm(const Dye& dye, const Illumination& lights) {
    double nm = 0;
    double most = 0;
    for (const Illumination::Line& line : lights.lines()) {
        double photons = 0;
        for (const double of_light : line.photons)
            photons += of_light;
        const double uptake = photons * dye.molar_absorption_per_M_cm(line.wavelength_nm);
        if (uptake <= most) continue;
        most = uptake;
        nm = line.wavelength_nm;
    }
    return nm;
}

/// As StackChannel::photon_nm: photons over photons per wavelength.
double mean_photon_nm(const Dye& dye, const FilmChannel& channel) {
    constexpr int kSteps = 4000;
    const double from = channel.response.first_nm();
    const double step = (channel.response.last_nm() - from) / kSteps;
    double photons = 0;
    double energy = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double nm = from + (i + 0.5) * step;
        const double seen = dye.emission_per_nm(nm) * channel.response(nm);
        photons += seen;
        energy += seen / nm;
    }
    return energy > 0 ? photons / energy : 0;
}

std::vector<StackChannel> describe_channels(const Scene& scene) {
    const FilmSpec& film = scene.description.film;
    const Illumination lights(scene);
    const std::vector<std::uint32_t> colors = channel_colors(film);
    std::vector<StackChannel> channels;
    for (std::size_t c = 0; c < film.channels.size(); ++c) {
        const FilmChannel& of_film = film.channels[c];
        StackChannel channel;
        channel.name = of_film.name;
        channel.emission_nm = of_film.center_nm;
        channel.counts_photons = of_film.counts_photons || film.unit == FilmUnit::Photons;
        channel.has_efficiency = of_film.counts_photons;
        if (film.is_spectral) channel.width_nm = of_film.response.last_nm() - of_film.response.first_nm();
        channel.rgb = colors[c];
        const int dye = brightest_dye(scene, lights, of_film);
        if (dye >= 0) {
            channel.dye = scene.dyes[static_cast<std::size_t>(dye)].name;
            channel.excitation_nm = exciting_line_nm(scene.dyes[static_cast<std::size_t>(dye)], lights);
            channel.photon_nm = mean_photon_nm(scene.dyes[static_cast<std::size_t>(dye)], of_film);
        }
        channels.push_back(std::move(channel));
    }
    return channels;
}

Vec3 sharp_point(const Camera& camera) {
    return camera.position + camera.focus_um * normalized(camera.target - camera.position);
}

// Range of the distances of a box's corners along a unit vector from a point.
struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    Range(const Bounds& box, Vec3 origin, Vec3 axis) {
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 p{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                         (corner & 4) != 0 ? box.max.z : box.min.z};
            low = std::min(low, dot(p - origin, axis));
            high = std::max(high, dot(p - origin, axis));
        }
    }
};

/// How far a sheet stays from a box while it goes along the stack; nothing when it meets it.
std::optional<std::string> miss(const SheetLight& first, Vec3 way_um, const Bounds& box) {
    const Range across(box, first.waist, first.normal);
    const double way = dot(way_um, first.normal);
    const double low = std::min(0.0, way) - first.thickness_um;
    const double high = std::max(0.0, way) + first.thickness_um;
    const double gap = std::max(low - across.high, across.low - high);
    if (!(gap > 0)) return std::nullopt;
    return fmt::format(
        "the sheet misses it by {:.3g} um in every plane (across the sheet, measured from the first plane, the "
        "specimen reaches from {:.3g} to {:.3g} um, the stack from {:.3g} to {:.3g} um)",
        gap, across.low, across.high, std::min(0.0, way), std::max(0.0, way));
}

/// Sheets that pass beside a medium.
void doubt_sheets(const Scene& first, const SceneMedium& medium, Vec3 way_um, std::vector<std::string>& doubts) {
    const Bounds box = medium.grid ? medium.grid->bounds() : bounds_of(medium.region);
    if (medium.dye < 0 || !std::isfinite(length(box.size()))) return;
    for (const Light& light : first.lights) {
        const auto* sheet = std::get_if<SheetLight>(&light.shape);
        const auto missed = sheet != nullptr ? miss(*sheet, way_um, box) : std::nullopt;
        if (!missed) continue;
        std::string doubt = fmt::format("{}: {}", medium.name, *missed);
        // Sheets of several colours mostly go the same way.
        if (std::find(doubts.begin(), doubts.end(), doubt) == doubts.end()) doubts.push_back(std::move(doubt));
    }
}

void doubt_sheets(const Scene& scene, std::vector<std::string>& doubts) {
    const StackDescription& stack = *scene.description.stack;
    for (std::size_t i = 0; i < stack.views.angles_rad.size(); ++i) {
        const int view = static_cast<int>(i);
        const Scene first = scene_at(scene, view, 0);
        const Scene last = scene_at(scene, view, plane_count(stack) - 1);
        const Vec3 way = sharp_point(last.description.camera) - sharp_point(first.description.camera);
        for (const SceneMedium& medium : first.media)
            doubt_sheets(first, medium, way, doubts);
    }
}

bool has_light(const Scene& scene, const FilmChannel& channel) {
    const auto shines = [&](const Spectrum& spectrum) {
        return !spectrum.empty() && integral_of_product(spectrum, channel.response) > 0;
    };
    for (const Dye& dye : scene.dyes) {
        if (shines(dye.emission_per_nm)) return true;
    }
    for (const Light& light : scene.lights) {
        if (shines(light.spectrum.energy_per_nm)) return true;
        for (const auto& line : light.spectrum.lines) {
            if (channel.response(line.wavelength_nm) > 0) return true;
        }
    }
    return false;
}

/// As StackInfo has it; `way` leads from the first plane to the second.
Vec3 origin_um(const StackInfo& info, const Camera& first, Vec3 way) {
    const Vec3 axis = normalized(first.target - first.position);
    const Vec3 right = normalized(cross(axis, first.up));
    const Vec3 down = cross(axis, right);
    const Vec3 middle = info.positions_um.front();
    return {dot(middle, right) - 0.5 * (info.width - 1) * info.pixel_um,
            dot(middle, down) - 0.5 * (info.height - 1) * info.pixel_um, dot(middle, normalized(way))};
}

}  // namespace

StackInfo describe_stack(const Scene& scene, int view) {
    const SceneDescription& description = scene.description;
    const StackDescription& stack = *description.stack;
    const Camera& camera = description.camera;
    StackInfo info;
    info.title = description.title.empty() ? "fluovox stack" : description.title;
    info.width = camera.width;
    info.height = camera.height;
    info.planes = plane_count(stack);
    info.channels = describe_channels(scene);
    info.pixel_um = pixel_um(camera);
    info.step_um = stack.step_um;
    const Camera at_first = scene_at(scene, view, 0).description.camera;
    const Vec3 first = sharp_point(at_first);
    const Vec3 second = sharp_point(scene_at(scene, view, 1).description.camera);
    for (int plane = 0; plane < info.planes; ++plane)
        info.positions_um.push_back(first + static_cast<double>(plane) * (second - first));
    info.origin_um = origin_um(info, at_first, second - first);
    info.angle_deg = stack.views.angles_rad[static_cast<std::size_t>(view)] * 180 / std::numbers::pi;
    info.numerical_aperture = camera.numerical_aperture * camera.immersion_index;
    info.immersion_index = camera.immersion_index;
    info.exposure_s = camera.exposure_s;
    info.quantity = "radiance";
    info.blur_um = camera.blur_um;
    const char* what = description.film.unit == FilmUnit::Photons ? "photons.s^-1" : "W";
    info.unit = fmt::format("{}.m^-2.sr^-1{}", what, description.film.is_spectral ? ".nm^-1" : "");
    info.scene_json = to_json(description);
    return info;
}

std::vector<std::string> doubts_about_stack(const Scene& scene) {
    std::vector<std::string> doubts;
    doubt_sheets(scene, doubts);
    for (const FilmChannel& channel : scene.description.film.channels) {
        if (scene.description.film.is_spectral || has_light(scene, channel)) continue;
        doubts.push_back(
            fmt::format("channel \"{}\": no dye emits and no light shines between {:.4g} and {:.4g} nm; "
                        "it will be black",
                        channel.name, channel.response.first_nm(), channel.response.last_nm()));
    }
    return doubts;
}

std::vector<float> plane_values(const Film& film, int layer, PlaneFigures& figures) {
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(film.pixels()) * static_cast<std::size_t>(film.channels()));
    for (int channel = 0; channel < film.channels(); ++channel) {
        for (int pixel = 0; pixel < film.pixels(); ++pixel)
            values.push_back(static_cast<float>(film.mean(layer, pixel, channel)));
    }
    for (const float value : values)
        figures.max_value = std::max(figures.max_value, static_cast<double>(value));
    const RelativeErrors errors = relative_errors(film, layer, BrightestOf::LitPixels);
    figures.median_relative_error = errors.all;
    figures.bright_relative_error = errors.brightest;
    figures.nan_count = film.nan_count();
    figures.bound_violations = film.bound_violations();
    figures.is_dark = is_dark(film);
    return values;
}

}  // namespace fluovox
