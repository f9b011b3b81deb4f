#include "slow_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace fluovox::reference {
namespace {

constexpr double kPi = std::numbers::pi;

struct Coefficients {
    double scattering = 0, absorption = 0, anisotropy = 0;
};

// Of one medium where its amount is one.
Coefficients coefficients(const Scene& scene, const SceneMedium& medium, double nm) {
    if (medium.dye >= 0) {
        const Dye& dye = scene.dyes[static_cast<std::size_t>(medium.dye)];
        // ln(10) eps c with c = 1e-6 mol/L, over 1e4 micrometres in a centimetre
        return {0, std::log(10.0) * dye.molar_absorption_per_M_cm(nm) * 1e-6 / 1e4, 0};
    }
    return {coefficient_per_um(medium.scattering, nm), coefficient_per_um(medium.absorption, nm),
            mean_cosine(medium.phase)};
}

// Share of the segment from a to b that is in a box, by cutting it with its six planes.
double share_in_box(Vec3 min, Vec3 max, Vec3 a, Vec3 b) {
    double from = 0;
    double to = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double start = a[axis];
        const double change = b[axis] - a[axis];
        if (change == 0) {
            if (start < min[axis] || start > max[axis]) return 0;
            continue;
        }
        const double enter = ((change > 0 ? min[axis] : max[axis]) - start) / change;
        const double leave = ((change > 0 ? max[axis] : min[axis]) - start) / change;
        from = std::max(from, enter);
        to = std::min(to, leave);
    }
    return std::max(0.0, to - from);
}

