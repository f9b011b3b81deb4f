#include "fluovox/voxelize/capsule_tile.h"

#include "fluovox/voxelize/sub_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace fluovox {
namespace {

/// Where a line is inside; empty when `begin >= end`.
struct Stretch {
    double begin = std::numeric_limits<double>::infinity();
    double end = -std::numeric_limits<double>::infinity();

    void add(double x) {
        begin = std::min(begin, x);
        end = std::max(end, x);
    }
};

void add_ball(Stretch& stretch, const Vec3& center, double radius, double y, double z) {
    const double dy = y - center.y;
    const double dz = z - center.z;
    const double rest = radius * radius - dy * dy - dz * dz;
    if (rest < 0) return;
    stretch.add(center.x - std::sqrt(rest));
    stretch.add(center.x + std::sqrt(rest));
}

/// The same for a slice of a soma: the disc at s of the way has its centre at from + s axis.
Stretch cut_frustum(const Capsule& slice, double y, double z) {
    Stretch stretch;
    const Vec3 axis = slice.to - slice.from;
    const double height = dot(axis, slice.normal);
    if (height == 0) return stretch;
    const Vec3 o = Vec3{slice.from.x, y, z} - slice.from;
    // At t along the line: s = s0 + s1 t, the distance from the disc's centre |w0 + w1 t|, its radius r0 + r1 t.
    const double s0 = dot(o, slice.normal) / height;
    const double s1 = slice.normal.x / height;
    const Vec3 w0 = o - s0 * axis;
    const Vec3 w1 = Vec3{1, 0, 0} - s1 * axis;
    const double grow = slice.to_radius - slice.from_radius;
    const double r0 = slice.from_radius + s0 * grow;
    const double r1 = s1 * grow;
    const double k2 = dot(w1, w1) - r1 * r1;
    const double k1 = dot(w0, w1) - r0 * r1;
    const double k0 = dot(w0, w0) - r0 * r0;
    const auto add_root = [&](double t) {
        const double s = s0 + s1 * t;
        if (s >= 0 && s <= 1) stretch.add(slice.from.x + t);
    };
    const auto add_end = [&](double t) {
        if ((k2 * t + 2 * k1) * t + k0 <= 0) stretch.add(slice.from.x + t);
    };
    if (std::abs(s1) > 1e-12) {
        add_end(-s0 / s1);
        add_end((1 - s0) / s1);
    }
    if (std::abs(k2) < 1e-12) {
        if (k1 != 0) add_root(-k0 / (2 * k1));
        return stretch;
    }
    const double h = k1 * k1 - k0 * k2;
    if (h < 0) return stretch;
    add_root((-std::sqrt(h) - k1) / k2);
    add_root((std::sqrt(h) - k1) / k2);
    return stretch;
}

/// The part of a line along x at (y, z) inside a capsule. The capsule is convex, so the hull of the part in either
/// ball and of the points where the line crosses the cone between them is all of it.
Stretch cut_capsule(const Capsule& capsule, double y, double z) {
    if (capsule.is_frustum()) return cut_frustum(capsule, y, z);
    Stretch stretch;
    add_ball(stretch, capsule.from, capsule.from_radius, y, z);
    add_ball(stretch, capsule.to, capsule.to_radius, y, z);
    const Vec3 axis = capsule.to - capsule.from;
    const double shrink = capsule.from_radius - capsule.to_radius;
    const double squared = dot(axis, axis);
    const double cone = squared - shrink * shrink;
    if (!(cone > 0)) return stretch;  // one ball holds the other
    // |p - (from + s axis)| is the radius at s on the cone that touches both balls; with p = o + t (1, 0, 0) this is
    // k2 t^2 + 2 k1 t + k0 = 0. The line starts near the capsule, since the terms grow with the distance.
    const double start = capsule.from.x;
    const Vec3 o = Vec3{start, y, z} - capsule.from;
    const double along = dot(axis, o);
    const double reach = shrink * capsule.from_radius;
    const double k2 = cone - axis.x * axis.x;
    const double k1 = cone * o.x - along * axis.x + axis.x * reach;
    const double k0 =
        cone * dot(o, o) - along * along + 2 * along * reach - squared * capsule.from_radius * capsule.from_radius;
    const auto add = [&](double t) {
        const double place = along - reach + t * axis.x;  // 0 where the cone leaves one ball, `cone` at the other
        if (place > 0 && place < cone) stretch.add(start + t);
    };
    if (std::abs(k2) < 1e-12 * cone) {
        if (k1 != 0) add(-k0 / (2 * k1));
        return stretch;
    }
    const double h = k1 * k1 - k0 * k2;
    if (h < 0) return stretch;
    add((-std::sqrt(h) - k1) / k2);
    add((std::sqrt(h) - k1) / k2);
    return stretch;
}

/// What is inside along one line. Segments that follow each other mostly overlap, so they join as they come, and
/// memory goes by the line's length and not by their number.
class InsideLine {
public:
    void add(const Stretch& stretch) {
        if (!parts_.empty() && join(parts_.back(), stretch)) return;
        if (parts_.size() >= limit_) {
            tidy();
            limit_ = std::max(limit_, 2 * parts_.size());
        }
        parts_.push_back(stretch);
    }
    /// In order, apart from each other.
    const std::vector<Stretch>& tidy() {
        std::sort(parts_.begin(), parts_.end(), [](const Stretch& a, const Stretch& b) { return a.begin < b.begin; });
        std::size_t kept = 0;
        for (std::size_t i = 1; i < parts_.size(); ++i)
            if (!join(parts_[kept], parts_[i])) parts_[++kept] = parts_[i];
        if (!parts_.empty()) parts_.resize(kept + 1);
        return parts_;
    }

private:
    static bool join(Stretch& into, const Stretch& more) {
        if (more.begin > into.end || more.end < into.begin) return false;
        into.begin = std::min(into.begin, more.begin);
        into.end = std::max(into.end, more.end);
        return true;
    }

