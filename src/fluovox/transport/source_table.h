#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/vec.h"
#include "fluovox/transport/optical_field.h"

#include <vector>

namespace fluovox {

/// Where along a ray dyes may glow, as a density to draw points from: the bounds of the dyes' concentrations times how
/// strongly each is excited and glows at the path's wavelengths, times the transmittance of the constant media back to
/// the ray's origin. Positive wherever there is a dye that glows at one of these wavelengths.
class SourceTable {
public:
    /// Rebuilds the table for a ray; the storage is kept. `brightness`: of each dye at 1 umol/L, in any unit.
    void build(const OpticalField& field, const std::vector<double>& brightness, const Ray& ray,
               const std::vector<MediumSpan>& spans, const PathOptics& optics);

    /// About how much dye the ray sees; zero: none at all.
    double total() const { return total_; }
    double sample(double u) const;
    double pdf(double t_um) const;

private:
    struct Piece {
        Interval span;
        double fall = 0;        // per um: density goes as exp(-fall (t - begin))
        double weight = 0;      // integral of the density over the piece
        double cumulative = 0;  // up to its end
    };

    void add(Piece piece);
    void add_constant(Interval span, double strength, const std::vector<MediumSpan>& spans, const PathOptics& optics);
    void add_grid(const SparseGrid& grid, double per_uM, const Ray& ray, const std::vector<MediumSpan>& spans,
                  const PathOptics& optics);

    std::vector<Piece> pieces_;
    double total_ = 0;
};

}  // namespace fluovox
