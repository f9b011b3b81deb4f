#include "fluovox/optics/light_sampling.h"

#include "fluovox/spectral/photons.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace fluovox {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kFar = std::numeric_limits<double>::infinity();

double normal_density(double x, double sigma) {
    return std::exp(-0.5 * x * x / (sigma * sigma)) / (sigma * std::sqrt(2 * kPi));
}

// Standard normal numbers from two uniform ones (Box & Muller 1958).
Vec3 normal_pair(double u1, double u2) {
    const double r = std::sqrt(-2 * std::log(1 - u1));
    return {r * std::cos(2 * kPi * u2), r * std::sin(2 * kPi * u2), 0};
}

// Standard deviation of the slope of rays whose slope at 1/e^2 is that of the numerical aperture.
double slope_sigma(double numerical_aperture) {
    return 0.5 * numerical_aperture / std::sqrt(1 - numerical_aperture * numerical_aperture);
}

// Rays that are Gaussian in position at the waist times Gaussian in slope: at a distance z from the waist the place x
// is Gaussian too, and so is the slope of those rays that pass there.
struct GaussianBundle {
    double sigma_waist = 0, sigma_slope = 0;

    double sigma_at(double z) const { return std::sqrt(sigma_waist * sigma_waist + z * z * sigma_slope * sigma_slope); }
    double slope_at(double x, double z, double normal_number) const {
        if (sigma_slope == 0) return 0;
        const double sigma = sigma_at(z);
        const double mean = x * z * sigma_slope * sigma_slope / (sigma * sigma);
        return mean + normal_number * sigma_waist * sigma_slope / sigma;
    }
};

GaussianBundle bundle(const SheetLight& sheet) {
    return {0.25 * sheet.thickness_um, slope_sigma(sheet.numerical_aperture)};  // thickness: full width at 1/e^2
}
GaussianBundle bundle(const BeamLight& beam) {
    return {0.5 * beam.radius_um, slope_sigma(beam.numerical_aperture)};
}

Vec3 width_axis(const SheetLight& sheet) {
    return cross(sheet.direction, sheet.normal);
}

std::optional<LightSample> sample(const SheetLight& sheet, Vec3 position, double u1, double u2) {
    const Vec3 from_waist = position - sheet.waist;
    const double along = dot(position - sheet.position, sheet.direction);
    if (along < 0 || std::abs(dot(from_waist, width_axis(sheet))) > 0.5 * sheet.width_um) return std::nullopt;
    const double across = dot(from_waist, sheet.normal);
    if (sheet.profile == BeamProfile::Box) {
        if (std::abs(across) > 0.5 * sheet.thickness_um) return std::nullopt;
        return LightSample{-sheet.direction, along, 1 / (sheet.width_um * sheet.thickness_um), 0};
    }
    const GaussianBundle rays = bundle(sheet);
    const double z = dot(from_waist, sheet.direction);
    const double slope = rays.slope_at(across, z, normal_pair(u1, u2).x);
    const double stretch = std::sqrt(1 + slope * slope);  // 1/cosine to the axis: path length, and fluence over flux
    const double density = normal_density(across, rays.sigma_at(z)) / sheet.width_um;
    const Vec3 flight = (1 / stretch) * (sheet.direction + slope * sheet.normal);
    return LightSample{-flight, along * stretch, density * stretch, 0};
}

std::optional<LightSample> sample(const BeamLight& beam, Vec3 position, double u1, double u2) {
    const Vec3 from_waist = position - beam.waist;
    const double along = dot(position - beam.position, beam.direction);
    if (along < 0) return std::nullopt;
    const double z = dot(from_waist, beam.direction);
    const Vec3 across = from_waist - z * beam.direction;
    if (beam.profile == BeamProfile::Box) {
        if (length_squared(across) > beam.radius_um * beam.radius_um) return std::nullopt;
        return LightSample{-beam.direction, along, 1 / (kPi * beam.radius_um * beam.radius_um), 0};
    }
    const GaussianBundle rays = bundle(beam);
    const Frame axes = Frame::around(beam.direction);
    const Vec3 place = axes.to_local(across);
    const Vec3 numbers = normal_pair(u1, u2);
    const Vec3 slope = {rays.slope_at(place.x, z, numbers.x), rays.slope_at(place.y, z, numbers.y), 1};
    const double stretch = length(slope);
    const double sigma = rays.sigma_at(z);
    const double density = normal_density(place.x, sigma) * normal_density(place.y, sigma);
    return LightSample{-normalized(axes.to_world(slope)), along * stretch, density * stretch, 0};
}

