// What a grid will take in memory, before it is made.

#include "fluovox/core/error.h"
#include "fluovox/voxelize/capsule_tile.h"
#include "fluovox/voxelize/chunks.h"
#include "fluovox/voxelize/voxel_tile.h"
#include "fluovox/voxelize/voxelize.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace fluovox {
namespace {

constexpr double kLeafBytes = 2300;

/// Blocks that a piece of surface crosses: about 1.5 for each block's face of area, and all along it when it is thin.
double blocks_of_surface(double area, double longest, double side) {
    return 1.5 * area / (side * side) + std::max(0.0, 2 * longest / side - 1);
}

double blocks_of_box(const Bounds& bounds, double side) {
    double blocks = 1;
    for (int axis = 0; axis < 3; ++axis)
        blocks *= std::floor(bounds.size()[axis] / side) + 2;
    return blocks;
}

}  // namespace

double estimate_grid_bytes(const Mesh& mesh, double voxel_size_um) {
    const double side = kBlockSide * voxel_size_um;
    const double blocks =
        8 + sum_of(mesh.triangles.size(), [&](std::size_t number) {
            const auto& t = mesh.triangles[number];
            const Vec3& a = mesh.vertices[t[0]];
            const Vec3& b = mesh.vertices[t[1]];
            const Vec3& c = mesh.vertices[t[2]];
            const double longest = std::sqrt(std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)}));
            return blocks_of_surface(length(cross(b - a, c - a)) / 2, longest, side);
        });
    return kLeafBytes * std::min(blocks, blocks_of_box(mesh_bounds(mesh), side));
}

double estimate_grid_bytes(const std::vector<Capsule>& capsules, double voxel_size_um) {
    const double side = kBlockSide * voxel_size_um;
    Bounds bounds;
    double blocks = 8;
    for (const Capsule& capsule : capsules) {
        const Bounds box = capsule_bounds(capsule);
        bounds.add(box);
        blocks += std::min(blocks_of_box(box, side),
                           blocks_of_surface(capsule_area(capsule), length(capsule.to - capsule.from), side));
    }
    return kLeafBytes * std::min(blocks, blocks_of_box(bounds, side));
}

void require_affordable(double bytes, const Bounds& bounds_um, const VoxelizeSettings& settings) {
    if (bytes <= settings.max_bytes) return;
    const Vec3 size = bounds_um.size();
    const double dx = settings.voxel_size_um;
    throw InputError(fmt::format(
        "the grid would take about {:.3g} GiB: the bounding box is {:.6g} x {:.6g} x {:.6g} um, {:.4g} x {:.4g} x "
        "{:.4g} "
        "= {:.3g} voxels of {:g} um. If the unit is wrong, neuron meshes are often in nanometres: add --mesh-unit nm. "
        "Otherwise choose a larger --voxel-size, or raise --max-bytes",
        bytes / (1LL << 30), size.x, size.y, size.z, size.x / dx, size.y / dx, size.z / dx,
        size.x / dx * size.y / dx * size.z / dx, dx));
}

}  // namespace fluovox
