#pragma once

#include "fluovox/voxelize/mesh.h"

#include <filesystem>
#include <string>
#include <string_view>

namespace fluovox {

/// A mesh as a file holds it, in the file's own unit.
struct MeshFile {
    Mesh mesh;
    double um_per_unit = 0;  ///< 0: the format doesn't say
};

/// Whether the name ends like a mesh that `load_mesh` reads.
bool is_mesh_file(const std::filesystem::path& file);

/// Reads OBJ, PLY, STL, OFF (in double precision), glTF, GLB and what else assimp knows (in float). Polygons become
/// triangles. Throws InputError with the place: missing, empty, truncated or damaged files, vertices that do not
/// exist or are not finite, no triangles at all.
///
/// glTF is in metres with y upwards: it comes turned to z upwards (x stays x), and says `um_per_unit`.
MeshFile load_mesh(const std::filesystem::path& file);

/// The same from the bytes of a file; `extension` (".ply") tells the format, `name` is what messages call it.
MeshFile parse_mesh(std::string_view bytes, const std::string& extension, const std::string& name);

}  // namespace fluovox
