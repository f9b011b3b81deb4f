#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/optics/camera.h"

#include <optional>

namespace fluovox {

/// How the camera sees one point in space.
struct CameraConnection {
    int x = 0, y = 0;        ///< pixel: column, and row from the top
    Vec3 to_camera;          ///< unit direction from the point
    double distance_um = 0;  ///< to where the camera's rays start
    double factor = 0;       ///< pixel value per unit of power emitted per steradian towards the camera, 1/um^2
};

/// A ray from the camera through a pixel, whose average radiance is the pixel's value: uniform over the pixel's area
/// on the focal plane and, telecentric, uniform in projected solid angle over the aperture.
/// With `blur_um` the place on the focal plane is shifted at random, which blurs the image of everything but collimated
/// light that shines into the camera.
/// With a numerical aperture the perspective camera is a thin lens, averaged over the lens' area.
class CameraRays {
public:
    explicit CameraRays(const Camera& camera);

    /// Column `x`, row `y` (0 on top).
    Ray sample(int x, int y, Rng& rng) const;

    /// Connects a point to a pixel through a point of the aperture that is drawn; nothing when it falls beside the film
    /// or is behind the camera. On average over the draws the pixel gets what `sample` would find there.
    std::optional<CameraConnection> connect(Vec3 point_um, Rng& rng) const;

    /// The pixel that light on this ray falls into, for cameras that look at collimated light: nothing when it does not
    /// go through the aperture. `factor` is the pixel value per unit of power. Telecentric cameras only.
    std::optional<CameraConnection> catch_ray(const Ray& ray) const;

    /// About how many pixels the image of a point covers, being out of focus or blurred; at least 1.
    double pixels_covered(Vec3 point_um) const;

    /// Unit vector from a point to the middle of the aperture.
    Vec3 to_camera(Vec3 point_um) const;

private:
    bool find_pixel(Vec3 sharp, CameraConnection& connection) const;
    Vec3 shift(Rng& rng) const;
    // Without blur no random numbers are used.
    Vec3 blur(Rng& rng) const { return blur_sigma_ == 0 ? Vec3{} : shift(rng); }

    Camera camera_;
    Vec3 axis_, right_, up_;
    Vec3 middle_;          // of the film, on the focal plane
    double pixel_um_ = 0;  // on the focal plane
    Vec3 pixel_right_, pixel_up_;
    double blur_sigma_ = 0;  // standard deviation on the focal plane, um
};

}  // namespace fluovox
