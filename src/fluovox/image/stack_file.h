#pragma once

#include "fluovox/image/stack_info.h"

#include <filesystem>
#include <memory>
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

/// Hyperstack of ImageJ 1.x. Throws OutputError also for what cannot be in one: over 4 GB.
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

/// An OME-TIFF that `save_ome_tiff` wrote, open for reading page by page.
class StackFile {
public:
    /// Throws InputError for anything else.
    explicit StackFile(const std::filesystem::path& path);

    const StackInfo& info() const { return info_; }
    /// The values (counts times their worth) of one page. Throws InputError where the file is damaged.
    void read(int plane, int channel, std::span<float> values);

private:
    struct Tiff;

    std::filesystem::path path_;
    std::shared_ptr<Tiff> tiff_;
    StackInfo info_;
};

}  // namespace fluovox