std::optional<LightSample> sample(const PointLight& point, Vec3 position, double /*u1*/, double /*u2*/) {
    const Vec3 to_light = point.position - position;
    const double squared = length_squared(to_light);
    if (squared == 0) return std::nullopt;
    const double distance = std::sqrt(squared);
    return LightSample{(1 / distance) * to_light, distance, 1 / (4 * kPi * squared), 0};
}

std::optional<LightSample> sample(const RectangleLight& light, Vec3 position, double u1, double u2) {
    const Vec3 right = cross(light.up, light.normal);
    const Vec3 place = light.center + (light.width_um * (u1 - 0.5)) * right + (light.height_um * (u2 - 0.5)) * light.up;
    const Vec3 to_light = place - position;
    const double squared = length_squared(to_light);
    if (squared == 0) return std::nullopt;
    const double distance = std::sqrt(squared);
    const Vec3 direction = (1 / distance) * to_light;
    const double cosine = -dot(direction, light.normal);
    if (cosine <= 0) return std::nullopt;
    return LightSample{direction, distance, cosine / (kPi * squared), rectangle_pdf(light, direction, distance)};
}

std::optional<LightSample> sample(const UniformLight& /*light*/, Vec3 /*position*/, double /*u1*/, double /*u2*/) {
    return std::nullopt;
}

// Where `low <= value + t * slope <= high`, within `span`.
Interval clipped(Interval span, double value, double slope, double low, double high) {
    if (slope == 0) return value >= low && value <= high ? span : Interval{0, 0};
    const double a = (low - value) / slope;
    const double b = (high - value) / slope;
    return {std::max(span.begin, std::min(a, b)), std::min(span.end, std::max(a, b))};
}

// The logistic distribution stands in for the normal one: where points are drawn by it in place of the normal profile
// of a beam, the variance is 1.6 % more, its tails cover the beam's, and it takes no special functions.
constexpr double kLogisticScale = 0.6;  // of the normal's standard deviation

double logistic_cdf(double x) {
    return 1 / (1 + std::exp(-x));
}

}  // namespace

std::optional<LightSample> sample_light(const Light& light, Vec3 position_um, double u1, double u2) {
    return std::visit([&](const auto& shape) { return sample(shape, position_um, u1, u2); }, light.shape);
}

LitSection::LitSection(const Light& light, const Ray& ray, Interval domain) : lit_(domain) {
    if (domain.empty()) return;
    std::visit([&](const auto& shape) { set(shape, ray); }, light.shape);
}

void LitSection::set_uniform() {
    if (!lit_.empty() && std::isfinite(lit_.begin) && std::isfinite(lit_.end)) kind_ = Kind::Uniform;
}

void LitSection::set_bell(double center, double sigma) {
    if (lit_.empty()) return;
    if (!(sigma < 1e3 * lit_.length())) return set_uniform();  // the ray runs along the light: as good as flat
    center_ = center;
    scale_ = kLogisticScale * sigma;
    low_ = logistic_cdf((lit_.begin - center) / scale_);
    high_ = logistic_cdf((lit_.end - center) / scale_);
    // Farther out in the tail the inversion would lose its digits, and there is no light to speak of.
    constexpr double kLeast = 1e-6;
    if (high_ - low_ > kLeast) kind_ = Kind::Bell;
}

void LitSection::set(const SheetLight& sheet, const Ray& ray) {
    const Vec3 from_waist = ray.origin - sheet.waist;
    const Vec3 sideways = width_axis(sheet);
    lit_ =
        clipped(lit_, dot(ray.origin - sheet.position, sheet.direction), dot(ray.direction, sheet.direction), 0, kFar);
    lit_ = clipped(lit_, dot(from_waist, sideways), dot(ray.direction, sideways), -0.5 * sheet.width_um,
                   0.5 * sheet.width_um);
    const double value = dot(from_waist, sheet.normal);
    const double slope = dot(ray.direction, sheet.normal);
    if (sheet.profile == BeamProfile::Box) {
        lit_ = clipped(lit_, value, slope, -0.5 * sheet.thickness_um, 0.5 * sheet.thickness_um);
        return set_uniform();
    }
    if (slope == 0) return set_uniform();
    const double crossing = -value / slope;
    const double z = dot(ray.at(crossing) - sheet.waist, sheet.direction);
    set_bell(crossing, bundle(sheet).sigma_at(z) / std::abs(slope));
}

