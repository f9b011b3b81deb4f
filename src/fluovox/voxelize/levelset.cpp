#include "fluovox/voxelize/levelset.h"

#include "fluovox/core/error.h"
#include "fluovox/volume/vdb_internal.h"

#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/ValueTransformer.h>

#include <algorithm>
#include <cmath>

namespace fluovox {

DyeGrid load_levelset_as_dye(const std::filesystem::path& file, const std::string& name, double value,
                             double um_per_unit) {
    const auto grid = load_any_float_grid(file, name);
    if (grid->getGridClass() != openvdb::GRID_LEVEL_SET && !(grid->background() > 0)) {
        throw InputError(file.string() + ": grid \"" + grid->getName() + "\" is not a level set (it is a " +
                         openvdb::GridBase::gridClassToMenuName(grid->getGridClass()) + ")");
    }
    const double voxel = grid->voxelSize().x();
    openvdb::tools::foreach (
        grid->beginValueAll(),
        [value, voxel](const openvdb::FloatGrid::ValueAllIter& at) {
            const double inside = std::clamp(0.5 - static_cast<double>(*at) / voxel, 0.0, 1.0);
            at.setValue(static_cast<float>(std::isnan(inside) ? 0 : value * inside));
            at.setActiveState(inside > 0);
        },
        /*threaded=*/true);
    openvdb::tools::changeBackground(grid->tree(), 0.0F);
    openvdb::tools::prune(grid->tree());
    grid->transform().postScale(um_per_unit);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    if (grid->baseTree().activeVoxelCount() == 0) throw InputError(file.string() + ": nothing is inside the level set");
    return DyeGrid(std::make_shared<DyeGrid::Impl>(DyeGrid::Impl{grid}));
}

}  // namespace fluovox
