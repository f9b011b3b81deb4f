#include "fluovox/core/error.h"
#include "fluovox/voxelize/mesh_readers.h"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <system_error>

namespace fluovox {
namespace {

void add_mesh(Mesh& mesh, const aiMesh& from, const aiMatrix4x4& placing, const std::string& name) {
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    for (unsigned i = 0; i < from.mNumVertices; ++i) {
        const aiVector3D v = placing * from.mVertices[i];
        if (!(std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z))) {
            throw InputError(name + ": a vertex is not finite");
        }
        mesh.vertices.push_back({static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
    }
    for (unsigned i = 0; i < from.mNumFaces; ++i) {
        const aiFace& face = from.mFaces[i];
        if (face.mNumIndices != 3) continue;  // points and lines
        Mesh::Triangle triangle{};
        for (unsigned corner = 0; corner < 3; ++corner) {
            if (face.mIndices[corner] >= from.mNumVertices) {
                throw InputError(name + ": a face uses a vertex that does not exist");
            }
            triangle[corner] = offset + face.mIndices[corner];
        }
        mesh.triangles.push_back(triangle);
    }
}

void add_node(Mesh& mesh, const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
              const std::string& name) {
    const aiMatrix4x4 placing = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
        add_mesh(mesh, *scene.mMeshes[node.mMeshes[i]], placing, name);
    for (unsigned i = 0; i < node.mNumChildren; ++i)
        add_node(mesh, scene, *node.mChildren[i], placing, name);
}

}  // namespace

bool assimp_reads(const std::string& extension) {
    return Assimp::Importer().IsExtensionSupported(extension);
}

Mesh parse_with_assimp(std::string_view bytes, const std::string& extension, const std::string& name) {
    try {
        Assimp::Importer importer;
        // From the file itself where there is one, since it may name others beside it (the .bin of a .gltf).
        std::error_code failure;
        const aiScene* const scene =
            std::filesystem::is_regular_file(name, failure)
                ? importer.ReadFile(name, aiProcess_Triangulate)
                : importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate,
                                              extension.substr(1).c_str());
        if (scene == nullptr || scene->mRootNode == nullptr) {
            throw InputError(name + ": cannot be read: " + importer.GetErrorString());
        }
        Mesh mesh;
        add_node(mesh, *scene, *scene->mRootNode, aiMatrix4x4(), name);
        return mesh;
    } catch (const InputError&) {
        throw;
    } catch (const std::exception& e) {
        throw InputError(name + ": cannot be read: " + e.what());
    }
}

}  // namespace fluovox
