#pragma once

// Volumes of labels (segmentations) as their files hold them: TIFF stacks and NRRD.

#include "fluovox/core/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// What a sample of the file is.
struct SampleFormat {
    enum class Kind { Unsigned, Signed, Float };
    Kind kind = Kind::Unsigned;
    int bits = 8;  ///< 1, 8, 16, 32 or 64

    std::size_t bytes(std::size_t samples) const { return (samples * static_cast<std::size_t>(bits) + 7) / 8; }
};

/// What a volume of labels says of itself.
struct LabelVolumeHeader {
    std::array<std::int64_t, 3> size = {0, 0, 0};  ///< voxels along x (next to each other in the file), y, z
    SampleFormat type;
    double um_per_unit = 0;                    ///< of the lengths below; 0: the file doesn't say
    std::optional<std::array<Vec3, 3>> steps;  ///< from voxel to voxel along x, y, z
    std::optional<Vec3> first;                 ///< centre of the first voxel
    std::string missing;  ///< what the file should say of its voxels' size and doesn't, for messages

    std::size_t slice_voxels() const { return static_cast<std::size_t>(size[0] * size[1]); }
};

/// A file of labels in memory; `bytes` is not owned.
struct LabelVolumeFile {
    std::string_view bytes;
    std::string name;              ///< for messages, which begin with it
    std::filesystem::path folder;  ///< where files that it names are
    bool is_tiff = false;
};

/// Takes the labels of slice z, x fastest; false to stop.
using SliceSink = std::function<bool(std::int64_t z, const std::vector<std::uint64_t>& labels)>;

/// Throws InputError: damaged files, colour pictures, several channels or times, kinds of compression that change
/// values.
LabelVolumeHeader parse_label_header(const LabelVolumeFile& file);

/// Reads all slices in order; one is in memory at a time. Labels below zero count as 0. Throws InputError: files that
/// end early, samples that are not whole numbers.
void read_label_slices(const LabelVolumeFile& file, const LabelVolumeHeader& header, const SliceSink& sink);

LabelVolumeHeader parse_tiff_header(const LabelVolumeFile& file);
void read_tiff_slices(const LabelVolumeFile& file, const LabelVolumeHeader& volume, const SliceSink& sink);
LabelVolumeHeader parse_nrrd_header(const LabelVolumeFile& file);
void read_nrrd_slices(const LabelVolumeFile& file, const LabelVolumeHeader& volume, const SliceSink& sink);

/// Where in the volume a sample is, for messages.
struct SamplePlace {
    std::int64_t x = 0, y = 0, z = 0;
};

/// As many samples as there are labels to be. `swap`: their bytes are in the other order than this machine's. A sample
/// that is no whole number is an InputError at `place` and further along x.
void to_labels(const unsigned char* samples, SampleFormat type, bool swap, std::span<std::uint64_t> labels,
               const std::string& name, SamplePlace place);

/// Micrometres per "um", "nm", "micron" ...; 0 for anything else.
double um_per_named_unit(std::string_view unit);

/// Throws InputError for a volume with no voxels, or more than a file of that size can hold; `strongest`: how many
/// bytes the kind of compression can make of one.
void require_possible_size(const LabelVolumeHeader& header, std::size_t file_bytes, double strongest,
                           const std::string& name);

}  // namespace fluovox
