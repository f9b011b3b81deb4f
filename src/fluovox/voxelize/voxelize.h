#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/progress.h"
#include "fluovox/volume/dye_grid.h"
#include "fluovox/voxelize/mesh_repair.h"
#include "fluovox/voxelize/morphology.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace fluovox {

/// What decides about inside where a mesh has holes.
enum class InsideRule {
    Auto,     ///< caps over nearly plane holes, the winding number at others
    Stab,     ///< caps over every hole
    Winding,  ///< the generalized winding number (at least 1/2) at every hole
    Flood,    ///< caps over every hole; then all that cannot be reached from outside, cavities included
};

struct VoxelizeSettings {
    double voxel_size_um = 0;
    double value = 1;  ///< of a voxel wholly inside: the concentration
    InsideRule inside = InsideRule::Auto;
    std::optional<Bounds> clip_um;  ///< only this part; voxels at its faces keep the share of them that is inside
    double max_bytes = 8.0 * (1LL << 30);
};

struct VoxelizeReport {
    double volume_um3 = 0;  ///< inside, by the voxels' fractions
    /// Of the surface with all its holes capped, as the voxels see it: overlapping parts count twice. Before any clip.
    double capped_um3 = 0;
    std::uint64_t voxels = 0;              ///< with anything inside
    std::uint64_t decided_by_winding = 0;  ///< of these, by the winding number
    std::uint64_t merged_points = 0;       ///< of morphologies: ends of segments merged as one does for two
    bool caps_only = false;  ///< holes too large for the winding number at this voxel size: they were capped
};

struct VoxelizedGrid {
    DyeGrid grid;
    VoxelizeReport report;
};

/// Fills the union of the solids (in um) with `settings.value`, boundary voxels by the fraction of them that is inside.
/// Voxel (i, j, k) is the cube from (i, j, k) to (i+1, j+1, k+1) times the voxel size, whatever the mesh, so that
/// grids of one voxel size fit together.
///
/// Throws InputError when the grid would be far larger than `max_bytes`, or nothing is inside. Returns what was done
/// so far when `progress` is stopped; ask it.
VoxelizedGrid voxelize(const std::vector<SolidMesh>& solids, const VoxelizeSettings& settings, Progress& progress);

/// The same for the union of capsules (um).
VoxelizedGrid voxelize_capsules(const std::vector<Capsule>& capsules, const VoxelizeSettings& settings,
                                Progress& progress);

/// Fills a layer of `thickness_um` along the surfaces (half of it on either side; caps of holes stay free), each voxel
/// by the fraction of it that the layer takes. The report's `capped_um3` is area times thickness.
VoxelizedGrid voxelize_shell(const std::vector<SolidMesh>& solids, double thickness_um,
                             const VoxelizeSettings& settings, Progress& progress);

/// An estimate from above of the memory that the grid of a solid, or of capsules, takes, in bytes: by surface, not by
/// box.
double estimate_grid_bytes(const Mesh& mesh, double voxel_size_um);
double estimate_grid_bytes(const std::vector<Capsule>& capsules, double voxel_size_um);

/// Throws InputError with the box, the number of voxels and what to do when `bytes` is over `settings.max_bytes`.
void require_affordable(double bytes, const Bounds& bounds_um, const VoxelizeSettings& settings);

}  // namespace fluovox
