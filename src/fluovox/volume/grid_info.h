#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/vec.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {

/// What a grid of a VDB file says about itself; a text is empty where the file is silent.
struct GridMetadata {
    std::string dye;
    std::string value_unit;     ///< of concentrations: "umol/L"
    std::string length_unit;    ///< of world space: "um"
    std::string source;         ///< the files it was made from
    std::string source_sha256;  ///< of those files' bytes
    std::string fluovox_version;
};

/// One grid of a file's table of contents.
struct GridEntry {
    std::string name;
    std::string value_type;  ///< "float", "double", "int32", "vec3s" ...
    bool half = false;       ///< stored with 16 bits a value
    bool readable = false;   ///< a float grid of the usual tree, which fluovox can read
};

/// What a grid of whole numbers owns up to: which objects there are.
struct LabelStatistics {
    std::uint64_t labels = 0;  ///< different numbers other than 0
    std::int64_t largest = 0;
};

/// A grid with its statistics, as `fluovox info` prints it. Lengths and amounts assume the metadata's units,
/// and um and umol/L where the file is silent.
struct GridInfo {
    GridEntry entry;
    GridMetadata metadata;
    std::string grid_class;  ///< "fog volume", "level set", "unknown" ...
    Vec3 voxel_size_um;
    std::uint64_t active_voxels = 0;    ///< those of tiles included
    Bounds bbox_um;                     ///< of the active voxels, whole cells; empty when there are none
    double min = 0, mean = 0, max = 0;  ///< over the active voxels, in the grid's own unit
    double total_mol = 0;               ///< amount of substance: sum of value times voxel volume
    bool has_concentrations = true;     ///< false where its unit is another; `total_mol` is then 0
    std::uint64_t memory_bytes = 0;
    /// Of a grid of labels; its voxel size, active voxels, bounding box and memory are then known as well.
    std::optional<LabelStatistics> labels;
};

/// The grids of a VDB file, in the order of the file; several of one name are called `EGFP[0]`, `EGFP[1]`. Throws
/// InputError when it is missing, empty, truncated or no VDB file at all.
std::vector<GridEntry> list_grids(const std::filesystem::path& file);

/// Throws the InputError that opening the grid `name` would throw for a name that no grid of the file has, or more than
/// one: `EGFP[1]` is then the second of them. Names match without case where that is clear; none stands for the only
/// one.
void require_grid(const std::filesystem::path& file, const std::string& name);

/// Statistics of every readable grid of a file and of those of labels; the others have only their `entry`. Throws
/// InputError.
std::vector<GridInfo> inspect_grids(const std::filesystem::path& file);

}  // namespace fluovox
