#pragma once

#include "fluovox/image/stack_info.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fluovox {

/// What a stack is written as.
enum class StackFormat {
    OmeTiff,  ///< .ome.tif
    ImageJ,   ///< .tif, a hyperstack for plain ImageJ
    OmeZarr,  ///< .ome.zarr 0.4 (Zarr version 2), a folder
    Exr,      ///< one image file per plane
};

/// A second image over the same pixels: what is where.
struct StackLabels {
    std::string name;  ///< "labels"
    PlaneSource source;
};

/// OME-TIFF: the first page holds OME-XML of schema 2016-06; pages are uncompressed, all channels of plane 0, then of
/// plane 1 ... A BigTIFF only where the file would pass 4 GB. Holds one page in memory. The same stack gives the same
/// bytes. Throws OutputError; an existing file survives a failure. So do the two below.
void save_ome_tiff(const std::filesystem::path& path, const StackInfo& info, const PlaneSource& source);

/// Hyperstack of ImageJ 1.x, with the channels' colours and for each the range of values that is shown at first.
/// Throws OutputError also for what cannot be in one: over 4 GB.
void save_imagej_tiff(const std::filesystem::path& path, const StackInfo& info, const PlaneSource& source);

/// Throws OutputError where `path` is anything but a folder that `save_ome_zarr` wrote, with nothing else in it, or an
/// empty one: only those are replaced. To be asked before long work.
void require_replaceable_zarr(const std::filesystem::path& path);

/// The files of an OME-Zarr folder that `save_ome_zarr` writes, in order; others in it (of viewers, or a file manager)
/// are left out.
std::vector<std::filesystem::path> files_of_zarr(const std::filesystem::path& folder);

/// OME-Zarr 0.4: axes c, z, y, x; one chunk a plane, zlib; sizes halved along x and y until they are small.
/// `labels`, where given, go into its group "labels".
void save_ome_zarr(const std::filesystem::path& path, const StackInfo& info, const PlaneSource& source,
                   const std::optional<StackLabels>& labels = std::nullopt);

/// Of a stack of one EXR image for each plane: what a plane's name ends in, "-0007.exr", and what stands in
/// `Provenance::stack_note` so that the planes can be read as the stack they are.
std::string exr_plane_ending(int plane);
std::string exr_plane_note(const StackInfo& info, int plane);

/// A stack that fluovox wrote, in any of its formats, open for reading page by page.
class StackFile {
public:
    /// A file or folder, or for planes of EXR the name they begin with ("stack.exr") or that of any of them; of these,
    /// the layer of all light is read. Throws InputError for anything else.
    explicit StackFile(const std::filesystem::path& path);

    const StackInfo& info() const { return info_; }
    /// The values (counts times their worth) of one page, `info().pixels()` of them. Throws InputError where the file
    /// is damaged.
    void read(int plane, int channel, std::span<float> values);

private:
    StackInfo info_;
    PlaneSource source_;
};

}  // namespace fluovox
