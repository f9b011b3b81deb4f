#pragma once

#include "fluovox/core/vec.h"

#include <memory>

namespace fluovox {

/// A grid as its VDB file has it, and the factor for its values.
struct VdbTree;

/// Reads one with OpenVDB's own accessor and interpolation: the reference for what SparseGrid makes of the same file.
/// For one thread each.
class VdbSampler {
public:
    explicit VdbSampler(std::shared_ptr<const VdbTree> tree);
    ~VdbSampler();

    /// The trilinear value at an index-space position.
    double trilinear(Vec3 index_position);

    VdbSampler(const VdbSampler&) = delete;
    VdbSampler& operator=(const VdbSampler&) = delete;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace fluovox
