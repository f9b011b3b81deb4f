#include "fluovox/optics/camera_ray.h"

#include <cmath>
#include <numbers>

namespace fluovox {

CameraRays::CameraRays(const Camera& camera)
    : camera_(camera),
      axis_(normalized(camera.target - camera.position)),
      right_(normalized(cross(axis_, camera.up))),
      up_(cross(right_, axis_)) {
    const double height = camera.kind == Camera::Kind::Telecentric
                              ? camera.field_um
                              : 2 * camera.focus_um * std::tan(0.5 * camera.fov_rad);
    pixel_um_ = height / camera.height;
}

Ray CameraRays::sample(int x, int y, Rng& rng) const {
    const double across = (x + rng.uniform() - 0.5 * camera_.width) * pixel_um_;
    const double upward = (0.5 * camera_.height - y - rng.uniform()) * pixel_um_;
    const Vec3 sharp = camera_.position + camera_.focus_um * axis_ + across * right_ + upward * up_;
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

}  // namespace fluovox
