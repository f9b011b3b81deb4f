#include "fluovox/specimen/skin.h"

#include "fluovox/core/bounds.h"
#include "fluovox/core/error.h"
#include "fluovox/specimen/solids.h"
#include "fluovox/volume/vdb_internal.h"

#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace fluovox {
namespace {

constexpr double kSomaBlend_um = 2;

/// The lesser of two distances, rounded off where they differ by less than `blend`.
double smooth_min(double a, double b, double blend) {
    const double h = std::max(0.0, 1 - std::abs(a - b) / std::max(blend, 1e-9));
    return std::min(a, b) - 0.25 * blend * h * h;
}

using openvdb::Coord;
using openvdb::FloatGrid;

/// Lattice points are at (index + shift) * spacing.
struct Lattice {
    double spacing_um = 1;
    Vec3 shift;

    Vec3 position(const Coord& c) const {
        return spacing_um *
               (Vec3{static_cast<double>(c.x()), static_cast<double>(c.y()), static_cast<double>(c.z())} + shift);
    }
    Coord floor(Vec3 p) const {
        const Vec3 q = (1 / spacing_um) * p - shift;
        return {static_cast<int>(std::floor(q.x)), static_cast<int>(std::floor(q.y)),
                static_cast<int>(std::floor(q.z))};
    }
};

void melt_in(const RoundCone& piece, const Lattice& lattice, FloatGrid::Accessor& distances) {
    // Farther out no value can move the surface; a surface cell's corners are within sqrt(3) spacings of it.
    const double band_um = std::max(piece.blend_um, kSomaBlend_um) + 1.8 * lattice.spacing_um;
    const double reach = std::max(piece.begin_radius_um, piece.end_radius_um) + band_um;
    Bounds box;
    box.add(piece.begin);
    box.add(piece.end);
    const Vec3 margin{reach, reach, reach};
    const openvdb::CoordBBox cells(lattice.floor(box.min - margin), lattice.floor(box.max + margin));
    for (const Coord& cell : cells) {
        const double d = signed_distance_um(piece, lattice.position(cell));
        if (d > band_um) continue;
        const auto before = static_cast<double>(distances.getValue(cell));
        distances.setValue(cell, static_cast<float>(smooth_min(before, d, piece.blend_um)));
    }
}

/// Cuts quadrilaterals along the shorter diagonal, unless that joins two points already joined elsewhere.
Mesh triangles_of(const std::vector<openvdb::Vec3s>& points, const std::vector<openvdb::Vec4I>& quads,
                  const Lattice& lattice) {
    Mesh mesh;
    mesh.vertices.reserve(points.size());
    for (const auto& p : points) {
        const Vec3 index{static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
        mesh.vertices.push_back(lattice.spacing_um * (index + lattice.shift));
    }
    mesh.triangles.reserve(2 * quads.size());
    for (const auto& q : quads) {
        const auto diagonal = [&](int i, int j) { return length_squared(mesh.vertices[q[i]] - mesh.vertices[q[j]]); };
        if (diagonal(0, 2) <= diagonal(1, 3)) {
            mesh.triangles.push_back({q[0], q[1], q[2]});
            mesh.triangles.push_back({q[0], q[2], q[3]});
        } else {
            mesh.triangles.push_back({q[0], q[1], q[3]});
            mesh.triangles.push_back({q[1], q[2], q[3]});
        }
    }
    if (signed_volume(mesh) < 0) {
        for (auto& triangle : mesh.triangles)
            std::swap(triangle[1], triangle[2]);
    }
    return mesh;
}

Mesh skin_on(const std::vector<RoundCone>& pieces, const Lattice& lattice) {
    constexpr float kOutside_um = 1e3F;
    const auto grid = new_grid<FloatGrid>(kOutside_um);
    auto distances = grid->getAccessor();
    for (const RoundCone& piece : pieces)
        melt_in(piece, lattice, distances);
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*grid, points, quads, 0.0);
    return triangles_of(points, quads, lattice);
}

}  // namespace

std::vector<RoundCone> body_of(const Morphology& morphology) {
    std::vector<RoundCone> pieces;
    for (std::size_t i = 0; i < morphology.points.size(); ++i) {
        const MorphologyPoint& point = morphology.points[i];
        if (point.parent < 0) {
            pieces.push_back({point.position, point.position, point.radius_um, point.radius_um, 0});
            continue;
        }
        const MorphologyPoint& parent = morphology.points[static_cast<std::size_t>(point.parent)];
        const bool branches_off = static_cast<std::size_t>(point.parent) + 1 != i;
        RoundCone piece{parent.position, point.position, parent.radius_um, point.radius_um, 0};
        if (parent.part == CellPart::Soma) {
            // A cable swells where it leaves the soma.
            const double foot = std::min(0.75 * parent.radius_um, 2.5 * point.radius_um);
            if (point.part != CellPart::Soma) piece.begin_radius_um = foot;
            piece.blend_um = kSomaBlend_um;
        } else if (branches_off) {
            // A branch starts as thick as it is itself, not as its parent.
            piece.begin_radius_um = std::min(parent.radius_um, 1.3 * point.radius_um);
            piece.blend_um = 0.3 * point.radius_um;
        }
        pieces.push_back(piece);
    }
    return pieces;
}

Mesh make_skin(const std::vector<RoundCone>& pieces, double resolution_um) {
    if (!(resolution_um > 0)) throw InputError("the surface's resolution must be positive");
    Mesh best;
    std::size_t fewest = 0;
    // A lattice may touch the body so that two sheets of the surface share an edge; another one will not.
    for (int attempt = 0; attempt < 8; ++attempt) {
        const Lattice lattice{resolution_um, {0.37 * attempt, 0.61 * attempt, 0.83 * attempt}};
        Mesh skin = skin_on(pieces, lattice);
        const std::size_t bad = count_bad_edges(skin);
        if (attempt == 0 || bad < fewest) {
            best = std::move(skin);
            fewest = bad;
        }
        if (fewest == 0) break;
    }
    return best;
}

}  // namespace fluovox
