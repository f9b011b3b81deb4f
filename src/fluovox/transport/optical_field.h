#pragma once

#include "fluovox/core/interval.h"
#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/scene/scene.h"
#include "fluovox/spectral/lanes.h"
#include "fluovox/transport/grid_tracking.h"
#include "fluovox/volume/vdb_sampler.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace fluovox {

class PlainWalk;

/// Coefficients of every medium at the wavelengths of a path, per micrometre: times the amount where the medium is
/// constant, per unit of its grid's value where it is not.
struct PathOptics {
    struct MediumLanes {
        explicit MediumLanes(int count) : scattering(count), absorption(count), extinction(count) {}

        Lanes scattering, absorption, extinction;
        double max_scattering = 0, max_absorption = 0, max_extinction = 0;  ///< over the lanes: for the bounds
    };

    Wavelengths wavelengths;
    std::vector<MediumLanes> media;
    bool grey_scattering = true;  ///< every lane scatters alike, so all of them steer the path the same way
};

/// Part of a ray on which a constant medium lies.
struct MediumSpan {
    Interval span;
    int medium = 0;
};

/// Which part of the extinction takes light away.
enum class Loss { Absorption, Extinction };

/// Where and in which medium a path scatters.
struct Scattering {
    double t_um = 0;
    int medium = 0;
};

/// Optical depth of constant media from a ray's origin to `end_um`, at the hero wavelength.
double hero_depth(const std::vector<MediumSpan>& spans, const PathOptics& optics, double end_um);

/// The media of a scene along rays: constant ones are handled analytically, grids by tracking against their bounds.
/// One per thread, since it counts what it does.
class OpticalField {
public:
    explicit OpticalField(const Scene& scene);

    PathOptics optics(const Wavelengths& wavelengths) const;
    /// The same into `optics`, whose storage is kept.
    void set_optics(const Wavelengths& wavelengths, PathOptics& optics) const;

    /// Where the constant media lie along a ray.
    void gather(const Ray& ray, std::vector<MediumSpan>& spans) const;

    /// Unbiased estimate of the share of light that gets from the ray's origin to `end_um`, for each lane: exact for
    /// constant media, ratio tracking for grids (Novak et al., ACM Trans. Graph. 33 (2014) 179).
    Lanes transmittance(const Ray& ray, const std::vector<MediumSpan>& spans, double end_um, const PathOptics& optics,
                        Loss loss, Rng& rng);

    /// Draws the next scattering by the coefficients of the hero wavelength (lane 0): the nearest of what each
    /// medium draws for itself; nothing when the path leaves. `likeness` becomes, for each lane, how likely that
    /// outcome is for its own wavelength relative to the hero's.
    std::optional<Scattering> sample_scattering(const Ray& ray, const std::vector<MediumSpan>& spans,
                                                const PathOptics& optics, Rng& rng, Lanes& likeness);

    /// Scattering of all media at a point of a ray, per lane; one stochastic tap per grid.
    Lanes scattering_at(const Ray& ray, double t_um, const std::vector<MediumSpan>& spans, const PathOptics& optics,
                        std::vector<Lanes>& by_medium, Rng& rng);

    /// Density (per um) with which `sample_scattering` chooses the point `t_um`, for each lane. Exact for constant
    /// media, a stand-in for grids: to be used only as a weight that is the same however the point was found.
    Lanes scattering_density(const Ray& ray, double t_um, const std::vector<MediumSpan>& spans,
                             const PathOptics& optics) const;

    /// Concentrations (umol/L) of each medium that is a dye at a point of a ray; false when there is none.
    bool concentrations(const Ray& ray, double t_um, const std::vector<MediumSpan>& spans, std::vector<double>& uM,
                        Rng& rng);

    /// The part of the ray beyond which there is no medium at all.
    Interval reach(const Ray& ray, const std::vector<MediumSpan>& spans) const;

    /// The same for one wavelength (lane 0), with one grid and coefficient: see grid_tracking.h.
    GridCollision first_collision(int medium, const Ray& ray, double end_um, double coefficient, Rng& rng);
    /// `dim`: see RatioTracking.
    double ratio_transmittance(int medium, const Ray& ray, double end_um, double coefficient, double dim, Rng& rng);
    /// The same to the end of the grid, which must have a directory of bricks: without noise, but where hardly any
    /// light gets through. Takes many times as long.
    double precise_transmittance(int medium, const Ray& ray, double coefficient, Rng& rng);

    const Scene& scene() const { return *scene_; }
    /// Indices of the media with a grid.
    const std::vector<int>& gridded() const { return gridded_; }
    bool has_constant() const { return !constant_.empty(); }
    TrackingCounts& counts() { return counts_; }

private:
    // Value of a medium's grid at a place in the world, or what has that expectation; counted.
    double value_at(int medium, Vec3 world_um, Rng& rng);
    PlainWalk plain_walk(int medium, const Ray& ray, Interval span) const;
    template <class Tracking>
    void track(int medium, const Ray& ray, double end_um, double coefficient, Tracking& tracking) const;
    template <class Walk>
    void ratio_track(Walk walk, const Lanes& coefficient, double most, Rng& rng, Lanes& transmittance);
    template <class Walk>
    void delta_track(Walk walk, int medium, const PathOptics& optics, Rng& rng, std::optional<Scattering>& nearest,
                     Lanes& likeness);

    // A grid by the way it is tracked in the inner loops.
    struct Way {
        enum class Kind { None, Plain, Majorants, Bricks } kind = Kind::None;
        const SparseGrid* grid = nullptr;
        std::unique_ptr<VdbSampler> sampler;  // of the grid's tree, for plain tracking
    };

    const Scene* scene_;
    bool plain_;                           // tracks by PlainWalk
    std::vector<int> constant_, gridded_;  // indices of media
    std::vector<Way> ways_;                // per medium
    TrackingCounts counts_;
};

}  // namespace fluovox
