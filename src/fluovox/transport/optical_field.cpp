#include "fluovox/transport/optical_field.h"

#include "fluovox/volume/bound_visitor.h"
#include "fluovox/volume/grid_integral.h"
#include "fluovox/volume/majorant_walk.h"
#include "fluovox/volume/plain_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

const Lanes& lanes_of(const PathOptics::MediumLanes& medium, Loss loss) {
    return loss == Loss::Absorption ? medium.absorption : medium.extinction;
}

double length_before(const Interval& span, double end_um) {
    return std::max(0.0, std::min(span.end, end_um) - span.begin);
}

// Taps of a walk, for trackings and counts; its segments have the bounds of their places.
template <class Walk>
struct WalkTap {
    const Walk* walk;

    double at(double t) const { return t; }
    double local_bound(double /*t*/, double bound, std::uint64_t /*bits*/) const { return bound; }
    double value(double t, std::uint64_t bits) const { return walk->tap(t, bits); }
    static Voxel voxel(double /*t*/, std::uint64_t /*bits*/) { return {}; }
};

// `whole` without `cut`; what is left may be two pieces.
void subtract(std::vector<MediumSpan>& spans, std::size_t first, Interval cut) {
    if (cut.empty()) return;
    const std::size_t last = spans.size();
    for (std::size_t i = first; i < last; ++i) {
        const MediumSpan whole = spans[i];
        if (cut.end <= whole.span.begin || cut.begin >= whole.span.end) continue;
        spans[i].span.end = std::max(whole.span.begin, cut.begin);
        if (cut.end < whole.span.end) spans.push_back({{cut.end, whole.span.end}, whole.medium});
    }
}

}  // namespace

TrackingCounts& TrackingCounts::operator+=(const TrackingCounts& other) {
    real_collisions += other.real_collisions;
    null_collisions += other.null_collisions;
    shadow_collisions += other.shadow_collisions;
    grid_lookups += other.grid_lookups;
    bound_violations += other.bound_violations;
    return *this;
}

double hero_depth(const std::vector<MediumSpan>& spans, const PathOptics& optics, double end_um) {
    double depth = 0;
    for (const MediumSpan& s : spans) {
        const double inside = length_before(s.span, end_um);
        const double coefficient = optics.media[static_cast<std::size_t>(s.medium)].extinction[0];
        if (inside > 0 && coefficient > 0) depth += inside * coefficient;  // the length may be infinite
    }
    return depth;
}

OpticalField::OpticalField(const Scene& scene) : scene_(&scene), plain_(scene.description.render.plain_tracking) {
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        const SparseGrid* grid = scene.media[i].grid.get();
        (grid != nullptr ? gridded_ : constant_).push_back(static_cast<int>(i));
        ways_.push_back({Way::Kind::None, grid, nullptr});
        if (grid == nullptr) continue;
        ways_.back().kind = plain_                  ? Way::Kind::Plain
                            : grid->has_directory() ? Way::Kind::Bricks
                                                    : Way::Kind::Majorants;
        if (plain_ && grid->tree()) ways_.back().sampler = std::make_unique<VdbSampler>(grid->tree());
    }
}

PathOptics OpticalField::optics(const Wavelengths& wavelengths) const {
    PathOptics optics;
    set_optics(wavelengths, optics);
    return optics;
}

void OpticalField::set_optics(const Wavelengths& wavelengths, PathOptics& optics) const {
    optics.wavelengths = wavelengths;
    optics.media.assign(scene_->media.size(), PathOptics::MediumLanes(wavelengths.count()));
    optics.grey_scattering = true;
    for (std::size_t i = 0; i < optics.media.size(); ++i) {
        const SceneMedium& medium = scene_->media[i];
        PathOptics::MediumLanes& lanes = optics.media[i];
        if (medium.dye >= 0) {
            const Dye& dye = scene_->dyes[static_cast<std::size_t>(medium.dye)];
            lanes.absorption = medium.amount * absorption_per_um_per_uM(dye, wavelengths.nm);
        } else {
            lanes.absorption = medium.amount * coefficient_per_um(medium.absorption, wavelengths.nm);
            lanes.scattering = medium.amount * coefficient_per_um(medium.scattering, wavelengths.nm);
            for (int k = 1; k < wavelengths.count(); ++k) {
                if (lanes.scattering[k] != lanes.scattering[0]) optics.grey_scattering = false;
            }
        }
        lanes.extinction = lanes.scattering + lanes.absorption;
        lanes.max_scattering = lanes.scattering.max();
        lanes.max_absorption = lanes.absorption.max();
        lanes.max_extinction = lanes.extinction.max();
    }
}

