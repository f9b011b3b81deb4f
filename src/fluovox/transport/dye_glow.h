#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/core/rng.h"
#include "fluovox/optics/camera_ray.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/excitation_cache.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/optical_field.h"
#include "fluovox/transport/photon.h"
#include "fluovox/transport/photon_space.h"

#include <cstdint>
#include <vector>

namespace fluovox {

/// Photons that leave the dyes, drawn where dyes glow: virtual point lights (Keller, SIGGRAPH 1997) of which there is
/// one in each voxel that holds dye, at a place drawn anew for each batch or photon. Which of them a photon leaves is
/// drawn in proportion to its concentration, its excitation in the cache and straight from the lights, and whether the
/// camera has it in view (resampled importance sampling: Talbot, Cline & Egbert, EGSR 2005); what it weighs is unbiased
/// but for what the cache brings in.
class DyeGlow {
public:
    /// What is wanted: `film` says which emitted light is of use.
    DyeGlow(const Scene& scene, const PhotonSpace& space, const Illumination& illumination,
            const ExcitationCache& cache);

    /// Draws the places of a batch of about `photons` photons, with random numbers of its own. The same for any number
    /// of threads. Returns early, with what must not be used, when the user stops `progress`.
    void place(std::uint64_t batch, std::int64_t photons, const Progress& progress);

    /// False when nothing glows.
    bool glows() const { return !places_.empty(); }

    struct Emission {
        Photon photon;           ///< its weight: photons per second, of which `of_all` photons are drawn
        bool scattered = false;  ///< the light that excited it was
    };
    /// Photon number `n` of `of_all`, spread evenly over all that glows, without a direction yet. Weight zero: nothing
    /// got there.
    Emission emit(std::int64_t n, std::int64_t of_all, OpticalField& field, Rng& rng) const;

private:
    // The dye of one medium, and where it may be.
    struct Source {
        std::size_t medium = 0, dye = 0;
        const VoxelLattice* lattice = nullptr;
        std::vector<std::int64_t> first;  // number of the first voxel of each brick, and one past the last
        double volume_um3 = 0;            // of a voxel
        std::vector<double> weights;      // for Illumination: this dye alone
    };
    // What excites a dye straight from one light: stands in for all its wavelengths where only choosing matters.
    struct Direct {
        double uptake = 0;
        PathOptics optics;
    };
    struct Place {
        Vec3 position;              // straight from the lights; else it is drawn in the voxel for each photon
        double uM = 0;              // there
        double volume_um3 = 0;      // that it stands for
        double absorbed_per_s = 0;  // as of the cache; negative: what comes straight from the lights, instead
        std::uint32_t brick = 0;
        int in_brick = 0;
        double likely = 0;  // what it is drawn in proportion to; then the sum up to here
        std::size_t source = 0;
    };

    // A voxel of a source.
    struct Cell {
        std::size_t brick = 0;
        int in_brick = 0;
        std::int64_t number = 0;  // of all voxels of the source
    };

    // How a batch draws its places.
    struct Draw {
        std::uint64_t batch = 0;
        double one_in = 1;  // voxels that a place straight from the lights stands for
        double offset = 0;  // of the first of them
    };
    void add_places(const Source& source, std::size_t brick, const Draw& draw, OpticalField& field,
                    std::vector<Place>& places) const;
    Vec3 position_of_dye(const Source& source, std::size_t brick, int in_brick, Rng& rng) const;
    static Vec3 position_in(const Source& source, std::size_t brick, int in_brick, Rng& rng);
    double use_of(const Source& source, Vec3 position_um, Rng& rng) const;
    double likely_direct(const Source& source, Vec3 position_um, OpticalField& field,
                         std::vector<MediumSpan>& spans) const;
    double direct(const Source& source, Vec3 position_um, OpticalField& field, Rng& rng) const;

    const Scene* scene_;
    const PhotonSpace* space_;
    const Illumination* illumination_;
    const ExcitationCache* cache_;
    CameraRays camera_;
    std::vector<Spectrum> seen_emission_;  // per dye
    std::vector<Source> sources_;
    std::vector<std::vector<Direct>> direct_;  // per dye and light
    std::vector<Place> places_;
    double offset_ = 0;
};

}  // namespace fluovox
