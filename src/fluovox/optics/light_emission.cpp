#include "fluovox/optics/light_emission.h"

#include "fluovox/optics/light_sampling.h"
#include "fluovox/spectral/photons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

constexpr double kPi = std::numbers::pi;

struct Pair {
    double x = 0, y = 0;
};

// Two standard normal numbers (Box & Muller 1958).
Pair normal_pair(Rng& rng) {
    const double r = std::sqrt(2 * rng.exponential());
    const double angle = 2 * kPi * rng.uniform();
    return {r * std::cos(angle), r * std::sin(angle)};
}

// Standard deviation of the slope of rays whose slope at 1/e^2 is that of the numerical aperture.
double slope_sigma(double numerical_aperture) {
    return 0.5 * numerical_aperture / std::sqrt(1 - numerical_aperture * numerical_aperture);
}

// A direction to the side of `normal`, with density cosine / pi.
Vec3 sample_lambertian(Vec3 normal, Rng& rng) {
    const double r = std::sqrt(rng.uniform());
    const double angle = 2 * kPi * rng.uniform();
    return Frame::around(normal).to_world({r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r * r)});
}

// From the waist back (or on) to the plane where the light starts.
Ray from_start(Vec3 at_waist, Vec3 slopes, Vec3 axis, Vec3 waist, Vec3 position) {
    const double z = dot(position - waist, axis);
    return {at_waist + z * slopes, normalized(slopes)};
}

Ray emission(const SheetLight& sheet, const Bounds& /*around*/, Rng& rng) {
    const Vec3 sideways = cross(sheet.direction, sheet.normal);
    const double x = sheet.width_um * (rng.uniform() - 0.5);
    double y = sheet.thickness_um * (rng.uniform() - 0.5);
    double slope = 0;
    if (sheet.profile == BeamProfile::Gaussian) {
        const Pair numbers = normal_pair(rng);
        y = 0.25 * sheet.thickness_um * numbers.x;  // thickness: full width at 1/e^2
        slope = slope_sigma(sheet.numerical_aperture) * numbers.y;
    }
    return from_start(sheet.waist + x * sideways + y * sheet.normal, sheet.direction + slope * sheet.normal,
                      sheet.direction, sheet.waist, sheet.position);
}

Ray emission(const BeamLight& beam, const Bounds& /*around*/, Rng& rng) {
    const Frame axes = Frame::around(beam.direction);
    Pair place;
    Pair slope;
    if (beam.profile == BeamProfile::Box) {
        const double r = beam.radius_um * std::sqrt(rng.uniform());
        const double angle = 2 * kPi * rng.uniform();
        place = {r * std::cos(angle), r * std::sin(angle)};
    } else {
        place = normal_pair(rng);
        place = {0.5 * beam.radius_um * place.x, 0.5 * beam.radius_um * place.y};
        if (beam.numerical_aperture > 0) {
            const double sigma = slope_sigma(beam.numerical_aperture);
            slope = normal_pair(rng);
            slope = {sigma * slope.x, sigma * slope.y};
        }
    }
    return from_start(beam.waist + axes.to_world({place.x, place.y, 0}), axes.to_world({slope.x, slope.y, 1}),
                      beam.direction, beam.waist, beam.position);
}

Ray emission(const PointLight& point, const Bounds& /*around*/, Rng& rng) {
    const double z = 1 - 2 * rng.uniform();
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    const double angle = 2 * kPi * rng.uniform();
    return {point.position, {r * std::cos(angle), r * std::sin(angle), z}};
}

Ray emission(const RectangleLight& light, const Bounds& /*around*/, Rng& rng) {
    const double x = light.width_um * (rng.uniform() - 0.5);
    const double y = light.height_um * (rng.uniform() - 0.5);
    return {light.center + x * cross(light.up, light.normal) + y * light.up, sample_lambertian(light.normal, rng)};
}

double area(const Bounds& box) {
    const Vec3 s = box.size();
    return 2 * (s.x * s.y + s.y * s.z + s.z * s.x);
}

Ray emission(const UniformLight& /*light*/, const Bounds& around, Rng& rng) {
    const Vec3 s = around.size();
    const std::array<double, 3> areas = {s.y * s.z, s.z * s.x, s.x * s.y};
    double u = rng.uniform() * (areas[0] + areas[1] + areas[2]);
    int axis = 0;
    while (axis < 2 && u >= areas[static_cast<std::size_t>(axis)]) {
        u -= areas[static_cast<std::size_t>(axis)];
        ++axis;
    }
    const bool low = rng.uniform() < 0.5;
    Vec3 place = around.min + Vec3{rng.uniform() * s.x, rng.uniform() * s.y, rng.uniform() * s.z};
    place[axis] = low ? around.min[axis] : around.max[axis];
    Vec3 inward;
    inward[axis] = low ? 1 : -1;
    return {place, sample_lambertian(inward, rng)};
}

// Photons per second of the continuous part. The energy is linear between its knots, so this is exact.
double continuous_photons(const Light& light) {
    const Spectrum& energy = light.spectrum.energy_per_nm;
    if (energy.empty()) return 0;
    const Spectrum rising({energy.first_nm(), energy.last_nm()}, {energy.first_nm(), energy.last_nm()});
    const double at_nm = energy.peak_nm();
    const double there = energy(at_nm);
    if (there <= 0) return 0;
    return continuous_photons_per_nm(light, at_nm) / (there * at_nm) * integral_of_product(energy, rising);
}

}  // namespace

Ray sample_emission(const Light& light, const Bounds& around, Rng& rng) {
    return std::visit([&](const auto& shape) { return emission(shape, around, rng); }, light.shape);
}

double emitted_photons(const Light& light, const Bounds& around) {
    double photons = continuous_photons(light);
    for (const LightSpectrum::Line& line : light.spectrum.lines)
        photons += line_photons(light, line);
    if (!std::holds_alternative<UniformLight>(light.shape) || photons == 0) return photons;
    return photons * kPi * area(around);
}

double sample_emitted_wavelength(const Light& light, Rng& rng) {
    double all = continuous_photons(light);
    const double continuous = all;
    for (const LightSpectrum::Line& line : light.spectrum.lines)
        all += line_photons(light, line);
    double u = rng.uniform() * all;
    if (u < continuous) {
        const Spectrum& energy = light.spectrum.energy_per_nm;
        for (;;) {  // drawn by energy, taken by photons
            const double nm = energy.sample(rng.uniform());
            if (rng.uniform() * energy.last_nm() <= nm) return nm;
        }
    }
    u -= continuous;
    double nm = 0;
    for (const LightSpectrum::Line& line : light.spectrum.lines) {
        if (line.share <= 0) continue;
        nm = line.wavelength_nm;
        u -= line_photons(light, line);
        if (u < 0) break;
    }
    return nm;
}

}  // namespace fluovox