double henyey_greenstein_of(double cosine, double g) {
    return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

double normal(double x, double sigma) {
    return std::exp(-x * x / (2 * sigma * sigma)) / (sigma * std::sqrt(2 * kPi));
}

// Slopes of the rays of a focused light that pass at `x` from its axis, `z` behind the waist. Rays are Gaussian in
// position at the waist, x - slope z, times Gaussian in slope.
struct Slope {
    double slope = 0, density = 0;  // density of rays per um, of this slope's share
};

std::vector<Slope> slopes(double x, double z, double sigma_waist, double numerical_aperture, int fineness) {
    if (numerical_aperture == 0) return {{0, normal(x, sigma_waist)}};
    const double sigma_slope = 0.5 * std::tan(std::asin(numerical_aperture));
    std::vector<Slope> all;
    // Where the integrand is: around the slope of least squares, some standard deviations to each side.
    const double a = 1 / (sigma_slope * sigma_slope) + z * z / (sigma_waist * sigma_waist);
    const double center = x * z / (sigma_waist * sigma_waist) / a;
    const double step = 12 / std::sqrt(a) / fineness;
    for (int i = 0; i < fineness; ++i) {
        const double slope = center + (i + 0.5 - 0.5 * fineness) * step;
        all.push_back({slope, normal(x - slope * z, sigma_waist) * normal(slope, sigma_slope) * step});
    }
    return all;
}

std::vector<Bundle> bundles(const SheetLight& sheet, Vec3 p, int fineness) {
    const Vec3 q = p - sheet.waist;
    const double ahead = dot(p - sheet.position, sheet.direction);
    const double sideways = dot(q, cross(sheet.direction, sheet.normal));
    const double across = dot(q, sheet.normal);
    if (ahead < 0 || 2 * std::abs(sideways) > sheet.width_um) return {};
    if (sheet.profile == BeamProfile::Box) {
        if (2 * std::abs(across) > sheet.thickness_um) return {};
        return {{-sheet.direction, ahead, 1 / (sheet.width_um * sheet.thickness_um)}};
    }
    std::vector<Bundle> all;
    const double sigma = sheet.thickness_um / 4;  // exp(-2) at half the thickness
    for (const Slope& s : slopes(across, dot(q, sheet.direction), sigma, sheet.numerical_aperture, fineness)) {
        const double longer = std::sqrt(1 + s.slope * s.slope);
        const Vec3 flight = normalized(sheet.direction + s.slope * sheet.normal);
        all.push_back({-flight, ahead * longer, s.density / sheet.width_um * longer});
    }
    return all;
}

std::vector<Bundle> bundles(const BeamLight& beam, Vec3 p, int fineness) {
    const Vec3 q = p - beam.waist;
    const double ahead = dot(p - beam.position, beam.direction);
    const double z = dot(q, beam.direction);
    const Vec3 across = q - z * beam.direction;
    if (ahead < 0) return {};
    if (beam.profile == BeamProfile::Box) {
        if (length(across) > beam.radius_um) return {};
        return {{-beam.direction, ahead, 1 / (kPi * beam.radius_um * beam.radius_um)}};
    }
    const Vec3 x = normalized(cross(beam.direction, std::abs(beam.direction.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const Vec3 y = cross(beam.direction, x);
    std::vector<Bundle> all;
    const double sigma = beam.radius_um / 2;  // exp(-2) at the radius
    for (const Slope& a : slopes(dot(across, x), z, sigma, beam.numerical_aperture, fineness)) {
        for (const Slope& b : slopes(dot(across, y), z, sigma, beam.numerical_aperture, fineness)) {
            const Vec3 flight = beam.direction + a.slope * x + b.slope * y;
            all.push_back({-normalized(flight), ahead * length(flight), a.density * b.density * length(flight)});
        }
    }
    return all;
}

std::vector<Bundle> bundles(const PointLight& point, Vec3 p, int /*fineness*/) {
    const Vec3 way = point.position - p;
    return {{normalized(way), length(way), 1 / (4 * kPi * length_squared(way))}};
}

std::vector<Bundle> bundles(const RectangleLight& light, Vec3 p, int fineness) {
    const Vec3 right = cross(light.up, light.normal);
    std::vector<Bundle> all;
    for (int i = 0; i < fineness; ++i) {
        for (int j = 0; j < fineness; ++j) {
            const Vec3 place = light.center + (((i + 0.5) / fineness - 0.5) * light.width_um) * right +
                               (((j + 0.5) / fineness - 0.5) * light.height_um) * light.up;
            const Vec3 way = place - p;
            const double cosine = -dot(normalized(way), light.normal);
            if (cosine <= 0) continue;
            // Radiance 1 / (pi A) times the solid angle of a piece of A.
            all.push_back({normalized(way), length(way), cosine / length_squared(way) / kPi / (fineness * fineness)});
        }
    }
    return all;
}

// Evenly over the sphere (Fibonacci's lattice); its power is a radiance of one.
std::vector<Bundle> bundles(const UniformLight& /*light*/, Vec3 /*p*/, int fineness) {
    const int count = fineness * fineness;
    std::vector<Bundle> all;
    for (int i = 0; i < count; ++i) {
        const double z = 1 - 2 * (i + 0.5) / count;
        const double azimuth = kPi * (3 - std::sqrt(5.0)) * i;
        const double r = std::sqrt(1 - z * z);
        all.push_back({{r * std::cos(azimuth), r * std::sin(azimuth), z}, 1e6, 4 * kPi / count});
    }
    return all;
}

}  // namespace

double amount_at(const Scene& scene, const SceneMedium& medium, Vec3 p) {
    if (medium.grid) return medium.amount * medium.grid->trilinear(p);
    for (const int inner : medium.cut_by) {
        if (contains(scene.media[static_cast<std::size_t>(inner)].region, p)) return 0;
    }
    return contains(medium.region, p) ? medium.amount : 0;
}

double scattering_at(const Scene& scene, Vec3 p, double nm) {
    double total = 0;
    for (const SceneMedium& medium : scene.media)
        total += amount_at(scene, medium, p) * coefficients(scene, medium, nm).scattering;
    return total;
}

double extinction_at(const Scene& scene, Vec3 p, double nm) {
    double total = 0;
    for (const SceneMedium& medium : scene.media) {
        const Coefficients c = coefficients(scene, medium, nm);
        total += amount_at(scene, medium, p) * (c.scattering + c.absorption);
    }
    return total;
}

double optical_depth(const Scene& scene, Vec3 from, Vec3 to, double nm, int steps) {
    const double distance = length(to - from);
    double depth = 0;
    for (const SceneMedium& medium : scene.media) {
        const Coefficients c = coefficients(scene, medium, nm);
        const double per_um = c.scattering + c.absorption;
        if (per_um == 0) continue;
        const auto* box = std::get_if<BoxRegion>(&medium.region);
        const auto* slab = std::get_if<SlabRegion>(&medium.region);
        if (!medium.grid && medium.cut_by.empty() && box != nullptr) {
            depth += per_um * medium.amount * distance * share_in_box(box->min, box->max, from, to);
        } else if (!medium.grid && medium.cut_by.empty() && slab != nullptr) {
            constexpr double kFar = 1e12;
            Vec3 min{-kFar, -kFar, -kFar};
            Vec3 max{kFar, kFar, kFar};
            min[slab->axis] = std::max(min[slab->axis], slab->min);
            max[slab->axis] = std::min(max[slab->axis], slab->max);
            depth += per_um * medium.amount * distance * share_in_box(min, max, from, to);
        } else {
            for (int i = 0; i < steps; ++i) {
                const Vec3 p = from + ((i + 0.5) / steps) * (to - from);
                depth += per_um * amount_at(scene, medium, p) * distance / steps;
            }
        }
    }
    return depth;
}

std::vector<Bundle> light_at(const Light& light, Vec3 p, int fineness) {
    return std::visit([&](const auto& shape) { return bundles(shape, p, fineness); }, light.shape);
}

double direct_fluence(const Scene& scene, const Light& light, Vec3 p, double nm, int fineness) {
    double total = 0;
    for (const Bundle& bundle : light_at(light, p, fineness)) {
        const Vec3 start = p + bundle.distance_um * bundle.to_light;
        total += bundle.fluence_per_um2 * std::exp(-optical_depth(scene, start, p, nm));
    }
    return total;
}

double scattered_once(const Scene& scene, const Light& light, const Ray& ray, double nm, const Along& along) {
    double total = 0;
    double depth = 0;
    const double step = along.end_um / along.steps;
    for (int i = 0; i < along.steps; ++i) {
        const Vec3 p = ray.at((i + 0.5) * step);
        const double here = extinction_at(scene, p, nm) * step;
        if (scattering_at(scene, p, nm) > 0) {
            for (const Bundle& bundle : light_at(light, p, along.fineness)) {
                // Light flies against `to_light` before and against the ray after.
                const double cosine = dot(-bundle.to_light, -ray.direction);
                double source = 0;
                for (const SceneMedium& medium : scene.media) {
                    const Coefficients c = coefficients(scene, medium, nm);
                    source += amount_at(scene, medium, p) * c.scattering * henyey_greenstein_of(cosine, c.anisotropy);
                }
                const Vec3 start = p + bundle.distance_um * bundle.to_light;
                total += step * source * bundle.fluence_per_um2 * std::exp(-optical_depth(scene, start, p, nm)) *
                         std::exp(-depth - 0.5 * here);
            }
        }
        depth += here;
    }
    return total;
}

double converted_once(const Scene& scene, const Light& light, const Ray& ray, const Conversion& by,
                      const Along& along) {
    const Dye& dye = scene.dyes[static_cast<std::size_t>(by.dye)];
    double total = 0;
    double depth = 0;
    const double step = along.end_um / along.steps;
    for (int i = 0; i < along.steps; ++i) {
        const Vec3 p = ray.at((i + 0.5) * step);
        const double here = extinction_at(scene, p, by.emission_nm) * step;
        double absorbed_per_um = 0;
        for (const SceneMedium& medium : scene.media) {
            if (medium.dye != by.dye) continue;
            absorbed_per_um += amount_at(scene, medium, p) * coefficients(scene, medium, by.excitation_nm).absorption;
        }
        if (absorbed_per_um > 0) {
            const double fluence = direct_fluence(scene, light, p, by.excitation_nm, along.fineness);
            total += step * dye.quantum_yield * absorbed_per_um * fluence * dye.emission_per_nm(by.emission_nm) /
                     (4 * kPi) * std::exp(-depth - 0.5 * here);
        }
        depth += here;
    }
    return total;
}

}  // namespace fluovox::reference
