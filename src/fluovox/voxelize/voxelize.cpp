#include "fluovox/voxelize/voxelize.h"

#include "fluovox/core/error.h"
#include "fluovox/volume/vdb_internal.h"
#include "fluovox/voxelize/capsule_merge.h"
#include "fluovox/voxelize/capsule_tile.h"
#include "fluovox/voxelize/chunks.h"
#include "fluovox/voxelize/clip.h"
#include "fluovox/voxelize/flood.h"
#include "fluovox/voxelize/tile_bins.h"
#include "fluovox/voxelize/voxel_tile.h"

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

/// The lattice of a grid and the part of it that is filled.
struct Lattice {
    double voxel_um = 0;
    std::array<std::int32_t, 3> corner{};  ///< voxel with the lowest indices; a multiple of the block's side
    std::array<std::int32_t, 3> blocks{};  ///< along each axis
};

Lattice make_lattice(const Bounds& bounds, double voxel_um) {
    Lattice lattice;
    lattice.voxel_um = voxel_um;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = std::floor(bounds.min[axis] / voxel_um / kBlockSide);
        const double high = std::floor(bounds.max[axis] / voxel_um / kBlockSide) + 1;
        constexpr double kFarthest = 1 << 27;  // in blocks; the tree's indices have 32 bits
        if (!(std::abs(low) < kFarthest && std::abs(high) < kFarthest)) {
            throw InputError(fmt::format("the mesh reaches to {:g} um, too far from the origin for voxels of {:g} um",
                                         std::max(std::abs(bounds.min[axis]), std::abs(bounds.max[axis])), voxel_um));
        }
        const auto index = static_cast<std::size_t>(axis);
        lattice.corner[index] = kBlockSide * static_cast<std::int32_t>(low);
        lattice.blocks[index] = static_cast<std::int32_t>(high - low);
    }
    return lattice;
}

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

Vec3 to_voxels(const Vec3& position_um, const Lattice& lattice) {
    Vec3 placed;
    for (int axis = 0; axis < 3; ++axis)
        placed[axis] = position_um[axis] / lattice.voxel_um - lattice.corner[static_cast<std::size_t>(axis)];
    return placed;
}

