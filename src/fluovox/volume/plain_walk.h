#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/region.h"
#include "fluovox/volume/sparse_grid.h"
#include "fluovox/volume/vdb_sampler.h"

#include <algorithm>
#include <array>

namespace fluovox {

/// The reference that MajorantWalk is measured against, in results and in speed, as a textbook has it: one bound, the
/// largest value of the whole grid, over the whole box of the grid, and values interpolated between eight voxels: by
/// OpenVDB in the tree of the file, or, where there was none, each looked up from the root down. Same interface.
class PlainWalk {
public:
    struct Segment {
        double begin = 0, end = 0;  ///< micrometres along the ray
        double bound = 0;           ///< the field is at most this there
    };

    /// `sampler`: of the grid's tree, or null.
    PlainWalk(const SparseGrid& grid, VdbSampler* sampler, const Ray& ray, Interval span)
        : grid_(&grid),
          sampler_(sampler),
          origin_(grid.index_from_world().point(ray.origin)),
          direction_(grid.index_from_world().direction(ray.direction)) {
        Interval box = intersect(BoxRegion{grid.bounds().min, grid.bounds().max}, ray);
        box = {std::clamp(box.begin, span.begin, span.end), std::clamp(box.end, span.begin, span.end)};
        if (box.empty()) box = {span.end, span.end};
        stretches_ = {Segment{span.begin, box.begin, grid.background()}, Segment{box.begin, box.end, grid.max()},
                      Segment{box.end, span.end, grid.background()}};
    }

    /// The next stretch with a positive bound: before the box, in it, behind it.
    bool next(Segment& segment) {
        while (next_ < stretches_.size()) {
            segment = stretches_[next_++];
            if (segment.bound > 0 && segment.begin < segment.end) return true;
        }
        return false;
    }

    Vec3 index_at(double t) const { return origin_ + t * direction_; }
    /// The trilinear value itself; needs no random numbers. What rounding alone puts above the bound of the stretch is
    /// put back; what is more above it is left to be found.
    double tap(double t, std::uint64_t /*bits*/) const {
        constexpr double kRounding = 1e-6;
        const Vec3 at = index_at(t);
        const double value = sampler_ != nullptr ? sampler_->trilinear(at) : grid_->trilinear_from_root(at);
        const double bound = bound_at(t);
        return value > bound && value <= (1 + kRounding) * bound ? bound : value;
    }

private:
    double bound_at(double t) const {
        const Segment& box = stretches_[1];
        return t < box.begin || t > box.end ? stretches_[0].bound : box.bound;
    }

    const SparseGrid* grid_;
    VdbSampler* sampler_;
    Vec3 origin_, direction_;
    std::array<Segment, 3> stretches_;
    std::size_t next_ = 0;
};

}  // namespace fluovox
