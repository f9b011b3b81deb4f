#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/interval.h"
#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/volume/brick_field.h"
#include "fluovox/volume/sparse_grid.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

namespace fluovox {

/// Where a VoxelTally counts: voxels of any affine lattice, in bricks of 8^3, of which some may be left out.
struct VoxelLattice {
    /// One bit for each voxel of a brick, z fastest.
    using Mask = std::array<std::uint64_t, 8>;

    Affine world_from_index;
    std::vector<Voxel> bricks;  ///< first voxels
    std::vector<Mask> masks;    ///< per brick: the voxels that count; empty: all do

    /// Cubes of `voxel_um` that fill a finite box from its lowest corner.
    static VoxelLattice filling(const Bounds& box, double voxel_um);
    /// The voxels of a grid, by bricks that hold any value or are next to one.
    static VoxelLattice of(const SparseGrid& grid);
    /// Of these only the voxels in which the trilinear values of the grid are not zero everywhere.
    static VoxelLattice with_values(const SparseGrid& grid);

    bool counts(std::size_t brick, int in_brick) const {
        return masks.empty() || (masks[brick][static_cast<std::size_t>(in_brick >> 6)] >> (in_brick & 63) & 1U) != 0;
    }

    double voxel_volume_um3() const;

    friend bool operator==(const VoxelLattice& a, const VoxelLattice& b);
};

/// Sums over voxels that many threads add to. They are integers (fixed point), so the order of adding does not matter;
/// rounding is drawn at random, so it does not bias however small a share is.
class VoxelTally {
public:
    /// `photons`: how many will be launched at most; fixes the size of the smallest share.
    VoxelTally(VoxelLattice lattice, int fields, double photons);

    /// All sums are zero again. Not while others add to it.
    void clear();

    /// One field that gets `factor` of the integral of the weight along a flight, micrometres.
    struct Share {
        int field = 0;
        double factor = 0;
    };

    /// A flight on which the weight falls as exp(-absorption t).
    struct FadingFlight {
        Ray ray;
        double length_um = 0;  ///< may be infinite
        double weight = 0;     ///< at its beginning
        double absorption_per_um = 0;
    };

    /// Adds to every field of `shares` in each voxel that is flown through.
    void add_flight(const FadingFlight& flight, const std::vector<Share>& shares, Rng& rng);
    /// The same with factors that vary in space: `at(share, position)` is one more, asked in each voxel at a place of
    /// the flight that is drawn in proportion to the weight.
    using FactorAt = std::function<double(const Share&, Vec3)>;
    void add_flight(const FadingFlight& flight, const std::vector<Share>& shares, const FactorAt& at, Rng& rng);
    /// Something that happened at one place.
    void add_point(Vec3 position_um, int field, double amount, Rng& rng);

    /// Calls `visit(brick, in_brick, stretch)` for each voxel that a ray passes within `length_um`, in order.
    using Visit = std::function<void(std::size_t brick, int in_brick, Interval stretch)>;
    void for_each_voxel(const Ray& ray, double length_um, const Visit& visit) const;

    /// The sum of one field in the voxel of a position; 0 beside all voxels. Not while others add to it.
    double at(Vec3 position_um, int field) const;
    /// The same of voxel `in_brick` (z fastest) of a brick of the lattice.
    double at(std::size_t brick, int in_brick, int field) const;
    /// The sums of one field times `factor`.
    BrickField field(int field, double factor) const;
    double voxel_volume_um3() const { return volume_; }
    std::size_t bytes() const;
    /// What a tally would take.
    static double bytes(const VoxelLattice& lattice, int fields);

private:
    template <class AddShares>
    void add_stretches(const FadingFlight& flight, const AddShares& add);
    template <class Function>
    void walk(const Ray& ray, double length_um, const Function& visit) const;
    std::size_t cube_at(Voxel place) const;
    static std::size_t place_in_cube(Voxel place);
    // Of the sum of a voxel in each field; -1 beside all voxels.
    std::int64_t slot(int x, int y, int z) const;
    std::int64_t slot(Vec3 position_um) const;
    void add(std::int64_t slot, int field, double amount, Rng& rng);

    VoxelLattice lattice_;
    Affine index_from_world_;
    double volume_ = 0;  // of a voxel
    double units_ = 0;   // of fixed point in one voxel size of path
    int fields_ = 0;
    // The box of all bricks is divided into cubes of kCube^3, so that one that is almost empty costs little.
    static constexpr int kCube = 16;
    static constexpr std::size_t kBricksPerCube = std::size_t{kCube} * kCube * kCube;
    Voxel first_, count_;              // box of bricks
    Voxel cubes_;                      // along it
    std::vector<std::int32_t> cube_;   // in that box, by place: one in `brick_`; -1: no brick is in it
    std::vector<std::int32_t> brick_;  // per cube and place in it; -1: left out
    std::size_t per_field_ = 0;
    std::vector<std::atomic<std::int64_t>> sums_;
};

}  // namespace fluovox
