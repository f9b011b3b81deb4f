#pragma once

#include "fluovox/core/vec.h"

#include <filesystem>
#include <memory>
#include <optional>

namespace fluovox {

/// The grid "labels" of a VDB file: which object owns each voxel. Immutable; a copy shares the voxels.
class LabelField {
public:
    /// Nothing where the file has no integer grid "labels". `um_per_unit` scales its world space. Throws InputError for
    /// a file that cannot be read.
    static std::optional<LabelField> load(const std::filesystem::path& file, double um_per_unit);

    /// The label of the voxel around a point; 0: nobody's.
    int at(Vec3 world_um) const;

private:
    struct Impl;
    explicit LabelField(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

    std::shared_ptr<const Impl> impl_;
};

}  // namespace fluovox