void OpticalField::gather(const Ray& ray, std::vector<MediumSpan>& spans) const {
    spans.clear();
    for (const int i : constant_) {
        const SceneMedium& medium = scene_->media[static_cast<std::size_t>(i)];
        const Interval chord = intersect(medium.region, ray);
        if (chord.empty()) continue;
        const std::size_t first = spans.size();
        spans.push_back({chord, i});
        for (const int inner : medium.cut_by) {
            subtract(spans, first, intersect(scene_->media[static_cast<std::size_t>(inner)].region, ray));
        }
    }
}

double OpticalField::value_at(int medium, Vec3 world_um, Rng& rng) {
    ++counts_.grid_lookups;
    const Way& way = ways_[static_cast<std::size_t>(medium)];
    const Vec3 at = way.grid->index_from_world().point(world_um);
    if (way.sampler) return way.sampler->trilinear(at);
    return static_cast<double>(way.grid->tap(at, rng.bits()));
}

PlainWalk OpticalField::plain_walk(int medium, const Ray& ray, Interval span) const {
    const Way& way = ways_[static_cast<std::size_t>(medium)];
    return {*way.grid, way.sampler.get(), ray, span};
}

template <class Walk>
void OpticalField::ratio_track(Walk walk, const Lanes& coefficient, double most, Rng& rng, Lanes& transmittance) {
    constexpr double kDim = 1e-3;  // the walk through the dark ends
    typename Walk::Segment segment;
    ExponentialDistance depth(rng);
    while (walk.next(segment)) {
        if (!std::isfinite(segment.end)) {  // background for ever: a wavelength is lost in it, or not touched at all
            for (int k = 0; k < coefficient.count(); ++k) {
                if (coefficient[k] > 0) transmittance[k] = 0;
            }
            return;
        }
        const double majorant = most * segment.bound;
        double t = segment.begin;
        while (depth.ends_within(majorant * (segment.end - t))) {
            t += depth.rest() / majorant;
            depth = ExponentialDistance(rng);
            ++counts_.shadow_collisions;
            const double share = counted_tap(WalkTap<Walk>{&walk}, t, segment.bound, rng.bits(), counts_) / majorant;
            if (share == 0) continue;
            for (int k = 0; k < coefficient.count(); ++k)
                transmittance[k] *= 1 - share * coefficient[k];
            if (survives(transmittance, kDim, rng)) continue;
            transmittance = Lanes(coefficient.count());
            return;
        }
    }
}

Lanes OpticalField::transmittance(const Ray& ray, const std::vector<MediumSpan>& spans, double end_um,
                                  const PathOptics& optics, Loss loss, Rng& rng) {
    Lanes depth(optics.wavelengths.count());
    for (const MediumSpan& s : spans) {
        const double inside = length_before(s.span, end_um);
        const Lanes& lanes = lanes_of(optics.media[static_cast<std::size_t>(s.medium)], loss);
        for (int k = 0; k < depth.count(); ++k) {
            if (lanes[k] > 0) depth[k] += inside * lanes[k];  // the length may be infinite
        }
    }
    Lanes result = exp_minus(depth);
    for (const int i : gridded_) {
        const PathOptics::MediumLanes& lanes = optics.media[static_cast<std::size_t>(i)];
        const double most = loss == Loss::Absorption ? lanes.max_absorption : lanes.max_extinction;
        if (most <= 0) continue;
        const SparseGrid& grid = *scene_->media[static_cast<std::size_t>(i)].grid;
        if (plain_) {
            ratio_track(plain_walk(i, ray, {0, end_um}), lanes_of(lanes, loss), most, rng, result);
        } else {
            ratio_track(MajorantWalk(grid, ray, {0, end_um}, most), lanes_of(lanes, loss), most, rng, result);
        }
    }
    return result;
}

template <class Tracking>
void OpticalField::track(int medium, const Ray& ray, double end_um, double coefficient, Tracking& tracking) const {
    const Way& way = ways_[static_cast<std::size_t>(medium)];
    const SparseGrid& grid = *way.grid;
    if (way.kind == Way::Kind::Bricks) return BoundVisitor(grid, ray, {0, end_um}, coefficient).run(tracking);
    const auto step_along = [&](auto walk) {
        const auto tap = [&] { return WalkTap<decltype(walk)>{&walk}; };
        for (auto segment = typename decltype(walk)::Segment{}; walk.next(segment);) {
            if (tracking.look(segment.begin, segment.end, segment.bound, tap)) return;
        }
    };
    if (way.kind == Way::Kind::Plain) {
        step_along(plain_walk(medium, ray, {0, end_um}));
    } else {
        step_along(MajorantWalk(grid, ray, {0, end_um}, coefficient));
    }
}

