#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/vec.h"

#include <array>
#include <cstdint>
#include <vector>

namespace fluovox {

/// Triangles over shared vertices, counter-clockwise seen from outside. Neither closed nor clean unless something
/// says so. Coordinates are double: meshes near 1e6 keep their detail.
struct Mesh {
    using Triangle = std::array<std::uint32_t, 3>;

    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
};

/// The box around all vertices that a triangle uses.
Bounds mesh_bounds(const Mesh& mesh);

/// Volume by the divergence theorem, seen from the mesh's own centre: positive when the triangles face outwards.
/// Only of a closed mesh does it not depend on where it is seen from.
double signed_volume(const Mesh& mesh);

/// Sum of the triangles' areas.
double surface_area(const Mesh& mesh);

/// Adds the triangles of `other` to `mesh`.
void append(Mesh& mesh, const Mesh& other);

}  // namespace fluovox
