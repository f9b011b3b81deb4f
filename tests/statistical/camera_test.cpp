// Camera rays: each pixel's area evenly, the aperture evenly in projected solid angle, and the picture the right way
// up.

#include "fluovox/optics/camera_ray.h"

#include "scene_kit.h"
#include "statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace fluovox {
namespace {

using testing::kFiveSigma;
using testing::kolmogorov_smirnov_p;

Camera oblique(Camera::Kind kind, double numerical_aperture) {
    Camera camera = testing::one_pixel({30, -20, 90}, {5, 8, -10}, {0.2, 1, 0.1}, 60, numerical_aperture);
    camera.kind = kind;
    camera.fov_rad = 0.6;
    camera.width = 6;
    camera.height = 4;
    return camera;
}

struct Axes {
    Vec3 forward, right, up;

    explicit Axes(const Camera& camera)
        : forward(normalized(camera.target - camera.position)),
          right(normalized(cross(forward, camera.up))),
          up(cross(right, forward)) {}
};

double uniform_cdf(double u) {
    return std::fmin(1, std::fmax(0, u));
}

// Place in the plane of focus, in pixels from the top left corner of the picture.
Vec3 in_pixels(const Camera& camera, const Ray& ray) {
    const Axes axes(camera);
    const double t =
        (camera.focus_um - dot(ray.origin - camera.position, axes.forward)) / dot(ray.direction, axes.forward);
    const Vec3 place = ray.at(t) - camera.position;
    const double height = camera.kind == Camera::Kind::Telecentric
                              ? camera.field_um
                              : 2 * camera.focus_um * std::tan(0.5 * camera.fov_rad);
    const double pixel = height / camera.height;
    return {dot(place, axes.right) / pixel + 0.5 * camera.width, 0.5 * camera.height - dot(place, axes.up) / pixel, 0};
}

class CameraKinds : public ::testing::TestWithParam<Camera::Kind> {};

TEST_P(CameraKinds, EachPixelSeesItsOwnAreaInFocusEvenly) {
    for (const double numerical_aperture : {0.0, 0.5}) {
        const Camera camera = oblique(GetParam(), numerical_aperture);
        const CameraRays rays(camera);
        Rng rng(31, 0, 0);
        std::vector<double> across;
        std::vector<double> down;
        for (int n = 0; n < 50000; ++n) {
            const int x = n % 6;
            const int y = (n / 6) % 4;
            const Vec3 place = in_pixels(camera, rays.sample(x, y, rng));
            across.push_back(place.x - x);
            down.push_back(place.y - y);
        }
        EXPECT_GT(kolmogorov_smirnov_p(across, uniform_cdf), kFiveSigma);
        EXPECT_GT(kolmogorov_smirnov_p(down, uniform_cdf), kFiveSigma);
        EXPECT_LT(kolmogorov_smirnov_p(down, [](double u) { return uniform_cdf(u + 0.03); }), kFiveSigma);
    }
}

INSTANTIATE_TEST_SUITE_P(Both, CameraKinds, ::testing::Values(Camera::Kind::Telecentric, Camera::Kind::Perspective));

TEST(Camera, TelecentricApertureIsEvenInProjectedSolidAngle) {
    const Camera camera = oblique(Camera::Kind::Telecentric, 0.5);
    const Axes axes(camera);
    const CameraRays rays(camera);
    Rng rng(32, 0, 0);
    std::vector<double> radius_squared;
    std::vector<double> azimuth;
    for (int n = 0; n < 100000; ++n) {
        const Ray ray = rays.sample(2, 1, rng);
        EXPECT_NEAR(length(ray.direction), 1, 1e-12);
        EXPECT_NEAR(dot(ray.origin - camera.position, axes.forward), 0, 1e-9);  // rays start in the camera's plane
        const double a = dot(ray.direction, axes.right);
        const double b = dot(ray.direction, axes.up);
        radius_squared.push_back((a * a + b * b) / 0.25);
        azimuth.push_back(0.5 + std::atan2(b, a) / (2 * std::numbers::pi));
    }
    EXPECT_GT(kolmogorov_smirnov_p(radius_squared, uniform_cdf), kFiveSigma);
    EXPECT_GT(kolmogorov_smirnov_p(azimuth, uniform_cdf), kFiveSigma);
    // Evenly over the solid angle, without the cosine, would be another distribution.
    const double edge = 1 - std::sqrt(0.75);
    const auto unweighted = [&](double u) { return (1 - std::sqrt(1 - 0.25 * uniform_cdf(u))) / edge; };
    EXPECT_LT(kolmogorov_smirnov_p(radius_squared, unweighted), kFiveSigma);
}

TEST(Camera, WithoutApertureTelecentricRaysAreParallelAndPerspectiveRaysMeet) {
    Rng rng(33, 0, 0);
    const Camera flat = oblique(Camera::Kind::Telecentric, 0);
    const Camera wide = oblique(Camera::Kind::Perspective, 0);
    for (int n = 0; n < 100; ++n) {
        EXPECT_NEAR(dot(CameraRays(flat).sample(n % 6, n % 4, rng).direction, Axes(flat).forward), 1, 1e-12);
        EXPECT_NEAR(length(CameraRays(wide).sample(n % 6, n % 4, rng).origin - wide.position), 0, 1e-12);
    }
}

TEST(Camera, ImageRunsRightAlongDirectionCrossUpAndItsFirstRowIsOnTop) {
    Camera camera = testing::one_pixel({0, 0, 100}, {0, 0, 0}, {0, 1, 0}, 40);
    camera.width = camera.height = 2;
    const CameraRays rays(camera);
    Rng rng(34, 0, 0);
    // Looking down along -z with y up, x of the world runs to the right.
    const Vec3 top_left = rays.sample(0, 0, rng).origin;
    EXPECT_LT(top_left.x, 0);
    EXPECT_GT(top_left.y, 0);
    const Vec3 bottom_right = rays.sample(1, 1, rng).origin;
    EXPECT_GT(bottom_right.x, 0);
    EXPECT_LT(bottom_right.y, 0);
}

}  // namespace
}  // namespace fluovox
