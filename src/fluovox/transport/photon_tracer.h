#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/medium/phase_function.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/absorbed_share.h"
#include "fluovox/transport/direction_lobes.h"
#include "fluovox/transport/photon.h"
#include "fluovox/transport/photon_media.h"
#include "fluovox/transport/photon_space.h"
#include "fluovox/volume/majorant_walk.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

namespace fluovox {

/// Follows photons through a scene. Absorption takes weight along the way (analytically in constant media, at the
/// tentative collisions of delta tracking in grids) while scattering is played out; of all the places where dyes
/// absorbed, one is drawn from which the photon goes on at the emission wavelength with the sum of their yields.
///
/// `Sink` hears what happens:
///   flight(photon, Flight, Zone)        a stretch flown (grids absorb at its end, by `absorbed`)
///   absorbed(photon, medium, weight, position)   in a grid; position of the collision
///   absorbed(photon, medium, weight)    in a constant medium, along the last flight
///   converted(photon, dye, absorbed, reemitted)  of the weight that a dye absorbed
///   escaped(photon)  cut(photon, weight)
///   vertex(photon, medium)              scatters here; before its direction changes
///   emission(photon)                    launched at the emission wavelength, isotropic
/// and, if it has it, in place of flights that are played out:
///   survey(photon, Flight, extinction)  a stretch of the way to the next surface with the weight that is expected
///                                       there: it falls by `extinction` (per um) of constant media
/// and may say by `lobes(photon)` which directions are worth most to it.
template <class Sink>
class PhotonTracer {
public:
    PhotonTracer(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits)
        : scene_(&scene), space_(&space), media_(scene, space), limits_(limits) {
        for (std::size_t i = 0; i < scene.media.size(); ++i) {
            if (scene.media[i].grid) grids_.push_back(static_cast<int>(i));
        }
    }

    /// Follows a photon of weight 1 and all that becomes of it.
    void follow(Photon photon, Rng& rng, Sink& sink) {
        double first_conversion = 1;
        for (;;) {
            conversion_ = {};
            media_.set_wavelength(photon.wavelength_nm);
            trace(photon, rng, sink);
            if (photon.order >= limits_.orders || !(conversion_.total > 0)) return;
            const double total = conversion_.total;
            if (photon.order == 0 && !limits_.minor_conversions) first_conversion = total;
            photon = reemitted(photon.order + 1, rng);
            sink.emission(photon);
            emit(photon, rng, sink);
            if (photon.order > 1 || limits_.minor_conversions)
                thin_out(photon, std::min(1.0, 3 * total / first_conversion), rng, sink);
            if (photon.weight == 0) return;
            photon.start_weight = worth(photon, sink);
        }
    }

    /// Gives light that is isotropic a direction: one of those that the sink prefers, with a weight that makes up for
    /// it.
    void emit(Photon& photon, Rng& rng, Sink& sink) const {
        const auto lobes = preferred(photon, sink);
        photon.ray.direction = sample_direction(lobes, rng);
        if (!lobes.empty()) {
            photon.weight /= 4 * std::numbers::pi * direction_pdf(lobes, photon.ray.direction);
            photon.start_weight = worth(photon, sink);
        }
    }

    const PhotonMedia& media() const { return media_; }
    std::int64_t bound_violations() const { return bound_violations_; }
    std::int64_t scatterings() const { return scatterings_; }

private:
    static constexpr double kFar = std::numeric_limits<double>::infinity();

    // One place where dye absorbed, drawn from all of them in proportion to what it gives back.
    struct Conversion {
        double total = 0;
        Flight flight{};
        int dye = -1;
        Inside inside = 0;
        std::int64_t scatterings = 0;
    };

    // Tentative collisions with the medium of a grid along a ray.
    struct GridEvents {
        int medium = -1;
        double rate_per_bound = 0;
        double least_rate = 0;
        MajorantWalk walk;
        MajorantWalk::Segment segment;
        double rate = 0;  // on the segment, per um
        double t = 0;     // of the next collision