// All that the inner loops call lies in the one function of each: their numbers need not go through memory.
[[gnu::flatten]] GridCollision OpticalField::first_collision(int medium, const Ray& ray, double end_um,
                                                             double coefficient, Rng& rng) {
    CollisionSearch search(coefficient, rng, counts_);
    track(medium, ray, end_um, coefficient, search);
    return search.found();
}

[[gnu::flatten]] double OpticalField::ratio_transmittance(int medium, const Ray& ray, double end_um, double coefficient,
                                                          double dim, Rng& rng) {
    RatioTracking tracking(coefficient, dim, rng, counts_);
    track(medium, ray, end_um, coefficient, tracking);
    return tracking.left();
}

double OpticalField::precise_transmittance(int medium, const Ray& ray, double coefficient, Rng& rng) {
    constexpr double kDark = 3;
    const double enough = kDark / coefficient;
    GridIntegral integral(enough);
    integral.add(*ways_[static_cast<std::size_t>(medium)].grid, ray);
    counts_.grid_lookups += integral.lookups();
    const double left = std::exp(-coefficient * integral.total());
    if (integral.total() < enough) return left;
    const Ray rest{ray.at(integral.end()), ray.direction};
    return left * ratio_transmittance(medium, rest, kFar, coefficient, 1, rng);
}

template <class Walk>
void OpticalField::delta_track(Walk walk, int medium, const PathOptics& optics, Rng& rng,
                               std::optional<Scattering>& nearest, Lanes& likeness) {
    const PathOptics::MediumLanes& lanes = optics.media[static_cast<std::size_t>(medium)];
    typename Walk::Segment segment;
    ExponentialDistance depth(rng);
    while (walk.next(segment)) {
        if (!std::isfinite(segment.end) && lanes.scattering[0] <= 0) {  // the hero leaves; others would not
            for (int k = 0; k < likeness.count(); ++k) {
                if (lanes.scattering[k] > 0) likeness[k] = 0;
            }
            return;
        }
        const double majorant = lanes.max_scattering * segment.bound;
        double t = segment.begin;
        while (depth.ends_within(majorant * (segment.end - t))) {
            t += depth.rest() / majorant;
            depth = ExponentialDistance(rng);
            const double share = counted_tap(WalkTap<Walk>{&walk}, t, segment.bound, rng.bits(), counts_) / majorant;
            const double real = share * lanes.scattering[0];
            if (rng.uniform() < real) {
                for (int k = 0; k < likeness.count(); ++k)
                    likeness[k] *= lanes.scattering[k] / lanes.scattering[0];
                nearest = Scattering{t, medium};
                return;
            }
            ++counts_.null_collisions;
            for (int k = 0; k < likeness.count(); ++k)
                likeness[k] *= (1 - share * lanes.scattering[k]) / (1 - real);
        }
    }
}

std::optional<Scattering> OpticalField::sample_scattering(const Ray& ray, const std::vector<MediumSpan>& spans,
                                                          const PathOptics& optics, Rng& rng, Lanes& likeness) {
    std::optional<Scattering> nearest;
    likeness = Lanes(optics.wavelengths.count(), 1);
    for (const MediumSpan& s : spans) {
        const double coefficient = optics.media[static_cast<std::size_t>(s.medium)].scattering[0];
        if (coefficient <= 0) continue;
        const double t = s.span.begin + rng.exponential() / coefficient;
        if (t < s.span.end && (!nearest || t < nearest->t_um)) nearest = Scattering{t, s.medium};
    }
    const bool constant_first = nearest.has_value();
    const double constant_t = constant_first ? nearest->t_um : kFar;
    for (const int i : gridded_) {
        const double most = optics.media[static_cast<std::size_t>(i)].max_scattering;
        if (most <= 0) continue;
        const SparseGrid& grid = *scene_->media[static_cast<std::size_t>(i)].grid;
        const Interval span{0, nearest ? nearest->t_um : kFar};
        if (plain_) {
            delta_track(plain_walk(i, ray, span), i, optics, rng, nearest, likeness);
        } else {
            delta_track(MajorantWalk(grid, ray, span, most), i, optics, rng, nearest, likeness);
        }
    }
    if (nearest) ++counts_.real_collisions;
    if (optics.grey_scattering) {
        likeness = Lanes(optics.wavelengths.count(), 1);
        return nearest;
    }
    const double end = nearest ? nearest->t_um : kFar;
    Lanes depth(likeness.count());
    for (const MediumSpan& s : spans) {
        const Lanes& coefficient = optics.media[static_cast<std::size_t>(s.medium)].scattering;
        const double inside = length_before(s.span, end);
        for (int k = 0; k < depth.count(); ++k) {
            if (coefficient[k] != coefficient[0]) depth[k] += inside * (coefficient[k] - coefficient[0]);
        }
    }
    likeness *= exp_minus(depth);
    if (constant_first && end == constant_t) {
        const Lanes& coefficient = optics.media[static_cast<std::size_t>(nearest->medium)].scattering;
        for (int k = 0; k < likeness.count(); ++k)
            likeness[k] *= coefficient[k] / coefficient[0];
    }
    return nearest;
}

