#pragma once

#include "fluovox/core/vec.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace fluovox {

/// Triangles over shared points, counter-clockwise seen from outside. Micrometres.
struct Surface {
    std::vector<Vec3> points;
    std::vector<std::array<std::uint32_t, 3>> triangles;

    /// Adds all of `other`.
    void add(const Surface& other);
};

/// Volume inside a closed surface, um^3; negative when it is inside out.
double signed_volume_um3(const Surface& surface);

/// Edges that do not border exactly two triangles, once in each direction; 0 for a closed manifold surface.
std::size_t count_bad_edges(const Surface& surface);

/// A ball of triangles: an icosahedron divided `divisions` times in four. Its points lie a little outside the sphere,
/// so that its volume is exactly the sphere's.
Surface make_ball(Vec3 center, double radius_um, int divisions);

/// `ball` stretched along the axes about `center`.
Surface stretched(Surface ball, Vec3 center, Vec3 factors);

/// `surface` as the text of a Wavefront OBJ file, after `comment`, each line of which gets a '#'.
std::string to_obj(const Surface& surface, const std::string& comment);

}  // namespace fluovox