VoxelSurface to_voxels(const std::vector<SolidMesh>& solids, const Lattice& lattice, InsideRule rule) {
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

/// Where a triangle lies along z within `low <= y <= high`; empty (min > max) when it doesn't.
std::pair<double, double> triangle_span(const Mesh& mesh, std::uint32_t number, double low, double high) {
    Polygon polygon;
    for (const std::uint32_t vertex : mesh.triangles[number])
        polygon.add(mesh.vertices[vertex]);
    Polygon below;
    Polygon above;
    split(polygon, 1, low, below, above);
    if (above.size == 0) return {1, 0};
    split(above, 1, high, below, polygon);
    if (below.size == 0) return {1, 0};
    return {below.low(2), below.high(2)};
}

/// The same for a capsule, from above.
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

class GridFiller {
public:
    GridFiller(const Lattice& lattice, const VoxelizeSettings& settings)
        : lattice_(lattice), settings_(settings), grid_(openvdb::FloatGrid::create(0.0F)), tree_(grid_->tree()) {
        using openvdb::math::Transform;
        grid_->setTransform(Transform::createLinearTransform(settings.voxel_size_um));
        grid_->transform().postTranslate(openvdb::Vec3d(settings.voxel_size_um / 2));
        grid_->setGridClass(openvdb::GRID_FOG_VOLUME);
    }

    /// Leaves of one tile, made by any thread.
    std::vector<Leaf*> make_leaves(const TileTask& task, const TileResult& result) const {
        std::vector<Leaf*> leaves;
        leaves.reserve(result.blocks.size());
        for (const auto& block : result.blocks) {
            auto* const leaf = new Leaf(origin(block.x, task), 0.0F, false);  // NOLINT: the tree takes it
            const BlockValues& values = result.values[block.values];
            // What rounding leaves beside a surface is no voxel of it; a speck far smaller than a voxel is.
            constexpr float kNothing = 1e-12F;
            constexpr float kNothingBesideOthers = 1e-6F;
            const float least =
                std::max(kNothing, kNothingBesideOthers * *std::max_element(values.begin(), values.end()));
            for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
                if (!(values[i] > least)) continue;
                leaf->setValueOn(i, static_cast<float>(settings_.value * static_cast<double>(values[i])));
            }
            leaves.push_back(leaf);
        }
        return leaves;
    }
    void add(const TileTask& task, const TileResult& result, const std::vector<Leaf*>& leaves) {
        for (Leaf* const leaf : leaves)
            tree_.addLeaf(leaf);
        const auto value = static_cast<float>(settings_.value);
        for (const auto& run : result.full) {
            for (std::int32_t x = run.begin; x < run.end; ++x)
                tree_.addTile(1, origin(x, task), value, true);
        }
    }
    /// Fills what a flood left dry.
    void add(const std::vector<Flood::Enclosed>& enclosed) {
        const auto value = static_cast<float>(settings_.value);
        for (const auto& part : enclosed) {
            TileTask task;
            task.y = part.y;
            task.z = part.z;
            for (std::int32_t x = part.begin; x < part.end; ++x) {
                if (part.voxels.all()) {
                    tree_.addTile(1, origin(x, task), value, true);
                    continue;
                }
                Leaf* const leaf = tree_.touchLeaf(origin(x, task));
                for (std::size_t i = 0; i < part.voxels.size(); ++i)
                    if (part.voxels[i]) leaf->setValueOn(static_cast<openvdb::Index>(i), value);
            }
        }
    }
    openvdb::FloatGrid::Ptr finish() {
        openvdb::tools::pruneTiles(grid_->tree());
        if (settings_.clip_um) clip();
        return grid_;
    }

private:
    openvdb::Coord origin(std::int32_t x, const TileTask& task) const {
        return {lattice_.corner[0] + kBlockSide * x, lattice_.corner[1] + kBlockSide * task.y,
                lattice_.corner[2] + kBlockSide * task.z};
    }
    /// Voxels that a face of the box cuts keep the share of them that is inside.
    void clip() {
        // So that a face on the lattice is on it whatever the rounding.
        constexpr double kOnLattice = 1e-6;
        constexpr double kFar = 1 << 30;
        openvdb::CoordBBox box;
        std::array<std::array<double, 2>, 3> share{};
        for (int axis = 0; axis < 3; ++axis) {
            const double low = std::clamp(settings_.clip_um->min[axis] / settings_.voxel_size_um, -kFar, kFar);
            const double high = std::clamp(settings_.clip_um->max[axis] / settings_.voxel_size_um, -kFar, kFar);
            box.min()[axis] = static_cast<int>(std::floor(low + kOnLattice));
            box.max()[axis] = std::max(box.min()[axis], static_cast<int>(std::ceil(high - kOnLattice)) - 1);
            const bool one = box.min()[axis] == box.max()[axis];
            const auto i = static_cast<std::size_t>(axis);
            share[i] = {one ? high - low : box.min()[axis] + 1 - low, one ? 1 : high - box.max()[axis]};
        }
        grid_->clip(box);
        openvdb::CoordBBox filled;
        if (!tree_.tree().evalActiveVoxelBoundingBox(filled)) return;
        for (int axis = 0; axis < 3; ++axis) {
            for (std::size_t side = 0; side < 2; ++side) {
                const double kept = share[static_cast<std::size_t>(axis)][side];
                if (kept > 1 - kOnLattice) continue;
                openvdb::CoordBBox slab = filled;
                slab.min()[axis] = slab.max()[axis] = side == 0 ? box.min()[axis] : box.max()[axis];
                if (slab.min()[axis] >= filled.min()[axis] && slab.max()[axis] <= filled.max()[axis])
                    scale(slab, static_cast<float>(kept));
            }
        }
    }
    /// Multiplies the voxels of a slab, block by block, as most of it is empty.
    void scale(const openvdb::CoordBBox& slab, float factor) {
        const auto blocks = [](const openvdb::Coord& voxel) {
            return openvdb::Coord(voxel.x() & ~(kBlockSide - 1), voxel.y() & ~(kBlockSide - 1),
                                  voxel.z() & ~(kBlockSide - 1));
        };
        const openvdb::Coord first = blocks(slab.min());
        openvdb::tree::ValueAccessor<openvdb::FloatTree> tree(grid_->tree());
        for (int x = first.x(); x <= slab.max().x(); x += kBlockSide) {
            for (int y = first.y(); y <= slab.max().y(); y += kBlockSide) {
                for (int z = first.z(); z <= slab.max().z(); z += kBlockSide) {
                    const openvdb::Coord origin(x, y, z);
                    if (tree.probeConstLeaf(origin) == nullptr && !tree.isValueOn(origin)) continue;
                    Leaf* const leaf = tree.touchLeaf(origin);
                    for (auto voxel = leaf->beginValueOn(); voxel; ++voxel)
                        if (slab.isInside(voxel.getCoord())) voxel.setValue(*voxel * factor);
                }
            }
        }
    }

    Lattice lattice_;
    VoxelizeSettings settings_;
    openvdb::FloatGrid::Ptr grid_;
    openvdb::tree::ValueAccessor<openvdb::FloatTree> tree_;
};

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

