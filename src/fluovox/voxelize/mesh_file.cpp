#include "fluovox/voxelize/mesh_file.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/mesh_readers.h"

namespace fluovox {
namespace {

Mesh parse_by_extension(std::string_view bytes, const std::string& extension, const std::string& name) {
    if (extension == ".obj") return parse_obj(bytes, name);
    if (extension == ".ply") return parse_ply(bytes, name);
    if (extension == ".stl") return parse_stl(bytes, name);
    if (extension == ".off") return parse_off(bytes, name);
    if (assimp_reads(extension)) return parse_with_assimp(bytes, extension, name);
    if (extension == ".vdb") {
        throw InputError(name + ": is a grid already; --from-levelset FILE.vdb makes a concentration of a level set");
    }
    throw InputError(name + ": is no mesh that fluovox reads: OBJ, PLY, STL, OFF, glTF, GLB, FBX, DAE, 3DS ...");
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& file) {
    const std::string extension = lower_case(file.extension().string());
    if (extension.empty()) return false;
    for (const char* own : {".obj", ".ply", ".stl", ".off"})
        if (extension == own) return true;
    return assimp_reads(extension);
}

MeshFile load_mesh(const std::filesystem::path& file) {
    return parse_mesh(load_bytes(file), file.extension().string(), file.string());
}

MeshFile parse_mesh(std::string_view bytes, const std::string& extension, const std::string& name) {
    if (bytes.empty()) throw InputError(name + ": is empty");
    const std::string kind = lower_case(extension);
    MeshFile result;
    result.mesh = parse_by_extension(bytes, kind, name);
    if (result.mesh.triangles.empty()) throw InputError(name + ": has no triangles");
    if (kind == ".gltf" || kind == ".glb") {
        constexpr double kUmPerMetre = 1e6;
        result.um_per_unit = kUmPerMetre;
        for (Vec3& v : result.mesh.vertices)
            v = {v.x, -v.z, v.y};
    }
    return result;
}

}  // namespace fluovox
