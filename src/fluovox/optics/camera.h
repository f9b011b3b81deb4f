#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"

#include <cmath>

namespace fluovox {

/// Where the image is taken from. The image's x runs along (target - position) x up, row 0 is on top.
/// Rays start in the plane through `position`.
struct Camera {
    enum class Kind { Telecentric, Perspective };

    Kind kind = Kind::Telecentric;
    Vec3 position, target, up = {0, 1, 0};
    double focus_um = 0;  ///< distance along the axis from `position` to what is sharp
    double field_um = 0;  ///< telecentric: height seen
    double fov_rad = 0;   ///< perspective: full vertical angle
    int width = 0, height = 0;
    double exposure_s = 0;          ///< of one image; 0: not said
    double numerical_aperture = 0;  ///< n sin(theta) at `position`; 0: everything is sharp
    double immersion_index = 1;     ///< what the aperture that was given has been divided by
    double blur_um = 0;             ///< full width at half maximum of a Gaussian blur of the image, on the focal plane
};

/// Side of a pixel where it is sharp, in micrometres.
inline double pixel_um(const Camera& camera) {
    const double height_um = camera.kind == Camera::Kind::Telecentric
                                 ? camera.field_um
                                 : 2 * camera.focus_um * std::tan(0.5 * camera.fov_rad);
    return height_um / camera.height;
}

}  // namespace fluovox