namespace {

/// Sum of all values.
double filled_voxels(const openvdb::FloatGrid& grid) {
    double sum = 0;
    for (auto at = grid.cbeginValueOn(); at; ++at)
        sum += static_cast<double>(*at) * static_cast<double>(at.getVoxelCount());
    return sum;
}

struct FilledTile {
    TileTask task;
    TileResult result;
    std::vector<Leaf*> leaves;
};

/// Fills a grid tile by tile in parallel; `fill` makes a TileResult of a TileTask.
template <class Fill>
VoxelizedGrid fill_grid(const Lattice& lattice, const VoxelizeSettings& settings, const TileBins& bins,
                        Progress& progress, const Fill& fill) {
    GridFiller filler(lattice, settings);
    VoxelizeReport report;
    Flood flood;
    progress.start("voxelizing", static_cast<long long>(bins.size()));
    // Tiles are filled in any order, a few at a time, and go into the tree in theirs, so that every sum is the same
    // for any number of threads.
    constexpr std::size_t kBatch = 16;
    constexpr std::size_t kBatchesAtOnce = 64;
    const double voxel_um3 = std::pow(settings.voxel_size_um, 3);
    std::size_t next = 0;
    const auto take = [&](tbb::flow_control& flow) {
        const std::size_t begin = next;
        if (begin >= bins.size() || progress.stopped()) flow.stop();
        next += kBatch;
        return begin;
    };
    const auto work = [&](std::size_t begin) {
        std::vector<FilledTile> tiles;
        for (std::size_t i = begin; i < std::min(begin + kBatch, bins.size()); ++i) {
            FilledTile& tile = tiles.emplace_back();
            tile.task = bins.task(i);
            tile.result = fill(tile.task);
            tile.leaves = filler.make_leaves(tile.task, tile.result);
            tile.result.values = {};
            progress.advance(1);
        }
        return tiles;
    };
    const auto put = [&](const std::vector<FilledTile>& tiles) {
        for (const FilledTile& tile : tiles) {
            filler.add(tile.task, tile.result, tile.leaves);
            report.volume_um3 += tile.result.volume * voxel_um3;
            report.capped_um3 += tile.result.winding_volume * voxel_um3;
            report.decided_by_winding += tile.result.decided_by_winding;
            flood.add(tile.task, tile.result);
        }
    };
    using tbb::filter_mode;
    tbb::parallel_pipeline(kBatchesAtOnce,
                           tbb::make_filter<void, std::size_t>(filter_mode::serial_in_order, take) &
                               tbb::make_filter<std::size_t, std::vector<FilledTile>>(filter_mode::parallel, work) &
                               tbb::make_filter<std::vector<FilledTile>, void>(filter_mode::serial_in_order, put));
    if (settings.inside == InsideRule::Flood && !progress.stopped()) filler.add(flood.enclosed());
    auto grid = filler.finish();
    report.voxels = grid->activeVoxelCount();
    if (settings.inside == InsideRule::Flood || settings.clip_um)
        report.volume_um3 = voxel_um3 * filled_voxels(*grid) / settings.value;
    if (report.voxels == 0 && !progress.stopped()) {
        throw InputError(settings.clip_um
                             ? "nothing of it is inside the box of --bbox or --clip: the grid would be empty"
                             : "nothing is inside the surface: the grid would be empty");
    }
    if (!std::isfinite(report.volume_um3) && !progress.stopped()) {
        throw InputError(
            "the surface is too open to have an inside: its volume is not a number; close it, or fill a layer along "
            "it with --shell");
    }
    return {DyeGrid(std::make_shared<DyeGrid::Impl>(DyeGrid::Impl{grid})), report};
}

}  // namespace

