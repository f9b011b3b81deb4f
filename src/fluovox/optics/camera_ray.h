#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/optics/camera.h"

namespace fluovox {

/// A ray from the camera through a pixel, whose average radiance is the pixel's value: uniform over the pixel's area
/// on the focal plane and, telecentric, uniform in projected solid angle over the aperture.
/// With a numerical aperture the perspective camera is a thin lens, averaged over the lens' area.
class CameraRays {
public:
    explicit CameraRays(const Camera& camera);

    /// Column `x`, row `y` (0 on top).
    Ray sample(int x, int y, Rng& rng) const;

    Vec3 axis() const { return axis_; }

private:
    Camera camera_;
    Vec3 axis_, right_, up_;
    double pixel_um_ = 0;  // on the focal plane
};

}  // namespace fluovox
