#include "fluovox/voxelize/voxelize.h"

#include "fluovox/core/error.h"
#include "fluovox/voxelize/block_lattice.h"
#include "fluovox/voxelize/capsule_merge.h"
#include "fluovox/voxelize/capsule_tile.h"
#include "fluovox/voxelize/chunks.h"
#include "fluovox/voxelize/clip.h"
#include "fluovox/voxelize/grid_filler.h"
#include "fluovox/voxelize/tile_bins.h"
#include "fluovox/voxelize/voxel_tile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

/// Adds a cap triangle in pieces with edges no longer than `longest`, so that the hierarchy over them has compact
/// groups and knows where the cap is near.
void add_in_pieces(Mesh& caps, const std::array<Vec3, 3>& corners, double longest) {
    std::vector<std::array<Vec3, 3>> rest = {corners};
    constexpr std::size_t kMost = 1024;
    for (std::size_t made = 0; !rest.empty();) {
        const std::array<Vec3, 3> t = rest.back();
        rest.pop_back();
        std::size_t from = 0;  // of the longest edge
        for (std::size_t i = 1; i < 3; ++i)
            if (length(t[(i + 1) % 3] - t[i]) > length(t[(from + 1) % 3] - t[from])) from = i;
        const Vec3& a = t[from];
        const Vec3& b = t[(from + 1) % 3];
        const Vec3& c = t[(from + 2) % 3];
        if (length(b - a) > longest && made + rest.size() < kMost) {
            const Vec3 middle = 0.5 * (a + b);
            rest.push_back({a, middle, c});
            rest.push_back({middle, b, c});
            continue;
        }
        ++made;
        const auto first = static_cast<std::uint32_t>(caps.vertices.size());
        caps.vertices.insert(caps.vertices.end(), {a, b, c});
        caps.triangles.push_back({first, first + 1, first + 2});
    }
}

VoxelSurface to_voxels(const std::vector<SolidMesh>& solids, const BlockLattice& lattice, InsideRule rule) {
    VoxelSurface surface;
    Mesh open_caps;
    constexpr double kPiecesAlongBox = 128;
    const double longest_side = std::max({lattice.blocks[0], lattice.blocks[1], lattice.blocks[2]});
    const double longest = std::max<double>(kBlockSide, kBlockSide * longest_side / kPiecesAlongBox);
    for (const SolidMesh& solid : solids) {
        const std::size_t first_vertex = surface.mesh.vertices.size();
        const std::size_t first_triangle = surface.mesh.triangles.size();
        const auto offset = static_cast<std::uint32_t>(first_vertex);
        surface.mesh.vertices.resize(first_vertex + solid.mesh.vertices.size());
        surface.mesh.triangles.resize(first_triangle + solid.mesh.triangles.size());
        for_items(solid.mesh.vertices.size(), [&](std::size_t v) {
            surface.mesh.vertices[first_vertex + v] = to_voxels(solid.mesh.vertices[v], lattice);
        });
        for_items(solid.mesh.triangles.size(), [&](std::size_t t) {
            const auto& corners = solid.mesh.triangles[t];
            surface.mesh.triangles[first_triangle + t] = {corners[0] + offset, corners[1] + offset,
                                                          corners[2] + offset};
        });
        for (std::size_t t = solid.first_cap; t < solid.mesh.triangles.size(); ++t) {
            if (rule == InsideRule::Stab || rule == InsideRule::Flood) break;
            if (rule == InsideRule::Auto && solid.cap_is_sure[t - solid.first_cap] != 0) continue;
            const auto& corners = surface.mesh.triangles[first_triangle + t];
            const auto& vertices = surface.mesh.vertices;
            surface.is_open_cap.resize(first_triangle + t + 1, 0);
            surface.is_open_cap.back() = 1;
            add_in_pieces(open_caps, {vertices[corners[0]], vertices[corners[1]], vertices[corners[2]]}, longest);
        }
    }
    if (!surface.is_open_cap.empty()) surface.is_open_cap.resize(surface.mesh.triangles.size(), 0);
    surface.open_caps = WindingTree(open_caps);
    add_open_blocks(open_caps, surface);
    return surface;
}

Bounds triangle_box(const Mesh& mesh, std::uint32_t number) {
    Bounds box;
    for (const std::uint32_t vertex : mesh.triangles[number])
        box.add(mesh.vertices[vertex]);
    return box;
}

/// The surface without caps, moved along its vertices' normals.
Mesh offset_surface(const SolidMesh& solid, double distance) {
    Mesh mesh = solid.mesh;
    mesh.triangles.resize(solid.first_cap);
    std::vector<Vec3> normals(mesh.vertices.size());
    for (const auto& t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t[0]];
        const Vec3 normal = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
        for (const std::uint32_t vertex : t)
            normals[vertex] = normals[vertex] + normal;
    }
    for (std::size_t i = 0; i < normals.size(); ++i) {
        const double size = length(normals[i]);
        if (size > 0) mesh.vertices[i] = mesh.vertices[i] + (distance / size) * normals[i];
    }
    return mesh;
}

/// Where a triangle lies along z within `low <= y <= high`; empty (min > max) when it doesn't.
std::pair<double, double> triangle_span(const Mesh& mesh, std::uint32_t number, double low, double high) {
    Polygon triangle;
    for (const std::uint32_t vertex : mesh.triangles[number])
        triangle.add(mesh.vertices[vertex]);
    Polygon beside;
    Polygon from_low;
    split(triangle, 1, low, beside, from_low);
    if (from_low.size == 0) return {1, 0};
    Polygon within;
    split(from_low, 1, high, within, beside);
    if (within.size == 0) return {1, 0};
    return {within.low(2), within.high(2)};
}

