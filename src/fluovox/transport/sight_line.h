#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/transport/excitation_cache.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/optical_field.h"

#include <vector>

namespace fluovox {

/// The dye grids that a ray passes, voxel by voxel, and how much light each place is likely to send along the ray: the
/// excitation in the cache plus what comes straight from the lights, times concentration, emission and transmittance.
/// From all places one is drawn in proportion to that (resampled importance sampling: Talbot, Cline & Egbert, EGSR
/// 2005), so what is lit and what holds dye is found in one step.
class SightLine {
public:
    /// A place drawn evenly from a step of about one voxel.
    struct Place {
        double t_um = 0;
        double step_um = 0;
        double uM = 0;      ///< of the medium's dye, one stochastic tap
        double likely = 0;  ///< what it was drawn in proportion to: any unit, positive
        std::size_t medium = 0;
    };

    SightLine(const Scene& scene, const Illumination& illumination, const ExcitationCache& cache);

    /// Rebuilds it for a ray; the storage is kept. `brightness`: of each dye, in any unit.
    void build(OpticalField& field, const std::vector<double>& brightness, const Ray& ray,
               const std::vector<MediumSpan>& spans, const PathOptics& optics, Rng& rng);

    /// Sum of `likely` over all places; zero: no dye in sight.
    double total() const { return total_; }
    /// Draws a place; `u` uniform in [0, 1). Not when the total is zero.
    const Place& choose(double u) const;

private:
    double excitation(std::size_t medium, Vec3 position_um) const;

    const Scene* scene_;
    const Illumination* illumination_;
    const ExcitationCache* cache_;
    std::vector<Place> places_;
    double total_ = 0;
};

}  // namespace fluovox
