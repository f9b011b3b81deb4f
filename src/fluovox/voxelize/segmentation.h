#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/voxelize/specimen.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {

/// What is labelled with one dye at one concentration in a volume of labels.
struct SegmentDye {
    std::string dye;
    double concentration_uM = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> labels;  ///< ranges, ends included; empty: all but 0
    std::string text;                                             ///< as the user wrote it, for messages
};

/// A mask or a volume of labels: a TIFF stack or a NRRD file.
struct Segmentation {
    std::filesystem::path file;
    std::vector<SegmentDye> dyes;
    std::optional<Vec3> voxel_size_um;  ///< instead of what the file says
    double um_per_unit = 0;             ///< of the file's lengths, instead of what it says; 0: what it says
};

/// Whether the name ends like one.
bool is_segmentation_file(const std::filesystem::path& file);

/// Turns labels into grids of concentration, one a dye, with the voxels of the file: their size, anisotropy and (NRRD)
/// place and direction are kept; `settings` gives `half`, `labels` and `voxels.clip_um` and `max_bytes`. Without an
/// origin of its own the volume starts at zero. One report a label.
///
/// Throws InputError: damaged files, unknown voxel size, labels that are not there.
SpecimenResult voxelize_segmentation(const Segmentation& segmentation, const SpecimenSettings& settings,
                                     Progress& progress);

}  // namespace fluovox