TileBins bins_of(const Mesh& mesh, const BlockLattice& lattice) {
    return {static_cast<std::uint32_t>(mesh.triangles.size()),
            [&](std::uint32_t number) { return triangle_box(mesh, number); },
            [&](std::uint32_t number, double low, double high) { return triangle_span(mesh, number, low, high); },
            lattice.blocks[2]};
}

/// As `triangle_span` for a capsule, from above.
std::pair<double, double> capsule_span(const Capsule& capsule, double low, double high) {
    const double radius = std::max(capsule.from_radius, capsule.to_radius);
    const double dy = capsule.to.y - capsule.from.y;
    double begin = 0;
    double end = 1;
    if (dy != 0) {
        const double a = (low - radius - capsule.from.y) / dy;
        const double b = (high + radius - capsule.from.y) / dy;
        begin = std::clamp(std::min(a, b), 0.0, 1.0);
        end = std::clamp(std::max(a, b), 0.0, 1.0);
    }
    const double za = capsule.from.z + begin * (capsule.to.z - capsule.from.z);
    const double zb = capsule.from.z + end * (capsule.to.z - capsule.from.z);
    return {std::min(za, zb) - radius, std::max(za, zb) + radius};
}

}  // namespace

VoxelizedGrid voxelize(const std::vector<SolidMesh>& solids, const VoxelizeSettings& settings, Progress& progress) {
    Bounds bounds;
    double bytes = 0;
    for (const SolidMesh& solid : solids) {
        bounds.add(mesh_bounds(solid.mesh));
        bytes += estimate_grid_bytes(solid.mesh, settings.voxel_size_um);
    }
    if (bounds.empty()) throw InputError("there are no triangles to voxelize");
    require_affordable(bytes, bounds, settings);
    const BlockLattice lattice = make_block_lattice(bounds, settings.voxel_size_um);
    const VoxelSurface surface = to_voxels(solids, lattice, settings.inside);
    TileBins bins = bins_of(surface.mesh, lattice);
    bins.add_open_blocks(surface.open_blocks);
    const Solid solid = settings.inside == InsideRule::Flood ? Solid::Enclosed : Solid::Inside;
    return fill_grid(lattice, settings, bins, progress,
                     [&](const TileTask& task) { return fill_tile(surface, task, solid); });
}

VoxelizedGrid voxelize_shell(const std::vector<SolidMesh>& solids, double thickness_um,
                             const VoxelizeSettings& settings, Progress& progress) {
    // Sheets half a voxel apart at most, along the normals.
    const int sheets = std::max(1, static_cast<int>(std::ceil(2 * thickness_um / settings.voxel_size_um)));
    Mesh layers;
    for (const SolidMesh& solid : solids) {
        for (int i = 0; i < sheets; ++i)
            append(layers, offset_surface(solid, thickness_um * ((i + 0.5) / sheets - 0.5)));
    }
    const Bounds bounds = mesh_bounds(layers);
    if (bounds.empty()) throw InputError("there are no triangles to voxelize");
    require_affordable(estimate_grid_bytes(layers, settings.voxel_size_um), bounds, settings);
    const BlockLattice lattice = make_block_lattice(bounds, settings.voxel_size_um);
    VoxelSurface surface;
    surface.mesh = std::move(layers);
    for_items(surface.mesh.vertices.size(),
              [&](std::size_t v) { surface.mesh.vertices[v] = to_voxels(surface.mesh.vertices[v], lattice); });
    const TileBins bins = bins_of(surface.mesh, lattice);
    const double thickness = thickness_um / settings.voxel_size_um / sheets;
    return fill_grid(lattice, settings, bins, progress,
                     [&](const TileTask& task) { return fill_layer_tile(surface, task, thickness); });
}

VoxelizedGrid voxelize_capsules(const std::vector<Capsule>& capsules, const VoxelizeSettings& settings,
                                Progress& progress) {
    MergedCapsules merged = merge_capsules(capsules, settings.voxel_size_um);
    std::vector<Capsule>& placed = merged.capsules;
    Bounds bounds;
    for (const Capsule& capsule : placed)
        bounds.add(capsule_bounds(capsule));
    if (bounds.empty()) throw InputError("there are no segments to voxelize");
    require_affordable(estimate_grid_bytes(placed, settings.voxel_size_um), bounds, settings);
    const BlockLattice lattice = make_block_lattice(bounds, settings.voxel_size_um);
    for (Capsule& capsule : placed) {
        capsule.from = to_voxels(capsule.from, lattice);
        capsule.to = to_voxels(capsule.to, lattice);
        capsule.from_radius /= lattice.voxel_um;
        capsule.to_radius /= lattice.voxel_um;
    }
    const TileBins bins(
        static_cast<std::uint32_t>(placed.size()), [&](std::uint32_t number) { return capsule_bounds(placed[number]); },
        [&](std::uint32_t number, double low, double high) { return capsule_span(placed[number], low, high); },
        lattice.blocks[2]);
    VoxelizedGrid filled = fill_grid(lattice, settings, bins, progress,
                                     [&](const TileTask& task) { return fill_capsule_tile(placed, task); });
    filled.report.merged_points = merged.merged_points;
    return filled;
}

}  // namespace fluovox
