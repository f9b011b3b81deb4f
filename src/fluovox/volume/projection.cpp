#include "fluovox/volume/projection.h"

#include "fluovox/volume/vdb_internal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace fluovox {
namespace {

/// How voxels become pixels: `across` to the right, `up` upwards, along the third axis. Pixels are squares.
struct View {
    int across = 0;
    int up = 1;
    double pixels_across = 1;  // a voxel
    double pixels_up = 1;
    openvdb::CoordBBox box;

    /// The first pixel of a voxel (or of the one after the last). Of doubles, as between voxels at the ends of the
    /// tree there are more than an int counts.
    int column(double index) const { return static_cast<int>(std::floor(pixels_across * (index - box.min()[across]))); }
    int row(double index) const { return static_cast<int>(std::floor(pixels_up * (box.max()[up] - index))); }
    /// One past the last pixel of a voxel; at least one pixel shows it.
    int column_end(double index) const { return std::max(column(index) + 1, column(index + 1)); }
    int row_end(double index) const { return std::max(row(index) + 1, row(index - 1)); }
};

View choose_view(const openvdb::CoordBBox& box, const openvdb::Vec3d& voxel, int most_pixels) {
    View view;
    view.box = box;
    std::array<int, 3> axes = {0, 1, 2};
    const openvdb::Vec3d size = (box.max().asVec3d() - box.min().asVec3d() + openvdb::Vec3d(1)) * voxel;
    // The shortest axis is looked along, z where all are alike; of the others the first goes to the right.
    int along = 2;
    for (const int axis : {1, 0})
        if (size[axis] < size[along]) along = axis;
    std::stable_partition(axes.begin(), axes.end(), [along](int axis) { return axis != along; });
    view.across = axes[0];
    view.up = axes[1];
    const double longest = std::max(size[view.across], size[view.up]);
    const double pixel = std::max(std::min(voxel[view.across], voxel[view.up]), longest / most_pixels);
    view.pixels_across = voxel[view.across] / pixel;
    view.pixels_up = voxel[view.up] / pixel;
    return view;
}

Projection project(const openvdb::FloatGrid& grid, const View& view) {
    Projection picture;
    picture.grid = grid.getName();
    picture.width = view.column_end(view.box.max()[view.across]);
    picture.height = view.row_end(view.box.min()[view.up]);
    picture.values.assign(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height), 0.0F);
    for (auto at = grid.cbeginValueOn(); at; ++at) {
        const float value = *at;
        picture.largest = std::max(picture.largest, value);
        openvdb::CoordBBox box;
        at.getBoundingBox(box);
        for (int row = view.row(box.max()[view.up]); row < view.row_end(box.min()[view.up]); ++row) {
            for (int column = view.column(box.min()[view.across]); column < view.column_end(box.max()[view.across]);
                 ++column) {
                float& pixel = picture.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
                                              static_cast<std::size_t>(column)];
                pixel = std::max(pixel, value);
            }
        }
    }
    return picture;
}

}  // namespace

std::vector<Projection> project_grids(const std::filesystem::path& file, int most_pixels) {
    std::vector<openvdb::FloatGrid::Ptr> grids;
    openvdb::CoordBBox all;
    for (const GridEntry& entry : list_grids(file)) {
        if (!entry.readable) continue;
        auto grid = load_any_float_grid(file, entry.name);
        openvdb::CoordBBox box;
        if (!grid->baseTree().evalActiveVoxelBoundingBox(box)) continue;
        all.expand(box);
        grids.push_back(grid);
    }
    std::vector<Projection> pictures;
    if (grids.empty()) return pictures;
    const View view = choose_view(all, grids.front()->voxelSize(), most_pixels);
    for (const auto& grid : grids)
        pictures.push_back(project(*grid, view));
    return pictures;
}

}  // namespace fluovox