        void advance(Rng& rng) {
            ExponentialDistance depth(rng);
            for (;;) {
                if (depth.ends_within(rate * (segment.end - t))) {
                    t += depth.rest() / rate;
                    return;
                }
                if (!walk.next(segment)) break;
                t = segment.begin;
                rate = rate_per_bound * segment.bound;
                if (segment.end < kFar) rate = std::max(rate, least_rate);  // a background may go on for ever
            }
            t = kFar;
        }
    };

    void trace(Photon& photon, Rng& rng, Sink& sink) {
        clear_um_ = 0;
        int idle = 0;  // surfaces met in a row without scattering or absorption
        while (photon.weight > 0) {
            const Zone& zone = media_.zone(photon.inside);
            const double before = photon.weight;
            const bool scattered = fly(photon, zone, rng, sink);
            if (photon.weight == 0) return;
            idle = scattered || photon.weight < before ? 0 : idle + 1;
            constexpr int kMostIdle = 1000;  // totally reflected light in a clear body never gets out
            if (idle > kMostIdle || photon.scatterings > limits_.scatterings) {
                cut(photon, sink);
                return;
            }
            constexpr double kSmall = 0.1;
            constexpr double kSurvival = 0.2;
            if (worth(photon, sink) < kSmall * photon.start_weight) thin_out(photon, kSurvival, rng, sink);
        }
    }

    // Unit length again after rounding: Newton's step from there, without a root.
    static Vec3 unit_again(Vec3 direction) { return (1.5 - 0.5 * dot(direction, direction)) * direction; }

    // To the next scattering (true) or surface (false), whatever lies between.
    bool fly(Photon& photon, const Zone& zone, Rng& rng, Sink& sink) {
        survey_if_wanted(photon, zone, rng, sink);
        const double scatter_t = zone.scattering > 0 ? rng.exponential() / zone.scattering : kFar;
        const PhotonSpace::Crossing crossing = crossing_before(scatter_t, photon);
        start_grids(photon.ray, std::min(crossing.t_um, scatter_t), rng);
        double t = 0;
        for (;;) {
            GridEvents* grid = nearest_grid();
            const double collision = grid == nullptr ? kFar : grid->t;
            const double end = std::min({crossing.t_um, scatter_t, collision});
            if (end == kFar && !(zone.absorption > 0)) {
                leave(photon, zone, t, sink);
                return false;
            }
            absorb_along(photon, zone, t, end, rng, sink);
            t = end;
            if (photon.weight == 0) return false;
            if (grid != nullptr && end == collision) {
                if (!collide(photon, *grid, t, rng, sink)) continue;
                if (photon.weight > 0) scatter(photon, grid->medium, t, rng, sink);
                return true;
            }
            if (end == scatter_t) {
                scatter(photon, scatterer(zone, rng), t, rng, sink);
                return true;
            }
            cross(photon, crossing, zone, rng);
            return false;
        }
    }

    // None where the flight ends before any surface.
    PhotonSpace::Crossing crossing_before(double end_um, const Photon& photon) const {
        if (end_um < clear_um_) return {kFar, 0};
        return space_->next_crossing(photon.ray, photon.inside);
    }

    void survey_if_wanted(const Photon& photon, const Zone& zone, Rng& rng, Sink& sink) {
        if constexpr (requires { sink.surveys(photon); }) {
            if (sink.surveys(photon))
                survey(photon, zone, space_->next_crossing(photon.ray, photon.inside).t_um, rng, sink);
        }
    }

