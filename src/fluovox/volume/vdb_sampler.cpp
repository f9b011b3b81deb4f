#include "fluovox/volume/vdb_sampler.h"

#include "fluovox/volume/vdb_internal.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <utility>

namespace fluovox {

struct VdbSampler::Impl {
    explicit Impl(std::shared_ptr<const VdbTree> kept)
        : tree(std::move(kept)), values(tree->grid->getConstAccessor()) {}

    std::shared_ptr<const VdbTree> tree;
    openvdb::FloatGrid::ConstAccessor values;
};

VdbSampler::VdbSampler(std::shared_ptr<const VdbTree> tree) : impl_(std::make_unique<Impl>(std::move(tree))) {}

VdbSampler::~VdbSampler() = default;

double VdbSampler::trilinear(Vec3 index_position) {
    const openvdb::Vec3d at(index_position.x, index_position.y, index_position.z);
    const float value = openvdb::tools::BoxSampler::sample(impl_->values, at);
    return static_cast<double>(impl_->tree->factor * value);
}

}  // namespace fluovox
