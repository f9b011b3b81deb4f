#include "fluovox/transport/photon_space.h"

#include "fluovox/volume/region_nesting.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

constexpr Inside bit(std::size_t i) {
    return Inside{1} << i;
}

double volume_of(const Region& region) {
    if (const auto* sphere = std::get_if<SphereRegion>(&region))
        return 4.0 / 3 * std::numbers::pi * sphere->radius * sphere->radius * sphere->radius;
    if (const auto* cylinder = std::get_if<CylinderRegion>(&region))
        return std::numbers::pi * cylinder->radius * cylinder->radius * length(cylinder->to - cylinder->from);
    if (const auto* slab = std::get_if<SlabRegion>(&region)) {
        // Infinite as they are, thin slabs lie within thick ones and everything finite within both.
        return 1e100 * std::min(slab->max - slab->min, 1e100);
    }
    const Vec3 size = bounds_of(region).size();
    return size.x * size.y * size.z;
}

SourceLocation place(const Scene& scene, std::size_t medium) {
    const auto& media = scene.description.media;
    return medium < media.size() ? media[medium].where : SourceLocation{scene.description.file, 1, 1};
}

// The box of a grid, as the surface of a medium with an index.
Region box_of_grid(const SourceLocation& where, const SparseGrid& grid) {
    const Bounds box = grid.bounds();
    if (grid.background() > 0) {
        throw SceneError(where,
                         "refractive_index: this grid has values everywhere (a background), so it has no surface; give "
                         "the index to a region around it");
    }
    for (const Vec3& row : grid.world_from_index().rows) {
        const int used = (row.x != 0 ? 1 : 0) + (row.y != 0 ? 1 : 0) + (row.z != 0 ? 1 : 0);
        if (used > 1) {
            throw SceneError(where,
                             "refractive_index: the surface of a grid is its box, which must lie along the axes; this "
                             "grid is rotated. Give the index to a region around it");
        }
    }
    return BoxRegion{box.min, box.max};
}

}  // namespace

PhotonSpace::PhotonSpace(const Scene& scene) : scene_(&scene) {
    for (std::size_t i = 0; i < scene.media.size(); ++i)
        add(scene, i);
    if (surfaces_.size() > static_cast<std::size_t>(kMaxSurfaces)) {
        throw SceneError(place(scene, kMaxSurfaces),
                         fmt::format("more than {} regions; write many small bodies into a grid", kMaxSurfaces));
    }
    if (bounds_.empty()) bounds_ = {{0, 0, 0}, {0, 0, 0}};
    if (refracts_) require_nested(scene);
}

void PhotonSpace::add(const Scene& scene, std::size_t i) {
    const SceneMedium& medium = scene.media[i];
    const std::optional<double> index = medium.refractive_index;
    Region region = medium.region;
    if (medium.grid) {
        const double far = medium.grid->background() > 0 ? kFar : 0;
        bounds_.add({medium.grid->bounds().min - Vec3{far, far, far}, medium.grid->bounds().max + Vec3{far, far, far}});
        if (!index) return;
        region = box_of_grid(place(scene, i), *medium.grid);
    } else {
        bounds_.add(bounds_of(region));
    }
    if (std::holds_alternative<Everywhere>(region) && surfaces_.size() < kMaxSurfaces)
        everywhere_ |= bit(surfaces_.size());
    refracts_ = refracts_ || index.has_value();
    surfaces_.push_back({region, static_cast<int>(i), index.value_or(0), volume_of(region), !medium.grid});
}

void PhotonSpace::require_nested(const Scene& scene) const {
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        for (std::size_t j = i + 1; j < surfaces_.size(); ++j) {
            const Surface& a = surfaces_[i];
            const Surface& b = surfaces_[j];
            if (a.index == 0 || b.index == 0 || a.index == b.index) continue;
            const char* const conflict = index_conflict(a.region, b.region);
            if (conflict == nullptr) continue;
            const auto at = static_cast<std::size_t>(b.medium);
            throw SceneError(place(scene, at),
                             fmt::format("\"{}\" and \"{}\" {}, with different refractive indices ({} and {}); put one "
                                         "wholly inside the other, or let them only touch",
                                         scene.media[static_cast<std::size_t>(a.medium)].name, scene.media[at].name,
                                         conflict, a.index, b.index));
        }
    }
}