    // Scattering only thins out what goes on: less noise than what some flights reach and others do not. Where little
    // is left it is played out, or the walk would be long in dense media.
    void survey(const Photon& photon, const Zone& zone, double length_um, Rng& rng, Sink& sink) {
        constexpr double kDepth = 1.5;
        constexpr double kLittle = 0.2;
        const double extinction = zone.scattering + zone.absorption;
        const double faded = extinction > 0 ? kDepth / extinction : kFar;
        const double last = length_um > faded ? std::min(length_um, faded + rng.exponential() / extinction) : length_um;
        start_grids(photon.ray, last, rng);
        double weight = photon.weight;
        double t = 0;
        for (;;) {
            GridEvents* grid = nearest_grid();
            const double collision = grid == nullptr ? kFar : grid->t;
            const double fades = t < faded ? extinction : 0;
            const double end = std::min({last, collision, t < faded ? faded : last});
            sink.survey(photon, Flight{{photon.ray.at(t), photon.ray.direction}, end - t, weight, 0}, fades);
            if (end == last) return;
            weight *= std::exp(-fades * (end - t));
            t = end;
            if (grid == nullptr || t < collision) continue;
            const double rate = grid->rate;
            const MediumOptics& optics = media_.optics(grid->medium);
            weight *= std::max(0.0, 1 - (optics.scattering + optics.absorption) * collided(*grid, t, rng) / rate);
            if (weight >= kLittle * photon.weight) continue;
            if (weight == 0 || rng.uniform() < 0.5) return;
            weight *= 2;
        }
    }

    void start_grids(const Ray& ray, double end, Rng& rng) {
        events_.clear();
        for (const int medium : grids_) {
            const MediumOptics& optics = media_.optics(medium);
            const double most = optics.scattering + optics.absorption;
            if (most <= 0) continue;
            const SparseGrid& grid = *scene_->media[static_cast<std::size_t>(medium)].grid;
            // Absorption is taken at tentative collisions, so thin dye gets more of them than it needs: one every few
            // voxels.
            const double voxel = length(grid.world_from_index().rows[0]);
            const double least = optics.absorption > 0 && !limits_.minor_conversions ? 0.25 / voxel : 0;
            // Coarse bounds do where little happens; but those extra collisions must not fill empty space.
            const double rate = limits_.majorant_factor * most;
            const MajorantWalk walk =
                least > 0 ? MajorantWalk(grid, ray, {0, end}) : MajorantWalk(grid, ray, {0, end}, rate);
            GridEvents& events = events_.emplace_back(GridEvents{medium, rate, least, walk, {}, 0, 0});
            events.advance(rng);
        }
    }

    GridEvents* nearest_grid() {
        GridEvents* nearest = nullptr;
        for (GridEvents& events : events_) {
            if (events.t < kFar && (nearest == nullptr || events.t < nearest->t)) nearest = &events;
        }
        return nearest;
    }

    void absorb_along(Photon& photon, const Zone& zone, double from, double to, Rng& rng, Sink& sink) {
        Flight flight{{photon.ray.at(from), photon.ray.direction}, to - from, photon.weight, 0, zone.absorption};
        if (zone.absorption > 0) {
            const bool all = flight.length_um == kFar;
            flight.lost = all ? photon.weight : photon.weight * absorbed_share(zone.absorption * flight.length_um);
        }
        sink.flight(photon, flight, zone);
        if (!(zone.absorption > 0)) return;
        const double lost = flight.lost;
        photon.weight = flight.length_um == kFar ? 0 : photon.weight - lost;
        for (const int medium : zone.media) {
            const double absorption = media_.optics(medium).absorption;
            if (!(absorption > 0)) continue;
            const double share = zone.media.size() == 1 ? lost : lost * absorption / zone.absorption;
            sink.absorbed(photon, medium, share);
            convert(photon, medium, share, flight, rng, sink);
        }
    }

