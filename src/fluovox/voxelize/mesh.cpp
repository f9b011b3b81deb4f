#include "fluovox/voxelize/mesh.h"

namespace fluovox {

Bounds mesh_bounds(const Mesh& mesh) {
    Bounds bounds;
    for (const auto& triangle : mesh.triangles) {
        for (const std::uint32_t vertex : triangle)
            bounds.add(mesh.vertices[vertex]);
    }
    return bounds;
}

double signed_volume(const Mesh& mesh) {
    if (mesh.triangles.empty()) return 0;
    const Vec3 origin = mesh_bounds(mesh).center();
    double volume = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t[0]] - origin;
        const Vec3 b = mesh.vertices[t[1]] - origin;
        const Vec3 c = mesh.vertices[t[2]] - origin;
        volume += dot(a, cross(b, c));
    }
    return volume / 6;
}

double surface_area(const Mesh& mesh) {
    double area = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t[0]];
        area += length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)) / 2;
    }
    return area;
}

void append(Mesh& mesh, const Mesh& other) {
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& t : other.triangles)
        mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

}  // namespace fluovox
