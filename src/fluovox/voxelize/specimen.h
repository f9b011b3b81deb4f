#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/voxelize/voxelize.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {

/// Rotation and scale, then a shift: where a mesh stands in the world.
struct Placement {
    std::array<Vec3, 3> rows = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    Vec3 shift_um;

    Vec3 apply(Vec3 p) const { return Vec3{dot(rows[0], p), dot(rows[1], p), dot(rows[2], p)} + shift_um; }
};

/// One mesh or morphology of a specimen.
struct SpecimenPart {
    std::filesystem::path file;
    std::string name;        ///< what messages and reports call it
    double um_per_unit = 0;  ///< of the file's coordinates; 0: what the format says, or um
    Placement placement;
    int label = 0;        ///< in the grid of labels; 0: its number among all parts
    std::string place{};  ///< the line of a table that names it, which errors then begin with; else empty
};

/// What is labelled with one dye at one concentration: the union of its parts.
struct SpecimenGroup {
    std::string dye;  ///< also the name of its grid
    double concentration_uM = 0;
    std::vector<SpecimenPart> parts;
};

/// Where groups of one dye overlap.
enum class OverlapRule { Max, Sum, First, Last };

struct SpecimenSettings {
    VoxelizeSettings voxels;        ///< its `value` is not used; `voxel_size_um` 0: by `resolution`
    int resolution = 0;             ///< voxels along the longest side of everything
    std::optional<Bounds> bbox_um;  ///< the box that `resolution` means, instead of everything's own
    OverlapRule overlap = OverlapRule::Max;
    double shell_um = 0;  ///< above 0: a layer this thick along the surface instead of the inside
    bool half = false;    ///< 16 bits a value in the file
    bool labels = false;  ///< a grid of labels as well; each group should then have one part
    bool strict = false;  ///< damaged meshes are refused
};

/// What one label of a segmentation came to.
struct SegmentReport {
    std::uint64_t label = 0;
    std::uint64_t voxels = 0;
    double volume_um3 = 0;
};

/// What became of one part.
struct PartReport {
    std::string name;
    std::string sha256;
    int label = 0;                               ///< in the grid of labels
    std::string unit_doubt;                      ///< why the unit of its lengths is hardly the one taken; else empty
    MeshReport mesh;                             ///< of a mesh
    std::optional<MorphologyReport> morphology;  ///< of an SWC or ASC file instead
    std::optional<SegmentReport> segment;        ///< of a label of a segmentation instead
};

/// What became of one group.
struct GroupReport {
    std::string dye;
    double concentration_uM = 0;
    std::vector<PartReport> parts;
    VoxelizeReport voxels;
    double seconds = 0;          ///< all of it, by the clock
    double reading_seconds = 0;  ///< of these, until the files were meshes
};

struct SpecimenResult {
    double voxel_size_um = 0;
    std::vector<DyeGrid> grids;  ///< one a dye, described and named
    std::vector<GroupReport> groups;
    std::vector<std::string> remarks;  ///< that the user should hear
};

/// Reads, repairs and fills all groups. Meshes are read when their group is filled and forgotten afterwards. Throws
/// InputError. Ask `progress` whether it was stopped: the result is then not whole.
SpecimenResult voxelize_specimen(const std::vector<SpecimenGroup>& groups, const SpecimenSettings& settings,
                                 Progress& progress);

}  // namespace fluovox
