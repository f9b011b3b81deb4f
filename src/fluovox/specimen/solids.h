#pragma once

#include "fluovox/core/vec.h"
#include "fluovox/voxelize/mesh.h"

#include <cstddef>
#include <string>

namespace fluovox {

/// Edges that do not border exactly two triangles, once in each direction; 0 for a closed manifold mesh.
std::size_t count_bad_edges(const Mesh& mesh);

/// A ball of triangles: an icosahedron divided `divisions` times in four. Its points lie a little outside the sphere,
/// so that its volume is exactly the sphere's.
Mesh make_ball(Vec3 center, double radius_um, int divisions);

/// `mesh` stretched along the axes about `center`.
Mesh stretched(Mesh mesh, Vec3 center, Vec3 factors);

/// `mesh` as the text of a Wavefront OBJ file, after `comment`, each line of which gets a '#'.
std::string to_obj(const Mesh& mesh, const std::string& comment);

}  // namespace fluovox