VoxelizedGrid voxelize(const std::vector<SolidMesh>& solids, const VoxelizeSettings& settings, Progress& progress) {
    initialize_openvdb();
    Bounds bounds;
    double bytes = 0;
    for (const SolidMesh& solid : solids) {
        bounds.add(mesh_bounds(solid.mesh));
        bytes += estimate_grid_bytes(solid.mesh, settings.voxel_size_um);
    }
    if (bounds.empty()) throw InputError("there are no triangles to voxelize");
    require_affordable(bytes, bounds, settings);
    const Lattice lattice = make_lattice(bounds, settings.voxel_size_um);
    const VoxelSurface surface = to_voxels(solids, lattice, settings.inside);
    TileBins bins(
        static_cast<std::uint32_t>(surface.mesh.triangles.size()),
        [&](std::uint32_t number) { return triangle_box(surface.mesh, number); },
        [&](std::uint32_t number, double low, double high) { return triangle_span(surface.mesh, number, low, high); },
        lattice.blocks[2]);
    bins.add_open_blocks(surface.open_blocks);
    const Solid solid = settings.inside == InsideRule::Flood ? Solid::Enclosed : Solid::Inside;
    return fill_grid(lattice, settings, bins, progress,
                     [&](const TileTask& task) { return fill_tile(surface, task, solid); });
}

VoxelizedGrid voxelize_shell(const std::vector<SolidMesh>& solids, double thickness_um,
                             const VoxelizeSettings& settings, Progress& progress) {
    initialize_openvdb();
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
    const Lattice lattice = make_lattice(bounds, settings.voxel_size_um);
    VoxelSurface surface;
    surface.mesh = std::move(layers);
    for_items(surface.mesh.vertices.size(),
              [&](std::size_t v) { surface.mesh.vertices[v] = to_voxels(surface.mesh.vertices[v], lattice); });
    const TileBins bins(
        static_cast<std::uint32_t>(surface.mesh.triangles.size()),
        [&](std::uint32_t number) { return triangle_box(surface.mesh, number); },
        [&](std::uint32_t number, double low, double high) { return triangle_span(surface.mesh, number, low, high); },
        lattice.blocks[2]);
    const double thickness = thickness_um / settings.voxel_size_um / sheets;
    return fill_grid(lattice, settings, bins, progress,
                     [&](const TileTask& task) { return fill_layer_tile(surface, task, thickness); });
}

VoxelizedGrid voxelize_capsules(const std::vector<Capsule>& capsules, const VoxelizeSettings& settings,
                                Progress& progress) {
    initialize_openvdb();
    Bounds bounds;
    const double side = kBlockSide * settings.voxel_size_um;
    double blocks = 8;
    MergedCapsules merged = merge_capsules(capsules, settings.voxel_size_um);
    std::vector<Capsule>& placed = merged.capsules;
    for (const Capsule& capsule : placed) {
        const Bounds box = capsule_bounds(capsule);
        bounds.add(box);
        blocks += std::min(blocks_of_box(box, side),
                           blocks_of_surface(capsule_area(capsule), length(capsule.to - capsule.from), side));
    }
    if (bounds.empty()) throw InputError("there are no segments to voxelize");
    require_affordable(kLeafBytes * std::min(blocks, blocks_of_box(bounds, side)), bounds, settings);
    const Lattice lattice = make_lattice(bounds, settings.voxel_size_um);
    for (Capsule& capsule : placed) {
        for (int axis = 0; axis < 3; ++axis) {
            const double corner = lattice.corner[static_cast<std::size_t>(axis)];
            capsule.from[axis] = capsule.from[axis] / lattice.voxel_um - corner;
            capsule.to[axis] = capsule.to[axis] / lattice.voxel_um - corner;
        }
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
