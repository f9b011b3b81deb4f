#include "fluovox/optics/camera_ray.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

struct OnDisc {
    double a = 0, b = 0;
};

// A point of the unit disc: four of five in the square around it are, so trying costs less than sine and cosine.
OnDisc on_disc(Rng& rng) {
    for (;;) {
        const double a = 2 * rng.uniform() - 1;
        const double b = 2 * rng.uniform() - 1;
        if (a * a + b * b < 1) return {a, b};
    }
}

}  // namespace

CameraRays::CameraRays(const Camera& camera)
    : camera_(camera),
      axis_(normalized(camera.target - camera.position)),
      right_(normalized(cross(axis_, camera.up))),
      up_(cross(right_, axis_)),
      middle_(camera.position + camera.focus_um * axis_),
      pixel_um_(pixel_um(camera)),
      pixel_right_(pixel_um_ * right_),
      pixel_up_(pixel_um_ * up_),
      blur_sigma_(camera.blur_um / (2 * std::sqrt(2 * std::numbers::ln2))) {}  // of a full width at half maximum

// A random one on the focal plane.
Vec3 CameraRays::shift(Rng& rng) const {
    const double r = blur_sigma_ * std::sqrt(2 * rng.exponential());
    const double angle = 2 * std::numbers::pi * rng.uniform();
    return (r * std::cos(angle)) * right_ + (r * std::sin(angle)) * up_;
}

Ray CameraRays::sample(int x, int y, Rng& rng) const {
    const double across = x + rng.uniform() - 0.5 * camera_.width;
    const double upward = 0.5 * camera_.height - y - rng.uniform();
    const Vec3 sharp = middle_ + across * pixel_right_ + upward * pixel_up_ + blur(rng);
    if (camera_.numerical_aperture == 0 && camera_.kind == Camera::Kind::Telecentric)
        return {sharp - camera_.focus_um * axis_, axis_};
    double a = 0;
    double b = 0;
    if (camera_.numerical_aperture > 0) {  // a point of the unit disc
        const double radius = std::sqrt(rng.uniform());
        const double azimuth = 2 * std::numbers::pi * rng.uniform();
        a = radius * std::cos(azimuth);
        b = radius * std::sin(azimuth);
    }
    const double na = camera_.numerical_aperture;
    if (camera_.kind == Camera::Kind::Perspective) {
        const double lens_radius = camera_.focus_um * na / std::sqrt(1 - na * na);
        const Vec3 lens = camera_.position + (a * lens_radius) * right_ + (b * lens_radius) * up_;
        return {lens, normalized(sharp - lens)};
    }
    // Uniform over the disc of direction cosines is uniform in projected solid angle.
    const double forward = std::sqrt(1 - na * na * (a * a + b * b));
    const Vec3 direction = (a * na) * right_ + (b * na) * up_ + forward * axis_;
    return {sharp - (camera_.focus_um / forward) * direction, direction};
}

// The pixel of a point on the focal plane; false beside the film.
bool CameraRays::find_pixel(Vec3 sharp, CameraConnection& connection) const {
    const Vec3 from_axis = sharp - camera_.position;
    const double x = dot(from_axis, right_) / pixel_um_ + 0.5 * camera_.width;
    const double y = 0.5 * camera_.height - dot(from_axis, up_) / pixel_um_;
    if (!(x >= 0 && x < camera_.width && y >= 0 && y < camera_.height)) return false;
    connection.x = static_cast<int>(x);
    connection.y = static_cast<int>(y);
    return true;
}

double CameraRays::pixels_covered(Vec3 point_um) const {
    const double na = camera_.numerical_aperture;
    const double depth = dot(point_um - camera_.position, axis_);
    double radius = std::abs(depth - camera_.focus_um) * na / std::sqrt(1 - na * na);
    if (camera_.kind == Camera::Kind::Perspective && depth > 0) radius *= camera_.focus_um / depth;
    return std::max(1.0, std::numbers::pi * (radius * radius + blur_sigma_ * blur_sigma_) / (pixel_um_ * pixel_um_));
}

Vec3 CameraRays::to_camera(Vec3 point_um) const {
    return camera_.kind == Camera::Kind::Perspective ? normalized(camera_.position - point_um) : -axis_;
}

std::optional<CameraConnection> CameraRays::connect(Vec3 point_um, Rng& rng) const {
    const double na = camera_.numerical_aperture;
    const auto [a, b] = na > 0 ? on_disc(rng) : OnDisc{};
    const double depth = dot(point_um - camera_.position, axis_);
    if (depth <= 0) return std::nullopt;
    CameraConnection result;
    const double pixel_area = pixel_um_ * pixel_um_;
    if (camera_.kind == Camera::Kind::Perspective) {
        const double lens_radius = camera_.focus_um * na / std::sqrt(1 - na * na);
        const Vec3 lens = camera_.position + (a * lens_radius) * right_ + (b * lens_radius) * up_;
        const Vec3 away = point_um - lens;
        result.distance_um = length(away);
        result.to_camera = (-1 / result.distance_um) * away;
        const double cosine = depth / result.distance_um;
        if (!find_pixel(lens + (camera_.focus_um / depth) * away + blur(rng), result)) return std::nullopt;
        // A solid angle dw seen from the lens covers focus^2 / cosine^3 dw of the focal plane.
        result.factor = camera_.focus_um * camera_.focus_um /
                        (cosine * cosine * cosine * pixel_area * result.distance_um * result.distance_um);
        return result;
    }
    const double cosine = std::sqrt(1 - na * na * (a * a + b * b));
    const Vec3 direction = (a * na) * right_ + (b * na) * up_ + cosine * axis_;
    result.to_camera = -direction;
    result.distance_um = depth / cosine;
    const Vec3 sharp = point_um + ((camera_.focus_um - depth) / cosine) * direction + blur(rng);
    if (!find_pixel(sharp, result)) return std::nullopt;
    result.factor = 1 / (cosine * pixel_area);
    return result;
}

std::optional<CameraConnection> CameraRays::catch_ray(const Ray& ray) const {
    const double na = camera_.numerical_aperture;
    const double cosine = -dot(ray.direction, axis_);
    const double depth = dot(ray.origin - camera_.position, axis_);
    if (camera_.kind != Camera::Kind::Telecentric || depth <= 0 || cosine <= 0) return std::nullopt;
    if (1 - cosine * cosine >= na * na) return std::nullopt;
    CameraConnection result;
    result.to_camera = ray.direction;
    result.distance_um = depth / cosine;
    if (!find_pixel(ray.at((depth - camera_.focus_um) / cosine), result)) return std::nullopt;
    result.factor = 1 / (pixel_um_ * pixel_um_ * std::numbers::pi * na * na);
    return result;
}

}  // namespace fluovox
