#pragma once

#include "fluovox/voxelize/mesh.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {

/// What was found in a mesh, after equal vertices were welded, and what was done about it.
struct MeshReport {
    std::size_t vertices = 0;              ///< distinct ones in use
    std::size_t triangles = 0;             ///< without the degenerate ones
    std::size_t welded_vertices = 0;       ///< that were copies of another
    std::size_t degenerate_triangles = 0;  ///< with two equal corners; dropped
    std::size_t boundary_edges = 0;        ///< with one triangle
    std::size_t nonmanifold_edges = 0;     ///< with three or more
    std::size_t misoriented_edges = 0;     ///< whose two triangles disagree about where outside is
    std::size_t components = 0;            ///< connected by edges
    std::size_t flipped_triangles = 0;     ///< turned to agree with most of their neighbours
    std::size_t flipped_components = 0;    ///< turned inside out as a whole
    std::size_t guessed_components = 0;    ///< of these, those with uneven holes: where outside is was a guess
    std::size_t cavities = 0;              ///< components that face inwards, inside another; kept
    std::size_t holes = 0;                 ///< loops of boundary that were capped
    std::size_t uneven_holes = 0;          ///< those among them whose cap is a guess; the winding number decides there
    double area_um2 = 0;                   ///< of the mesh itself, without caps
    double volume_um3 = 0;                 ///< signed volume with caps; overlapping parts count twice

    bool watertight() const { return boundary_edges == 0 && misoriented_edges == 0; }
};

/// A mesh whose winding number is a whole number everywhere: every hole has a cap.
struct SolidMesh {
    Mesh mesh;                  ///< triangles of the file first, then the caps
    std::size_t first_cap = 0;  ///< index of the first cap triangle
    std::vector<std::uint8_t>
        cap_is_sure;  ///< for each cap triangle: its hole is nearly plane or at a cut, so the cap is right
    MeshReport report;
};

/// Makes a solid of any set of triangles: welds equal vertices, drops degenerate triangles, turns triangles to agree
/// with most of their neighbours and closed components that nothing encloses to face outwards, and caps every hole
/// with a fan. A closed, well-oriented mesh comes out as it went in.
///
/// The boundary of any set of oriented triangles, counted with signs, is made of closed loops (the boundary of a
/// boundary is nothing), so caps always close it.
SolidMesh make_solid(const Mesh& mesh);

}  // namespace fluovox