Inside PhotonSpace::inside_at(const Ray& ray) const {
    Inside inside = everywhere_;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        const Interval chord = chord_of(surfaces_[i].region, ray);
        if (chord.begin < -1e-9 && chord.end > 1e-9) inside |= bit(i);
    }
    return inside;
}

PhotonSpace::Crossing PhotonSpace::next_crossing(const Ray& ray, Inside inside) const {
    Crossing nearest{kFar, 0};
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        const Inside mask = bit(i);
        if ((everywhere_ & mask) != 0) continue;
        const Interval chord = chord_of(surfaces_[i].region, ray);
        double t = kFar;
        if ((inside & mask) != 0) {
            t = std::max(chord.end, 0.0);
        } else if (chord.begin < chord.end && chord.begin + chord.end > 0) {
            // Outside a convex region its chord lies all ahead or all behind; its middle tells which.
            t = std::max(chord.begin, 0.0);
        }
        if (t < nearest.t_um - kSame_um) {
            nearest = {t, mask};
        } else if (t <= nearest.t_um + kSame_um && t < kFar) {
            nearest.t_um = std::min(t, nearest.t_um);
            nearest.changed |= mask;
        }
    }
    return nearest;
}

double PhotonSpace::clearance(Vec3 position_um) const {
    double nearest = kFar;
    for (const Surface& surface : surfaces_)
        nearest = std::min(nearest, fluovox::clearance(surface.region, position_um));
    return nearest;
}

Vec3 PhotonSpace::normal(Inside changed, Vec3 position_um) const {
    // Of surfaces that coincide, the one with an index gives the shape.
    const Surface* shape = nullptr;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        if ((changed & bit(i)) == 0) continue;
        if (shape == nullptr || (shape->index == 0 && surfaces_[i].index > 0)) shape = &surfaces_[i];
    }
    return shape == nullptr ? Vec3{0, 0, 1} : surface_normal(shape->region, position_um);
}

// Of two that are nested. Infinite ones cannot be told by their volume.
bool PhotonSpace::is_inner(const Surface& a, const Surface& b) {
    const auto* const slab_a = std::get_if<SlabRegion>(&a.region);
    const auto* const slab_b = std::get_if<SlabRegion>(&b.region);
    if (slab_a == nullptr || slab_b == nullptr) return a.volume < b.volume;
    return nesting_of(a.region, b.region) == Nesting::FirstInSecond;
}

double PhotonSpace::refractive_index(Inside inside) const {
    const Surface* inner = nullptr;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        const Surface& surface = surfaces_[i];
        if ((inside & bit(i)) == 0 || surface.index == 0) continue;
        if (inner == nullptr || is_inner(surface, *inner)) inner = &surface;
    }
    return inner == nullptr ? 1 : inner->index;
}

std::vector<int> PhotonSpace::media(Inside inside) const {
    std::vector<int> all;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        if ((inside & bit(i)) != 0 && surfaces_[i].constant) all.push_back(surfaces_[i].medium);
    }
    std::vector<int> left;
    for (const int medium : all) {
        const std::vector<int>& replacing = scene_->media[static_cast<std::size_t>(medium)].cut_by;
        const bool replaced = std::any_of(replacing.begin(), replacing.end(), [&](int other) {
            return std::find(all.begin(), all.end(), other) != all.end();
        });
        if (!replaced) left.push_back(medium);
    }
    return left;
}

double fresnel_reflectance(double n1, double n2, double cosine, double& transmitted_cosine) {
    const double ratio = n1 / n2;
    const double sine_squared = ratio * ratio * std::max(0.0, 1 - cosine * cosine);
    transmitted_cosine = 0;
    if (sine_squared >= 1) return 1;
    transmitted_cosine = std::sqrt(1 - sine_squared);
    const double s = (n1 * cosine - n2 * transmitted_cosine) / (n1 * cosine + n2 * transmitted_cosine);
    const double p = (n1 * transmitted_cosine - n2 * cosine) / (n1 * transmitted_cosine + n2 * cosine);
    return 0.5 * (s * s + p * p);
}

}  // namespace fluovox
