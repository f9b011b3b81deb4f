#include "fluovox/volume/projection.h"

#include "fluovox/volume/vdb_internal.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace fluovox {
namespace {

/// How voxels become pixels: `across` to the right, `up` upwards, along the third axis.
struct View {
    int across = 0;
    int up = 1;
    int step = 1;  // voxels a pixel
    openvdb::CoordBBox box;

    int column(int index) const { return (index - box.min()[across]) / step; }
    int row(int index) const { return (box.max()[up] - index) / step; }
};

View choose_view(const openvdb::CoordBBox& box, int most_pixels) {
    View view;
    view.box = box;
    std::array<int, 3> axes = {0, 1, 2};
    const openvdb::Coord size = box.dim();
    // The shortest axis is looked along, z where all are alike; of the others the first goes to the right.
    int along = 2;
    for (const int axis : {1, 0})
        if (size[axis] < size[along]) along = axis;
    std::stable_partition(axes.begin(), axes.end(), [along](int axis) { return axis != along; });
    view.across = axes[0];
    view.up = axes[1];
    const int longest = std::max(size[view.across], size[view.up]);
    view.step = std::max(1, (longest + most_pixels - 1) / most_pixels);
    return view;
}

Projection project(const openvdb::FloatGrid& grid, const View& view) {
    Projection picture;
    picture.grid = grid.getName();
    picture.width = view.column(view.box.max()[view.across]) + 1;
    picture.height = view.row(view.box.min()[view.up]) + 1;
    picture.values.assign(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height), 0.0F);
    for (auto at = grid.cbeginValueOn(); at; ++at) {
        const float value = *at;
        picture.largest = std::max(picture.largest, value);
        openvdb::CoordBBox box;
        at.getBoundingBox(box);
        for (int row = view.row(box.max()[view.up]); row <= view.row(box.min()[view.up]); ++row) {
            for (int column = view.column(box.min()[view.across]); column <= view.column(box.max()[view.across]);
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
        if (!grid->tree().evalActiveVoxelBoundingBox(box)) continue;
        all.expand(box);
        grids.push_back(grid);
    }
    std::vector<Projection> pictures;
    if (grids.empty()) return pictures;
    const View view = choose_view(all, most_pixels);
    for (const auto& grid : grids)
        pictures.push_back(project(*grid, view));
    return pictures;
}

}  // namespace fluovox
