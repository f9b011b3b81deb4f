#include "fluovox/voxelize/capsule_merge.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

namespace fluovox {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// A ball at the end of capsules.
struct End {
    Vec3 center;
    double radius = 0;

    bool operator==(const End& other) const {
        return center.x == other.center.x && center.y == other.center.y && center.z == other.center.z &&
               radius == other.radius;
    }
};

struct EndHash {
    std::size_t operator()(const End& end) const {
        std::uint64_t hash = 0;
        for (const double value : {end.center.x, end.center.y, end.center.z, end.radius}) {
            hash = (hash ^ std::bit_cast<std::uint64_t>(value + 0.0)) * 0x9e3779b97f4a7c15ULL;
            hash ^= hash >> 29U;
        }
        return hash;
    }
};

/// The capsule that goes on where each one ends; every capsule goes on from one at most.
std::vector<std::uint32_t> find_next(const std::vector<Capsule>& capsules, std::vector<bool>& goes_on) {
    std::unordered_map<End, std::uint32_t, EndHash> starts;
    starts.reserve(capsules.size());
    for (std::uint32_t i = 0; i < capsules.size(); ++i)
        if (!capsules[i].is_frustum()) starts.emplace(End{capsules[i].from, capsules[i].from_radius}, i);
    std::vector<std::uint32_t> next(capsules.size(), kNone);
    for (std::uint32_t i = 0; i < capsules.size(); ++i) {
        if (capsules[i].is_frustum()) continue;
        const auto at = starts.find({capsules[i].to, capsules[i].to_radius});
        if (at == starts.end() || at->second == i || goes_on[at->second]) continue;
        next[i] = at->second;
        goes_on[at->second] = true;
    }
    return next;
}

/// A row of balls, each two neighbours joined by a capsule.
class Chain {
public:
    Chain(std::vector<End> ends, double voxel_size) : ends_(std::move(ends)), voxel_size_(voxel_size) {}

    void merge_into(std::vector<Capsule>& capsules) const {
        for (std::size_t at = 0; at + 1 < ends_.size();) {
            const std::size_t reached = farthest(at);
            const End& a = ends_[at];
            const End& b = ends_[reached];
            capsules.push_back({a.center, b.center, a.radius, b.radius});
            at = reached;
        }
    }

private:
    /// The last end that one capsule from `at` does for: steps that double, then halve, so that long rows take little.
    std::size_t farthest(std::size_t at) const {
        std::size_t good = at + 1;
        std::size_t step = 1;
        while (good + step < ends_.size() && fits(at, good + step)) {
            good += step;
            step *= 2;
        }
        for (; step > 0; step /= 2)
            if (good + step < ends_.size() && fits(at, good + step)) good += step;
        return good;
    }

    bool fits(std::size_t first, std::size_t last) const {
        const End& a = ends_[first];
        const End& b = ends_[last];
        const Vec3 axis = b.center - a.center;
        const double squared = dot(axis, axis);
        if (!(squared > 0)) return false;
        double furthest = 0;
        double bias = 0;  // of radius times length
        double total = 0;
        for (std::size_t i = first + 1; i < last; ++i) {
            const End& end = ends_[i];
            const double s = dot(end.center - a.center, axis) / squared;
            // Small parts of the radius, too, as errors of one sign add up over a cable.
            const double near = std::min(0.01 * voxel_size_, 0.002 * end.radius);
            const double alike = std::min(0.01 * voxel_size_, 0.0005 * end.radius);
            const double slack = near / std::sqrt(squared);
            if (s < furthest - slack || s > 1 + slack) return false;  // turns back
            furthest = std::max(furthest, s);
            const double misses = end.radius - (a.radius + s * (b.radius - a.radius));
            if (length(end.center - a.center - s * axis) > near || std::abs(misses) > alike) return false;
            const double share = length(ends_[i + 1].center - ends_[i - 1].center) / 2;
            bias += misses * share;
            total += end.radius * share;
        }
        constexpr double kMostBias = 2e-5;  // half of that in the volume
        return std::abs(bias) <= kMostBias * total;
    }

    std::vector<End> ends_;
    double voxel_size_;
};

}  // namespace

MergedCapsules merge_capsules(const std::vector<Capsule>& capsules, double voxel_size) {
    std::vector<bool> done(capsules.size(), false);
    const std::vector<std::uint32_t> next = find_next(capsules, done);
    std::vector<std::uint32_t> starts;
    for (std::uint32_t i = 0; i < capsules.size(); ++i)
        if (!done[i]) starts.push_back(i);
    done.assign(capsules.size(), false);
    MergedCapsules merged;
    const auto follow = [&](std::uint32_t start) {
        if (done[start]) return;
        const Capsule& capsule = capsules[start];
        if (next[start] == kNone) {
            done[start] = true;
            merged.capsules.push_back(capsule);
            return;
        }
        std::vector<End> ends = {{capsule.from, capsule.from_radius}};
        for (std::uint32_t at = start; at != kNone && !done[at]; at = next[at]) {
            done[at] = true;
            ends.push_back({capsules[at].to, capsules[at].to_radius});
        }
        Chain(std::move(ends), voxel_size).merge_into(merged.capsules);
    };
    for (const std::uint32_t start : starts)
        follow(start);
    for (std::uint32_t i = 0; i < capsules.size(); ++i)  // rings
        follow(i);
    merged.merged_points = capsules.size() - merged.capsules.size();
    return merged;
}

}  // namespace fluovox