    // A dye that absorbed `weight` gives its yield back, here or elsewhere.
    void convert(const Photon& photon, int medium, double weight, const Flight& flight, Rng& rng, Sink& sink) {
        const int dye = scene_->media[static_cast<std::size_t>(medium)].dye;
        if (dye < 0) return;
        const double back = weight * scene_->dyes[static_cast<std::size_t>(dye)].quantum_yield;
        const bool goes_on = photon.order < limits_.orders;
        sink.converted(photon, dye, weight, goes_on ? back : 0);
        if (!goes_on || !(back > 0)) return;
        conversion_.total += back;
        if (rng.uniform() * conversion_.total >= back) return;
        conversion_.flight = flight;
        conversion_.dye = dye;
        conversion_.inside = photon.inside;
        conversion_.scatterings = photon.scatterings + photon.earlier_scatterings;
    }

    Photon reemitted(int order, Rng& rng) const {
        const Conversion& c = conversion_;
        double t = 0;
        const double absorption = c.flight.absorption_per_um;
        if (absorption > 0) {
            const double all = -std::expm1(-absorption * c.flight.length_um);
            t = std::min(-std::log1p(-rng.uniform() * all) / absorption, c.flight.length_um);
        }
        Photon photon;
        photon.ray.origin = c.flight.ray.at(t);
        photon.wavelength_nm = scene_->dyes[static_cast<std::size_t>(c.dye)].emission_per_nm.sample(rng.uniform());
        photon.weight = photon.start_weight = c.total;
        photon.inside = c.inside;
        photon.order = order;
        photon.dye = c.dye;
        photon.earlier_scatterings = c.scatterings;
        return photon;
    }

    // The value at a tentative collision; the next one comes after it.
    double collided(GridEvents& events, double t, Rng& rng) {
        const SparseGrid& grid = *scene_->media[static_cast<std::size_t>(events.medium)].grid;
        const auto value = static_cast<double>(grid.tap(events.walk.index_at(t), rng.bits()));
        if (value > events.segment.bound) ++bound_violations_;
        events.advance(rng);
        return value;
    }

    // A tentative collision: absorbs its share; true when the rest scatters (or nothing is left).
    bool collide(Photon& photon, GridEvents& events, double t, Rng& rng, Sink& sink) {
        const double rate = events.rate;
        const double value = collided(events, t, rng);
        if (value <= 0) return false;
        const MediumOptics& optics = media_.optics(events.medium);
        const double absorbed = std::min(1.0, optics.absorption * value / rate);
        if (absorbed > 0) {
            const Flight point{{photon.ray.at(t), photon.ray.direction}, 0, photon.weight, 0};
            const double lost = photon.weight * absorbed;
            photon.weight = absorbed == 1 ? 0 : photon.weight - lost;
            sink.absorbed(photon, events.medium, lost, point.ray.origin);
            convert(photon, events.medium, lost, point, rng, sink);
            if (photon.weight == 0) return true;
        }
        const double scattering = optics.scattering * value;
        return scattering > 0 && rng.uniform() * (rate * (1 - absorbed)) < scattering;
    }

    int scatterer(const Zone& zone, Rng& rng) const {
        if (zone.media.size() == 1) return zone.media[0];
        double left = rng.uniform() * zone.scattering;
        int last = zone.media[0];
        for (const int medium : zone.media) {
            const double scattering = media_.optics(medium).scattering;
            if (!(scattering > 0)) continue;
            last = medium;
            left -= scattering;
            if (left < 0) break;
        }
        return last;
    }

    void scatter(Photon& photon, int medium, double t, Rng& rng, Sink& sink) {
        photon.ray.origin = photon.ray.at(t);
        clear_um_ = t < clear_um_ ? clear_um_ - t : space_->clearance(photon.ray.origin);
        if (limits_.scatterings_are_physical &&
            photon.scatterings + photon.earlier_scatterings >= limits_.scatterings) {
            cut(photon, sink);
            return;
        }
        sink.vertex(photon, medium);
        ++photon.scatterings;
        ++scatterings_;
        turn(photon, scene_->media[static_cast<std::size_t>(medium)].phase, rng, sink);
    }

