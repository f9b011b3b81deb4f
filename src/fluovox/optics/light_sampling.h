#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/optics/light.h"

#include <optional>

namespace fluovox {

/// Light that reaches a point without being scattered, drawn from all that does.
struct LightSample {
    Vec3 to_light;               ///< unit direction from the point back along the light
    double distance_um = 0;      ///< to where the light starts
    double fluence_per_um2 = 0;  ///< fluence rate it brings, per unit of power emitted, in a vacuum; over the density
    double pdf_per_sr = 0;       ///< density of `to_light`; zero where the light has a single direction there
};

/// Draws how a light shines on `position_um`; nothing where it does not, or where it has no place (uniform light).
/// `u1`, `u2` uniform in [0, 1). Averages over the draws to the fluence rate per unit of emitted power.
std::optional<LightSample> sample_light(const Light& light, Vec3 position_um, double u1, double u2);

/// The stretch of a ray where a light shines on it, as a density along the ray to draw points from: about the
/// beam's own profile for sheets and beams, equiangular for points. Always right as a density; how well it fits the
/// light (focused sheets are taken at one width) only matters for noise. Equiangular: Kulla & Fajardo, Comput. Graph.
/// Forum 31 (2012) 1519.
class LitSection {
public:
    /// `domain`: the part of the ray where a point is of any use.
    LitSection(const Light& light, const Ray& ray, Interval domain);

    /// False where the light does not reach the ray, or has no such density (then `pdf` is zero).
    explicit operator bool() const { return kind_ != Kind::None; }
    double sample(double u) const;
    double pdf(double t_um) const;

private:
    enum class Kind { None, Uniform, Bell, Equiangular };

    void set(const SheetLight& sheet, const Ray& ray);
    void set(const BeamLight& beam, const Ray& ray);
    void set(const PointLight& point, const Ray& ray);
    void set(const RectangleLight& /*light*/, const Ray& /*ray*/) {}
    void set(const UniformLight& /*light*/, const Ray& /*ray*/) {}
    void set_bell(double center, double sigma);
    void set_uniform();

    Kind kind_ = Kind::None;
    Interval lit_;
    double center_ = 0, scale_ = 0;  // of the bell; point of closest approach and its distance
    double low_ = 0, high_ = 0;      // cumulative probability or angle at the two ends
};

/// Where `ray` meets the shining side of a rectangle, micrometres; nothing when it misses.
std::optional<double> hit_rectangle(const RectangleLight& rectangle, const Ray& ray);

/// Radiance of a rectangle per unit of its power, 1/(um^2 sr).
double rectangle_radiance(const RectangleLight& rectangle);

/// Density per steradian with which `sample_light` draws the direction from `position_um` to a point of the rectangle
/// at `distance_um` along the unit vector `to_light`.
double rectangle_pdf(const RectangleLight& rectangle, Vec3 to_light, double distance_um);

/// True for a light without width: no path traced from the camera can meet it.
bool is_pencil(const Light& light);

/// Photons per second of a laser line, or per second and nanometre of the continuous part, that leave the light
/// (uniform light: that pass per um^2 and sr).
double line_photons(const Light& light, const LightSpectrum::Line& line);
double continuous_photons_per_nm(const Light& light, double wavelength_nm);

}  // namespace fluovox
