#include "fluovox/transport/darkness.h"

#include "fluovox/transport/film_response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

Bounds bounds_of(const SceneMedium& medium) {
    return medium.grid ? medium.grid->bounds() : bounds_of(medium.region);
}

bool is_finite(const Bounds& bounds) {
    return std::isfinite(length(bounds.size()));
}

std::string distance(double um) {
    constexpr double kMillimetre = 1000;
    return std::abs(um) < kMillimetre ? fmt::format("{:.3g} um", um) : fmt::format("{:.3g} mm", um / kMillimetre);
}

// Range of the corners' distances along a unit vector from a point.
struct Range {
    double low = kFar, high = -kFar;

    double gap_to(double from, double to) const { return std::max({0.0, low - to, from - high}); }
};

Range along(const Bounds& box, Vec3 origin, Vec3 axis) {
    Range range;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p{(corner & 1) != 0 ? box.max.x : box.min.x, (corner & 2) != 0 ? box.max.y : box.min.y,
                     (corner & 4) != 0 ? box.max.z : box.min.z};
        const double distance = dot(p - origin, axis);
        range.low = std::min(range.low, distance);
        range.high = std::max(range.high, distance);
    }
    return range;
}

std::string miss_of_light(const SheetLight& sheet, const Bounds& box) {
    const Range across = along(box, sheet.waist, sheet.normal);
    const double thickness_gap = across.gap_to(-sheet.thickness_um, sheet.thickness_um);
    if (thickness_gap > 0) {
        return fmt::format("the sheet passes it {} away (specimen {} to {} from the sheet's plane)",
                           distance(thickness_gap), distance(across.low), distance(across.high));
    }
    const Range sideways = along(box, sheet.waist, cross(sheet.direction, sheet.normal));
    const double width_gap = sideways.gap_to(-0.5 * sheet.width_um, 0.5 * sheet.width_um);
    if (width_gap > 0) return fmt::format("the sheet's edge is {} away", distance(width_gap));
    const Range ahead = along(box, sheet.position, sheet.direction);
    if (ahead.high < 0) return fmt::format("the sheet starts {} behind it", distance(-ahead.high));
    return {};
}

std::string miss_of_light(const BeamLight& beam, const Bounds& box) {
    const Frame axes = Frame::around(beam.direction);
    const double reach = 2 * beam.radius_um;
    const double gap = std::max(along(box, beam.waist, axes.x).gap_to(-reach, reach),
                                along(box, beam.waist, axes.y).gap_to(-reach, reach));
    if (gap > 0) return fmt::format("the beam passes it {} away", distance(gap));
    const Range ahead = along(box, beam.position, beam.direction);
    if (ahead.high < 0) return fmt::format("the beam starts {} behind it", distance(-ahead.high));
    return {};
}

std::string miss_of_light(const RectangleLight& rectangle, const Bounds& box) {
    if (along(box, rectangle.center, rectangle.normal).high <= 0) return "the rectangle shines the other way";
    return {};
}

template <class Other>
std::string miss_of_light(const Other& /*light*/, const Bounds& /*box*/) {
    return {};
}

std::string miss_of_camera(const Camera& camera, const Bounds& box) {
    const Vec3 axis = normalized(camera.target - camera.position);
    const Vec3 right = normalized(cross(axis, camera.up));
    const Vec3 up = cross(right, axis);
    if (along(box, camera.position, axis).high <= 0) return "it lies behind the camera";
    if (camera.kind != Camera::Kind::Telecentric) return {};
    const double half_height = 0.5 * camera.field_um;
    const double half_width = half_height * camera.width / camera.height;
    const double gap = std::max(along(box, camera.position, right).gap_to(-half_width, half_width),
                                along(box, camera.position, up).gap_to(-half_height, half_height));
    if (gap > 0) return fmt::format("it lies {} outside the camera's field", distance(gap));
    return {};
}

void look_at_lights(const Scene& scene, const SceneMedium& medium, std::vector<std::string>& reasons) {
    const auto add = [&](const std::string& reason) {
        if (!reason.empty()) reasons.push_back(fmt::format("{}: {}", medium.name, reason));
    };
    if (medium.grid && medium.grid->max() <= 0) return add("its grid is empty");
    const Bounds box = bounds_of(medium);
    if (!is_finite(box)) return;
    for (const Light& light : scene.lights) {
        add(std::visit([&](const auto& shape) { return miss_of_light(shape, box); }, light.shape));
    }
}

void look_at_camera(const Scene& scene, const SceneMedium& medium, std::vector<std::string>& reasons) {
    const Bounds box = bounds_of(medium);
    if ((medium.grid && medium.grid->max() <= 0) || !is_finite(box)) return;
    const std::string reason = miss_of_camera(scene.description.camera, box);
    if (!reason.empty()) reasons.push_back(fmt::format("{}: {}", medium.name, reason));
}

}  // namespace

bool is_dark(const Film& film, const char* layer) {
    const int index = std::max(0, film.layer(layer));
    for (int pixel = 0; pixel < film.pixels(); ++pixel) {
        for (int channel = 0; channel < film.channels(); ++channel) {
            if (film.mean(index, pixel, channel) != 0) return false;
        }
    }
    return true;
}

std::vector<std::string> reasons_for_darkness(const Scene& scene) {
    std::vector<std::string> reasons;
    if (scene.lights.empty()) reasons.emplace_back("the scene has no light");
    if (scene.media.empty()) reasons.emplace_back("the scene has no medium");
    const FilmResponse response(scene.description.film, scene.description.render.filter);
    for (const Dye& dye : scene.dyes) {
        const auto& knots = dye.emission_per_nm.wavelengths_nm();
        const bool seen = std::any_of(knots.begin(), knots.end(),
                                      [&](double nm) { return dye.emission_per_nm(nm) > 0 && response.sees(nm); });
        if (!seen) reasons.push_back(fmt::format("{}: the film and filter see nothing of its emission", dye.name));
    }
    for (const SceneMedium& medium : scene.media) {
        look_at_lights(scene, medium, reasons);
        look_at_camera(scene, medium, reasons);
    }
    return reasons;
}

std::vector<std::string> how_lights_miss(const Scene& scene) {
    std::vector<std::string> reasons;
    for (const SceneMedium& medium : scene.media)
        look_at_lights(scene, medium, reasons);
    return reasons;
}

}  // namespace fluovox
