#pragma once

#include "fluovox/core/vec.h"
#include "fluovox/spectral/spectrum.h"

#include <optional>
#include <variant>
#include <vector>

namespace fluovox {

/// What a light sends out over the spectrum, as shares of its power: laser lines plus a continuous part.
/// The lines' shares and the integral of `energy_per_nm` add up to one.
struct LightSpectrum {
    struct Line {
        double wavelength_nm = 0;
        double share = 0;
    };
    std::vector<Line> lines;
    Spectrum energy_per_nm;
};

enum class BeamProfile { Gaussian, Box };

/// A sheet of light. It starts in the plane through `position` across `direction` and goes on for ever.
/// Thickness is along `normal`, width along direction x normal (hard-edged). Gaussian: `thickness_um` is the full
/// width where the irradiance is 1/e^2; box: the full width. Collimated unless `numerical_aperture` > 0:
/// then the waist is at `waist` and each ray is Gaussian in position times Gaussian in slope.
struct SheetLight {
    Vec3 position, direction, normal;
    double width_um = 0, thickness_um = 0;
    BeamProfile profile = BeamProfile::Gaussian;
    bool two_sided = false;  ///< half the power comes from the mirror image of the sheet about its waist
    double numerical_aperture = 0;
    Vec3 waist;
    std::vector<double> pivots_rad;  ///< turned about `normal` through the waist, by each of these in turn; none: 0
};

/// A round beam; as a sheet, with `radius_um` to 1/e^2 (gaussian) or to the hard edge (box). Radius 0: a pencil.
struct BeamLight {
    Vec3 position, direction;
    double radius_um = 0;
    BeamProfile profile = BeamProfile::Gaussian;
    double numerical_aperture = 0;
    Vec3 waist;
};

/// Shines the same in all directions from one point.
struct PointLight {
    Vec3 position;
};

/// One-sided Lambertian rectangle; it shines to the side its normal points to.
struct RectangleLight {
    Vec3 center, normal, up;
    double width_um = 0, height_um = 0;  ///< along up x normal, and along up
};

/// The same radiance from every direction, from infinity.
struct UniformLight {
    double radiance_W_per_m2_sr = 0;  ///< over the whole spectrum
};

struct Light {
    std::variant<SheetLight, BeamLight, PointLight, RectangleLight, UniformLight> shape;
    LightSpectrum spectrum;
    double power_W = 0;  ///< all that leaves the light; 0 for UniformLight
};

}  // namespace fluovox