void LitSection::set(const BeamLight& beam, const Ray& ray) {
    lit_ = clipped(lit_, dot(ray.origin - beam.position, beam.direction), dot(ray.direction, beam.direction), 0, kFar);
    const double along = dot(ray.direction, beam.direction);
    const Vec3 across = ray.direction - along * beam.direction;
    const double sine_squared = length_squared(across);
    if (sine_squared < 1e-12) return set_uniform();
    const Vec3 from_axis = (ray.origin - beam.waist) - dot(ray.origin - beam.waist, beam.direction) * beam.direction;
    const double closest = -dot(from_axis, across) / sine_squared;
    if (beam.profile == BeamProfile::Box) {
        const double miss = length_squared(from_axis + closest * across);
        const double half_squared = (beam.radius_um * beam.radius_um - miss) / sine_squared;
        if (half_squared <= 0) return;
        const double half = std::sqrt(half_squared);
        lit_ = {std::max(lit_.begin, closest - half), std::min(lit_.end, closest + half)};
        return set_uniform();
    }
    const double z = dot(ray.at(closest) - beam.waist, beam.direction);
    set_bell(closest, bundle(beam).sigma_at(z) / std::sqrt(sine_squared));
}

void LitSection::set(const PointLight& point, const Ray& ray) {
    const Vec3 to_point = point.position - ray.origin;
    center_ = dot(to_point, ray.direction);
    scale_ = std::max(length(to_point - center_ * ray.direction), 1e-9);
    low_ = std::atan((lit_.begin - center_) / scale_);
    high_ = std::atan((lit_.end - center_) / scale_);
    if (high_ > low_) kind_ = Kind::Equiangular;
}

double LitSection::sample(double u) const {
    const double mixed = low_ + u * (high_ - low_);
    switch (kind_) {
        case Kind::None:
            return 0;
        case Kind::Uniform:
            return lit_.begin + u * lit_.length();
        case Kind::Bell: {
            const double p = std::clamp(mixed, 1e-15, 1 - 1e-15);
            const double t = center_ + scale_ * std::log(p / (1 - p));
            return std::clamp(t, lit_.begin, lit_.end);
        }
        case Kind::Equiangular:
            return std::clamp(center_ + scale_ * std::tan(mixed), lit_.begin, lit_.end);
    }
    return 0;
}

double LitSection::pdf(double t_um) const {
    if (t_um < lit_.begin || t_um > lit_.end) return 0;
    const double x = t_um - center_;
    switch (kind_) {
        case Kind::None:
            return 0;
        case Kind::Uniform:
            return 1 / lit_.length();
        case Kind::Bell: {
            const double e = std::exp(-std::abs(x) / scale_);
            return e / (scale_ * (1 + e) * (1 + e) * (high_ - low_));
        }
        case Kind::Equiangular:
            return scale_ / ((high_ - low_) * (scale_ * scale_ + x * x));
    }
    return 0;
}

std::optional<double> hit_rectangle(const RectangleLight& rectangle, const Ray& ray) {
    const double cosine = dot(ray.direction, rectangle.normal);
    if (cosine >= 0) return std::nullopt;
    const double t = dot(rectangle.center - ray.origin, rectangle.normal) / cosine;
    if (!(t > 0)) return std::nullopt;
    const Vec3 place = ray.at(t) - rectangle.center;
    if (std::abs(dot(place, rectangle.up)) > 0.5 * rectangle.height_um) return std::nullopt;
    if (std::abs(dot(place, cross(rectangle.up, rectangle.normal))) > 0.5 * rectangle.width_um) return std::nullopt;
    return t;
}

double rectangle_radiance(const RectangleLight& rectangle) {
    return 1 / (kPi * rectangle.width_um * rectangle.height_um);
}

double rectangle_pdf(const RectangleLight& rectangle, Vec3 to_light, double distance_um) {
    const double cosine = -dot(to_light, rectangle.normal);
    if (cosine <= 0) return 0;
    return distance_um * distance_um / (cosine * rectangle.width_um * rectangle.height_um);
}

bool is_pencil(const Light& light) {
    if (const auto* sheet = std::get_if<SheetLight>(&light.shape))
        return sheet->thickness_um == 0 || sheet->width_um == 0;
    if (const auto* beam = std::get_if<BeamLight>(&light.shape)) return beam->radius_um == 0;
    return false;
}

namespace {

double power(const Light& light) {
    constexpr double m2_per_um2 = 1e-12;
    const auto* uniform = std::get_if<UniformLight>(&light.shape);
    return uniform != nullptr ? uniform->radiance_W_per_m2_sr * m2_per_um2 : light.power_W;
}

}  // namespace

double line_photons(const Light& light, const LightSpectrum::Line& line) {
    return photons_per_second(power(light) * line.share, line.wavelength_nm);
}

double continuous_photons_per_nm(const Light& light, double wavelength_nm) {
    return photons_per_second(power(light) * light.spectrum.energy_per_nm(wavelength_nm), wavelength_nm);
}

}  // namespace fluovox