    // A part of them to where the sink prefers it, if it does; the weight makes up for it.
    void turn(Photon& photon, const PhaseFunction& phase, Rng& rng, Sink& sink) {
        constexpr double kByPhase = 0.7;
        const auto lobes = preferred(photon, sink);
        const Vec3 before = photon.ray.direction;
        if (lobes.empty() || rng.uniform() < kByPhase) {
            const double cosine = sample_phase_cosine(phase, rng.uniform());
            photon.ray.direction = unit_again(turned(before, cosine, rng.uniform()));
        } else {
            photon.ray.direction = sample_direction(lobes, rng);
        }
        if (lobes.empty()) return;
        const double density = phase_per_sr(phase, dot(before, photon.ray.direction));
        photon.weight *= density / (kByPhase * density + (1 - kByPhase) * direction_pdf(lobes, photon.ray.direction));
    }

    static std::span<const DirectionLobe> preferred(const Photon& photon, const Sink& sink) {
        if constexpr (requires { sink.lobes(photon); }) {
            return sink.lobes(photon);
        } else {
            return {};
        }
    }

    // The weight, or what it is worth to the sink in its direction.
    static double worth(const Photon& photon, const Sink& sink) {
        const auto lobes = preferred(photon, sink);
        return lobes.empty() ? photon.weight
                             : photon.weight * 4 * std::numbers::pi * direction_pdf(lobes, photon.ray.direction);
    }

    // To the surface, and through it or back.
    void cross(Photon& photon, const PhotonSpace::Crossing& crossing, const Zone& zone, Rng& rng) {
        photon.ray.origin = photon.ray.at(crossing.t_um);
        clear_um_ = 0;
        const Inside behind = photon.inside ^ crossing.changed;
        const double n1 = zone.index;
        const double n2 = space_->refracts() ? media_.zone(behind).index : n1;
        if (n1 == n2) {
            photon.inside = behind;
            return;
        }
        Vec3 normal = space_->normal(crossing.changed, photon.ray.origin);
        double cosine = -dot(normal, photon.ray.direction);
        if (cosine < 0) {  // against the flight
            normal = -normal;
            cosine = -cosine;
        }
        double behind_cosine = 0;
        const double reflectance = fresnel_reflectance(n1, n2, cosine, behind_cosine);
        const bool first = photon.refractions == 0 && photon.scatterings == 0;
        ++photon.refractions;
        const Vec3 d = photon.ray.direction;
        if (reflectance >= 1 || rng.uniform() < reflectance) {
            photon.reflected = first;
            photon.ray.direction = normalized(d + (2 * cosine) * normal);
            return;
        }
        photon.inside = behind;
        photon.ray.direction = normalized((n1 / n2) * d + (n1 / n2 * cosine - behind_cosine) * normal);
    }

    // Nothing more ahead.
    void leave(Photon& photon, const Zone& zone, double t, Sink& sink) {
        sink.flight(photon, Flight{{photon.ray.at(t), photon.ray.direction}, kFar, photon.weight, 0}, zone);
        sink.escaped(photon);
        photon.weight = 0;
    }

    void cut(Photon& photon, Sink& sink) {
        sink.cut(photon, photon.weight);
        photon.weight = 0;
    }

    // Russian roulette: the expectation stays, what it adds or takes is on the balance of the cut.
    void thin_out(Photon& photon, double survival, Rng& rng, Sink& sink) {
        if (survival >= 1) return;
        if (rng.uniform() >= survival) {
            cut(photon, sink);
            return;
        }
        const double heavier = photon.weight / survival;
        sink.cut(photon, photon.weight - heavier);
        photon.weight = heavier;
    }

    const Scene* scene_;
    const PhotonSpace* space_;
    PhotonMedia media_;
    PhotonLimits limits_;
    std::vector<int> grids_;
    std::vector<GridEvents> events_;
    Conversion conversion_;
    double clear_um_ = 0;  // from the photon to the nearest surface, at least
    std::int64_t bound_violations_ = 0;
    std::int64_t scatterings_ = 0;
};

}  // namespace fluovox
