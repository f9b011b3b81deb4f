#include "fluovox/transport/samplable.h"

#include "fluovox/optics/light_sampling.h"
#include "fluovox/transport/endless.h"
#include "fluovox/transport/film_response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {
namespace {

/// What a sheet or beam looks like from far away: where it goes, how wide it is and how its rays spread.
struct Shaft {
    Vec3 point, direction;
    double radius_um = 0, spread_rad = 0;
};

std::optional<Shaft> shaft_of(const Light& light) {
    if (const auto* sheet = std::get_if<SheetLight>(&light.shape)) {
        return Shaft{sheet->waist, sheet->direction, std::hypot(0.5 * sheet->width_um, sheet->thickness_um),
                     std::asin(sheet->numerical_aperture)};
    }
    if (const auto* beam = std::get_if<BeamLight>(&light.shape)) {
        return Shaft{beam->waist, beam->direction, 2 * beam->radius_um, std::asin(beam->numerical_aperture)};
    }
    return std::nullopt;
}

// True when rays of the shaft can run straight into the camera.
bool shines_into(const Shaft& shaft, const Camera& camera) {
    const Vec3 axis = normalized(camera.target - camera.position);
    const bool telecentric = camera.kind == Camera::Kind::Telecentric;
    const double aspect = static_cast<double>(camera.width) / camera.height;
    const double corner = std::hypot(1.0, aspect);
    const double view =
        telecentric ? std::asin(camera.numerical_aperture) : std::atan(corner * std::tan(0.5 * camera.fov_rad));
    const double angle = std::acos(std::clamp(-dot(axis, shaft.direction), -1.0, 1.0));
    constexpr double kRounding = 1e-6;
    if (angle > view + shaft.spread_rad + kRounding) return false;
    const Vec3 seen = telecentric ? camera.position + camera.focus_um * axis : camera.position;
    const Vec3 apart = seen - shaft.point;
    const double distance = length(apart - dot(apart, shaft.direction) * shaft.direction);
    const double field_radius = telecentric ? 0.5 * camera.field_um * corner : 0;
    return distance < shaft.radius_um + field_radius;
}

// Paths from the camera travel at any wavelength that the film sees, whether the dyes emit there or not.
std::vector<double> path_wavelengths_nm(const Scene& scene) {
    std::vector<double> wavelengths_nm = travelling_wavelengths_nm(scene);
    for (const FilmChannel& channel : scene.description.film.channels) {
        wavelengths_nm.insert(wavelengths_nm.end(),
                              {channel.response.first_nm(), channel.center_nm, channel.response.last_nm()});
    }
    return wavelengths_nm;
}

}  // namespace

namespace {

// What paths from the camera can show of light that was not converted.
void require_lights_shown_by_path(const Scene& scene, bool all_wavelengths) {
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    const std::string estimator = all_wavelengths ? "path" : "cached";
    for (const LightDescription& light : scene.description.lights) {
        const bool seen = film.sees(light.light.spectrum);
        if (is_pencil(light.light) && (seen || all_wavelengths)) {
            throw SceneError(light.where,
                             fmt::format("the estimator \"{}\" cannot show a light without width; give it "
                                         "one, {}or use the estimator \"light\", which traces from the "
                                         "lights",
                                         estimator, all_wavelengths ? "" : "block its wavelength (render.filter), "));
        }
        const auto shaft = shaft_of(light.light);
        if (shaft && seen && shines_into(*shaft, scene.description.camera)) {
            throw SceneError(light.where,
                             fmt::format("this light shines straight into the camera, which the estimator \"{}\" "
                                         "cannot show; turn one of them, block its wavelength (render.filter), or use "
                                         "the estimator \"light\"",
                                         estimator));
        }
    }
}

void require_no_refraction(const Scene& scene, const char* estimator, const char* why) {
    for (const MediumDescription& medium : scene.description.media) {
        if (!medium.refractive_index) continue;
        throw SceneError(medium.where, fmt::format("the estimator \"{}\" {} and cannot find the way through a "
                                                   "refracting surface; use the estimator \"cached\" for what "
                                                   "the dyes send out, leave refractive_index out, or use fluovox "
                                                   "fluence, which follows photons from the lights",
                                                   estimator, why));
    }
}

}  // namespace

bool path_shows_all_lights(const Scene& scene) {
    try {
        require_lights_shown_by_path(scene, true);
    } catch (const SceneError&) {
        return false;
    }
    return true;
}

void require_samplable_by_path(const Scene& scene) {
    require_lights_shown_by_path(scene, true);
    require_no_refraction(scene, "path", "goes straight to lights");
    require_an_end(scene, path_wavelengths_nm(scene));
}

void require_samplable_with_cache(const Scene& scene) {
    require_lights_shown_by_path(scene, false);
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    const bool refracts = std::any_of(scene.media.begin(), scene.media.end(),
                                      [](const SceneMedium& medium) { return medium.refractive_index.has_value(); });
    for (const LightDescription& light : scene.description.lights) {
        if (!refracts || !film.sees(light.light.spectrum)) continue;
        throw SceneError(light.where,
                         "the film sees this light's own wavelengths, and no estimator can show light that was not "
                         "converted through a refracting surface; block them (render.filter) to see the dyes only, "
                         "leave refractive_index out, or use fluovox fluence, which counts what leaves each face");
    }
    require_an_end(scene, path_wavelengths_nm(scene));
}

}  // namespace fluovox