    std::vector<Stretch> parts_;
    std::size_t limit_ = 64;
};

std::vector<InsideLine> cut_lines(const std::vector<Capsule>& capsules, const TileTask& task) {
    std::vector<InsideLine> found(static_cast<std::size_t>(kBlockSide * kBlockSide * kSubLines));
    for (const std::uint32_t* item = task.begin; item != task.end; ++item) {
        const Capsule& capsule = capsules[*item];
        const Bounds box = capsule_bounds(capsule);
        const auto range = [](double low, double high, int origin) {
            return std::pair(std::max(0, static_cast<int>(std::floor(low)) - origin),
                             std::min(kBlockSide - 1, static_cast<int>(std::floor(high)) - origin));
        };
        const auto [y0, y1] = range(box.min.y, box.max.y, kBlockSide * task.y);
        const auto [z0, z1] = range(box.min.z, box.max.z, kBlockSide * task.z);
        for (int y = y0; y <= y1; ++y) {
            for (int z = z0; z <= z1; ++z) {
                const auto first = static_cast<std::uint32_t>((y * kBlockSide + z) * kSubLines);
                for (std::uint32_t n = 0; n < kSubLines; ++n) {
                    const auto [at_y, at_z] = sub_line_place(task, first + n);
                    const Stretch stretch = cut_capsule(capsule, at_y, at_z);
                    if (stretch.begin < stretch.end) found[first + n].add(stretch);
                }
            }
        }
    }
    return found;
}

}  // namespace

Bounds capsule_bounds(const Capsule& capsule) {
    Bounds bounds;
    for (const auto& [center, radius] :
         {std::pair(capsule.from, capsule.from_radius), std::pair(capsule.to, capsule.to_radius)}) {
        Vec3 reach = {radius, radius, radius};
        if (capsule.is_frustum()) {
            for (int axis = 0; axis < 3; ++axis)
                reach[axis] *= std::sqrt(std::max(0.0, 1 - capsule.normal[axis] * capsule.normal[axis]));
        }
        bounds.add(center - reach);
        bounds.add(center + reach);
    }
    return bounds;
}

double capsule_area(const Capsule& capsule) {
    const double radius = std::max(capsule.from_radius, capsule.to_radius);
    return 2 * std::numbers::pi * radius * (length(capsule.to - capsule.from) + 2 * radius);
}

TileResult fill_capsule_tile(const std::vector<Capsule>& capsules, const TileTask& task) {
    std::vector<InsideLine> lines = cut_lines(capsules, task);
    // Each end of a stretch is a little surface across its line.
    std::vector<Piece> pieces;
    const auto add = [&](std::uint32_t line, double x, double sign) {
        const double cell = std::floor(x);
        pieces.push_back({static_cast<std::int32_t>(cell), static_cast<std::uint16_t>(line / kSubLines),
                          sign * (cell + 1 - x) / kSubLines, sign / kSubLines});
    };
    for (std::uint32_t line = 0; line < lines.size(); ++line) {
        for (const Stretch& inside : lines[line].tidy()) {
            add(line, inside.begin, 1);
            add(line, inside.end, -1);
        }
    }
    return sweep_tile(task, pieces);
}

}  // namespace fluovox
