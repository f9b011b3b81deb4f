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

struct Photon {
    Vec3 place, direction;
    double nm = 0;
    int conversions = 0, scatterings = 0;
    bool touched = false;  // by anything since its start
};

enum class Fate { Scattered, TakenByDye, TakenByHost };

struct Event {
    Vec3 place;
    Fate fate = Fate::Scattered;
    const SceneMedium* medium = nullptr;
};

// What one medium does at `p` to a photon that drew `u`, from which it takes its coefficients; nothing when they are
// less.
std::optional<Fate> fate_in(const Scene& scene, const SceneMedium& medium, Vec3 p, double nm, double& u) {
    const double amount = amount_at(medium, p);
    if (amount <= 0) return std::nullopt;
    if (medium.dye >= 0) {
        const Dye& dye = scene.dyes[static_cast<std::size_t>(medium.dye)];
        u -= amount * std::log(10.0) * dye.molar_absorption_per_M_cm(nm) * 1e-10;
        return u < 0 ? std::optional(Fate::TakenByDye) : std::nullopt;
    }
    u -= amount * coefficient_per_um(medium.scattering, nm);
    if (u < 0) return Fate::Scattered;
    u -= amount * coefficient_per_um(medium.absorption, nm);
    return u < 0 ? std::optional(Fate::TakenByHost) : std::nullopt;
}

// The next event, or nothing when the photon leaves the ball.
std::optional<Event> next_event(const Scene& scene, const Photon& photon, const WalkSettings& settings, Dice& dice) {
    Vec3 p = photon.place;
    for (;;) {
        p = p - std::log(1 - one(dice)) / settings.most_per_um * photon.direction;
        if (length(p) > settings.ball_um && dot(p, photon.direction) > 0) return std::nullopt;
        double u = one(dice) * settings.most_per_um;
        for (const SceneMedium& medium : scene.media) {
            if (const auto fate = fate_in(scene, medium, p, photon.nm, u)) return Event{p, *fate, &medium};
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

void count_escaped(const Photon& photon, const Camera& camera, const WalkSettings& settings, WalkCounts& counts) {
    const bool glow = photon.conversions > 0;
    (glow ? counts.escaped_as_glow : counts.escaped_as_laser) += 1;
    const bool filmed = !glow || (photon.nm >= settings.film_from_nm && photon.nm <= settings.film_to_nm);
    if (!photon.touched || !filmed) return;
    const int pixel = pixel_of(camera, photon.place, photon.direction);
    if (pixel >= 0) (glow ? counts.glow_in_pixel : counts.laser_in_pixel)[static_cast<std::size_t>(pixel)] += 1;
}

// Does to the photon what the event says; false where that is its end.
bool survives(const Event& event, const Scene& scene, const WalkSettings& settings, Photon& photon, Dice& dice,
              WalkCounts& counts) {
    photon.place = event.place;
    photon.touched = true;
    if (event.fate == Fate::Scattered) {
        if (++photon.scatterings > settings.scatterings) return false;
        photon.direction = scattered(photon.direction, mean_cosine(event.medium->phase), dice);
        return true;
    }
    if (event.fate == Fate::TakenByHost) {
        counts.absorbed_by_host += 1;
        return false;
    }
    counts.absorbed_by_dye += 1;
    const Dye& dye = scene.dyes[static_cast<std::size_t>(event.medium->dye)];
    if (photon.conversions == settings.orders || one(dice) >= dye.quantum_yield) return false;
    counts.reemitted += 1;
    ++photon.conversions;
    photon.nm = dye.emission_per_nm.sample(one(dice));
    photon.direction = any_direction(dice);
    return true;
}

void follow(Photon photon, const Scene& scene, const WalkSettings& settings, Dice& dice, WalkCounts& counts) {
    while (const auto event = next_event(scene, photon, settings, dice)) {
        if (!survives(*event, scene, settings, photon, dice, counts)) return;
    }
    count_escaped(photon, scene.description.camera, settings, counts);
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
    const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    WalkCounts counts;
    counts.launched = static_cast<double>(settings.photons);
    counts.laser_in_pixel.assign(pixels, 0);
    counts.glow_in_pixel.assign(pixels, 0);
    Dice dice(settings.seed);
    for (std::int64_t n = 0; n < settings.photons; ++n) {
        const Ray start = launch(dice);
        follow({start.origin, start.direction, settings.laser_nm}, scene, settings, dice, counts);
    }
    return counts;
}

}  // namespace fluovox::reference
