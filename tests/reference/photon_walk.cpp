#include "photon_walk.h"

#include <cmath>
#include <numbers>
#include <optional>

namespace fluovox::reference {
namespace {

double one(Dice& dice) {
    return std::uniform_real_distribution<double>(0, 1)(dice);
}

Vec3 any_direction(Dice& dice) {
    std::normal_distribution<double> normal;
    return normalized({normal(dice), normal(dice), normal(dice)});
}

// Rejection from the phase function itself: directions evenly over the sphere, kept in proportion to it.
Vec3 scattered(Vec3 direction, double g, Dice& dice) {
    const double most = std::pow(1 - std::abs(g), -3);
    for (;;) {
        const Vec3 candidate = any_direction(dice);
        if (one(dice) * most < std::pow(1 + g * g - 2 * g * dot(candidate, direction), -1.5)) return candidate;
    }
}

double amount_at(const SceneMedium& medium, Vec3 p) {
    if (medium.grid) return medium.amount * medium.grid->trilinear(p);
    return contains(medium.region, p) ? medium.amount : 0;
}

enum class Fate { Scattered, TakenByDye, TakenByHost };

struct Event {
    Vec3 place;
    Fate fate = Fate::Scattered;
    const SceneMedium* medium = nullptr;
};

// The next event, or nothing when the photon leaves the ball.
std::optional<Event> next_event(const Scene& scene, Vec3 from, Vec3 direction, double nm, double ball_um, double most,
                                Dice& dice) {
    Vec3 p = from;
    for (;;) {
        p = p - std::log(1 - one(dice)) / most * direction;
        if (length(p) > ball_um && dot(p, direction) > 0) return std::nullopt;
        double u = one(dice) * most;
        for (const SceneMedium& medium : scene.media) {
            const double amount = amount_at(medium, p);
            if (amount <= 0) continue;
            if (medium.dye >= 0) {
                const Dye& dye = scene.dyes[static_cast<std::size_t>(medium.dye)];
                u -= amount * std::log(10.0) * dye.molar_absorption_per_M_cm(nm) * 1e-10;
                if (u < 0) return Event{p, Fate::TakenByDye, &medium};
                continue;
            }
            u -= amount * coefficient_per_um(medium.scattering, nm);
            if (u < 0) return Event{p, Fate::Scattered, &medium};
            u -= amount * coefficient_per_um(medium.absorption, nm);
            if (u < 0) return Event{p, Fate::TakenByHost, &medium};
        }
    }
}

// The pixel that a photon flying from `p` along `direction` is seen in; -1: none.
int pixel_of(const Camera& camera, Vec3 p, Vec3 direction) {
    const Vec3 forward = normalized(camera.target - camera.position);
    const Vec3 right = normalized(cross(forward, camera.up));
    const Vec3 up = cross(right, forward);
    if (dot(direction, forward) >= 0) return -1;
    const double a = dot(direction, right);
    const double b = dot(direction, up);
    if (a * a + b * b > camera.numerical_aperture * camera.numerical_aperture) return -1;
    const double depth = dot(p - camera.position, forward) - camera.focus_um;
    const Vec3 place = p - depth / dot(direction, forward) * direction - camera.position;
    const double pixel = camera.field_um / camera.height;
    const double x = std::floor(dot(place, right) / pixel + 0.5 * camera.width);
    const double y = std::floor(0.5 * camera.height - dot(place, up) / pixel);
    if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return -1;
    return static_cast<int>(y) * camera.width + static_cast<int>(x);
}

}  // namespace

WalkCounts::Radiance WalkCounts::radiance(const Camera& camera, double hits) const {
    const double pixel = camera.field_um / camera.height;
    const double na = camera.numerical_aperture;
    const double unit = launched * pixel * pixel * std::numbers::pi * na * na;
    return {hits / unit, std::sqrt(hits + 1) / unit};
}

WalkCounts walk(const Scene& scene, const Launch& launch, const WalkSettings& settings) {
    const Camera& camera = scene.description.camera;
    const auto pixels = static_cast<std::size_t>(camera.width * camera.height);
    WalkCounts counts;
    counts.launched = static_cast<double>(settings.photons);
    counts.laser_in_pixel.assign(pixels, 0);
    counts.glow_in_pixel.assign(pixels, 0);
    Dice dice(settings.seed);
    for (std::int64_t n = 0; n < settings.photons; ++n) {
        const Ray start = launch(dice);
        Vec3 p = start.origin;
        Vec3 direction = start.direction;
        double nm = settings.laser_nm;
        int conversions = 0;
        int scatterings = 0;
        bool touched = false;
        for (;;) {
            const auto event = next_event(scene, p, direction, nm, settings.ball_um, settings.most_per_um, dice);
            if (!event) {
                (conversions > 0 ? counts.escaped_as_glow : counts.escaped_as_laser) += 1;
                const bool filmed = conversions == 0 || (nm >= settings.film_from_nm && nm <= settings.film_to_nm);
                const int pixel = touched && filmed ? pixel_of(camera, p, direction) : -1;
                auto& image = conversions > 0 ? counts.glow_in_pixel : counts.laser_in_pixel;
                if (pixel >= 0) image[static_cast<std::size_t>(pixel)] += 1;
                break;
            }
            p = event->place;
            touched = true;
            if (event->fate == Fate::Scattered) {
                if (++scatterings > settings.scatterings) break;
                direction = scattered(direction, mean_cosine(event->medium->phase), dice);
                continue;
            }
            if (event->fate == Fate::TakenByHost) {
                counts.absorbed_by_host += 1;
                break;
            }
            counts.absorbed_by_dye += 1;
            const Dye& dye = scene.dyes[static_cast<std::size_t>(event->medium->dye)];
            if (conversions == settings.orders || one(dice) >= dye.quantum_yield) break;
            counts.reemitted += 1;
            ++conversions;
            nm = dye.emission_per_nm.sample(one(dice));
            direction = any_direction(dice);
        }
    }
    return counts;
}

}  // namespace fluovox::reference