Lanes OpticalField::scattering_at(const Ray& ray, double t_um, const std::vector<MediumSpan>& spans,
                                  const PathOptics& optics, std::vector<Lanes>& by_medium, Rng& rng) {
    Lanes total(optics.wavelengths.count());
    by_medium.assign(scene_->media.size(), total);
    for (const MediumSpan& s : spans) {
        if (t_um < s.span.begin || t_um > s.span.end) continue;
        const auto i = static_cast<std::size_t>(s.medium);
        by_medium[i] = optics.media[i].scattering;
        total += by_medium[i];
    }
    for (const int g : gridded_) {
        const auto i = static_cast<std::size_t>(g);
        if (optics.media[i].max_scattering <= 0) continue;
        by_medium[i] = value_at(g, ray.at(t_um), rng) * optics.media[i].scattering;
        total += by_medium[i];
    }
    return total;
}

Lanes OpticalField::scattering_density(const Ray& ray, double t_um, const std::vector<MediumSpan>& spans,
                                       const PathOptics& optics) const {
    Lanes coefficient(optics.wavelengths.count());
    Lanes depth(optics.wavelengths.count());
    for (const MediumSpan& s : spans) {
        const Lanes& lanes = optics.media[static_cast<std::size_t>(s.medium)].scattering;
        if (t_um >= s.span.begin && t_um <= s.span.end) coefficient += lanes;
        const double inside = length_before(s.span, t_um);
        if (inside > 0) depth += inside * lanes;
    }
    for (const int i : gridded_) {
        const PathOptics::MediumLanes& lanes = optics.media[static_cast<std::size_t>(i)];
        if (lanes.max_scattering <= 0) continue;
        coefficient += scene_->media[static_cast<std::size_t>(i)].grid->trilinear(ray.at(t_um)) * lanes.scattering;
    }
    return coefficient * exp_minus(depth);
}

bool OpticalField::concentrations(const Ray& ray, double t_um, const std::vector<MediumSpan>& spans,
                                  std::vector<double>& uM, Rng& rng) {
    uM.assign(scene_->media.size(), 0);
    bool any = false;
    for (const MediumSpan& s : spans) {
        const SceneMedium& medium = scene_->media[static_cast<std::size_t>(s.medium)];
        if (medium.dye < 0 || t_um < s.span.begin || t_um > s.span.end) continue;
        uM[static_cast<std::size_t>(s.medium)] = medium.amount;
        any = any || medium.amount > 0;
    }
    for (const int g : gridded_) {
        const SceneMedium& medium = scene_->media[static_cast<std::size_t>(g)];
        if (medium.dye < 0) continue;
        const double value = value_at(g, ray.at(t_um), rng);
        uM[static_cast<std::size_t>(g)] = medium.amount * value;
        any = any || value > 0;
    }
    return any;
}

Interval OpticalField::reach(const Ray& ray, const std::vector<MediumSpan>& spans) const {
    Interval reach{kFar, 0};
    for (const MediumSpan& s : spans) {
        reach.begin = std::min(reach.begin, s.span.begin);
        reach.end = std::max(reach.end, s.span.end);
    }
    for (const int i : gridded_) {
        const SparseGrid& grid = *scene_->media[static_cast<std::size_t>(i)].grid;
        if (grid.background() > 0) return {0, kFar};
        const Interval chord = intersect(BoxRegion{grid.bounds().min, grid.bounds().max}, ray);
        if (chord.empty()) continue;
        reach.begin = std::min(reach.begin, chord.begin);
        reach.end = std::max(reach.end, chord.end);
    }
    return reach.begin < reach.end ? reach : Interval{0, 0};
}

}  // namespace fluovox
