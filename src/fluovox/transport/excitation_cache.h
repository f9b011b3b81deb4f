#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/photon.h"
#include "fluovox/transport/photon_source.h"
#include "fluovox/transport/photon_space.h"
#include "fluovox/transport/voxel_tally.h"

#include <cstdint>
#include <vector>

namespace fluovox {

/// The light that excites each dye after it was scattered, found by photons from the lights and kept as the photons
/// that the dye absorbs per second in each of its own voxels (on cubes of `render.cache_voxel` for a dye in a
/// region). Also what no path to a light can find: light through refracting surfaces, beams without width, uniform
/// light, and the glow of other dyes. Light straight from all other lights is left out.
///
/// What a voxel absorbs is unbiased; where in it, is not known: that is the only bias of what is made of it.
class ExcitationCache {
public:
    /// Throws SceneError where a dye fills an infinite region, the voxels take too much memory, a light cannot be
    /// launched, or the number of scatterings has a limit that cannot be kept.
    explicit ExcitationCache(const Scene& scene);

    /// Forgets what it holds and traces `photons` with the random numbers of batch number `batch`. The same for any
    /// number of threads. Stops early when the user stops `progress`.
    void fill(std::int64_t photons, std::uint64_t batch, Progress& progress);

    /// Photons absorbed per second by the dye of a medium in voxel `in_brick` (z fastest) of a brick of its lattice.
    double absorbed_per_s(std::size_t medium, std::size_t brick, int in_brick) const;

    /// The integral along a flight of the photons that the dye of a medium absorbs, evenly within a voxel, x the weight
    /// that is left; um^-2 s^-1 for a weight of one.
    double absorbed_along(std::size_t medium, const Ray& ray, double length_um, double weight, double absorption) const;

    /// The voxels of a medium that is a dye.
    const VoxelLattice& lattice(std::size_t medium) const {
        return lattices_[static_cast<std::size_t>(places_[medium].lattice)];
    }

    /// True when the light that comes straight from this light is not in the cache.
    bool leaves_out_direct(std::size_t light) const { return direct_[light]; }

    /// Spacing for dyes in regions, where the scene does not say: this share of the region's longest side.
    static constexpr double kDefaultVoxelShare = 1.0 / 128;

    /// How often the light in it may have been scattered.
    std::int64_t most_scatterings() const { return limits_.scatterings; }

    std::size_t bytes() const;
    std::int64_t bound_violations() const { return bound_violations_; }

private:
    struct Place {
        int lattice = -1;  // -1: not a dye
        int field = 0;
    };

    void add_place(std::size_t medium, VoxelLattice lattice);

    const Scene* scene_;
    PhotonSpace space_;
    PhotonSource source_;
    std::vector<bool> direct_;  // per light
    PhotonLimits limits_;
    std::vector<Place> places_;            // per medium
    std::vector<VoxelLattice> lattices_;   // those that differ
    std::vector<std::vector<int>> media_;  // per lattice: the medium of each field
    std::vector<VoxelTally> tallies_;      // per lattice
    std::vector<double> scale_;            // per lattice: from sums to photons per second
    std::int64_t photons_ = -1;            // that the tallies have room for
    std::int64_t bound_violations_ = 0;
};

/// Concentration of a medium's dye at a point, umol/L: trilinear, or even in its region without those that replace it.
double dye_uM(const Scene& scene, std::size_t medium, Vec3 position_um);

/// A number that is this concentration on average: of a grid the value of one voxel nearby, by SparseGrid::tap.
double tapped_dye_uM(const Scene& scene, std::size_t medium, Vec3 position_um, Rng& rng);

}  // namespace fluovox
