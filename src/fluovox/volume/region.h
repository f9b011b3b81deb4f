#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"

#include <limits>
#include <variant>

namespace fluovox {

/// Convex places in the world where a medium is constant. All lengths in micrometres.
struct Everywhere {};
struct BoxRegion {
    Vec3 min, max;
};
struct SphereRegion {
    Vec3 center;
    double radius = 0;
};
struct CylinderRegion {
    Vec3 from, to;  ///< centres of the two flat ends
    double radius = 0;
};
/// Infinite sideways; a half space where `max` (or `min`) is infinite.
struct SlabRegion {
    int axis = 2;
    double min = 0;
    double max = std::numeric_limits<double>::infinity();
};
using Region = std::variant<Everywhere, BoxRegion, SphereRegion, CylinderRegion, SlabRegion>;

/// The part of `ray` from its origin on that lies in `region`; empty when it misses.
Interval intersect(const Region& region, const Ray& ray);

/// The part of the whole line through `ray`, also behind its origin, that lies in `region`; empty when it misses.
Interval chord_of(const Region& region, const Ray& ray);

/// Unit vector across the surface of `region` at a point on it, outward.
Vec3 surface_normal(const Region& region, Vec3 position_um);

bool contains(const Region& region, Vec3 position_um);

/// A distance from the point, on either side of the surface, within which there is nothing of it; inside the region it
/// is as long as can be.
double clearance(const Region& region, Vec3 position_um);

/// The smallest axis-aligned box around `region`, infinite where the region is.
Bounds bounds_of(const Region& region);

}  // namespace fluovox
