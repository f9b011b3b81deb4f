#include "fluovox/voxelize/mesh.h"

#include "fluovox/voxelize/chunks.h"

namespace fluovox {

Bounds mesh_bounds(const Mesh& mesh) {
    Bounds bounds;
    for (const Bounds& part : map_chunks(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
             Bounds some;
             for (std::size_t t = begin; t < end; ++t) {
                 for (const std::uint32_t vertex : mesh.triangles[t])
                     some.add(mesh.vertices[vertex]);
             }
             return some;
         }))
        bounds.add(part);
    return bounds;
}

double signed_volume(const Mesh& mesh) {
    if (mesh.triangles.empty()) return 0;
    const Vec3 origin = mesh_bounds(mesh).center();
    return sum_of(mesh.triangles.size(),
                  [&](std::size_t number) {
                      const auto& t = mesh.triangles[number];
                      const Vec3 a = mesh.vertices[t[0]] - origin;
                      const Vec3 b = mesh.vertices[t[1]] - origin;
                      const Vec3 c = mesh.vertices[t[2]] - origin;
                      return dot(a, cross(b, c));
                  }) /
           6;
}

double surface_area(const Mesh& mesh) {
    return sum_of(mesh.triangles.size(), [&](std::size_t number) {
        const auto& t = mesh.triangles[number];
        const Vec3 a = mesh.vertices[t[0]];
        return length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)) / 2;
    });
}

void append(Mesh& mesh, const Mesh& other) {
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles)
        mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

}  // namespace fluovox
