#include "fluovox/voxelize/mesh_readers.h"

#include <algorithm>

namespace fluovox {

void add_polygon(Mesh& mesh, const std::vector<std::uint32_t>& corners) {
    for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

/// The corners of a face by their vertices' numbers, with `vertices` of them read so far.
void read_face(TextScanner& in, std::size_t vertices, std::vector<std::uint32_t>& corners) {
    corners.clear();
    for (auto corner = in.token(); !corner.empty(); corner = in.token()) {
        auto index = to_integer(corner.substr(0, corner.find('/')), in);
        index = index < 0 ? static_cast<long long>(vertices) + index : index - 1;
        if (index < 0 || index > 0xfffffffeLL) in.fail("a face uses a vertex that does not exist");
        corners.push_back(static_cast<std::uint32_t>(index));
    }
    if (corners.size() < 3) in.fail("a face has fewer than three corners");
}

Mesh parse_obj(std::string_view bytes, const std::string& name) {
    Mesh mesh;
    std::vector<std::uint32_t> corners;
    TextScanner in(bytes, name);
    // Faces may come before their vertices, so how many there are shows only at the end.
    long long largest = -1;
    while (in.next_line('#')) {
        const auto keyword = in.token();
        if (keyword == "v") {
            const double x = in.number();
            const double y = in.number();
            mesh.vertices.push_back({x, y, in.number()});
        } else if (keyword == "f") {
            read_face(in, mesh.vertices.size(), corners);
            for (const std::uint32_t corner : corners)
                largest = std::max(largest, static_cast<long long>(corner));
            add_polygon(mesh, corners);
        }
    }
    if (mesh.triangles.empty()) in.fail_without_triangles(mesh.vertices.size());
    if (largest >= static_cast<long long>(mesh.vertices.size())) {
        in.fail("a face uses vertex " + std::to_string(largest + 1) + ", and there are " +
                std::to_string(mesh.vertices.size()) + " (is the file truncated?)");
    }
    return mesh;
}

Mesh parse_off(std::string_view bytes, const std::string& name) {
    TextScanner in(bytes, name);
    std::string_view token;
    if (!in.token_anywhere('#', token) || !token.ends_with("OFF") || token.ends_with("4OFF") ||
        token.ends_with("nOFF")) {
        in.fail("is not an OFF file of points in space (it does not begin with OFF)");
    }
    const long long vertices = in.integer_anywhere('#');
    const long long faces = in.integer_anywhere('#');
    in.integer_anywhere('#');  // edges, which nobody counts
    if (vertices < 0 || faces < 0) in.fail("has a negative number of vertices or faces");
    Mesh mesh;
    // Each vertex and face has its line; what follows the numbers we want (normals, colours) is passed over.
    for (long long i = 0; i < vertices; ++i) {
        if (!in.next_line('#')) in.fail("is truncated: " + std::to_string(vertices - i) + " vertices are missing");
        const double x = in.number();
        const double y = in.number();
        mesh.vertices.push_back({x, y, in.number()});
    }
    std::vector<std::uint32_t> corners;
    for (long long i = 0; i < faces; ++i) {
        if (!in.next_line('#')) in.fail("is truncated: " + std::to_string(faces - i) + " faces are missing");
        const long long count = in.integer();
        corners.clear();
        for (long long corner = 0; corner < count; ++corner) {
            const long long index = in.integer();
            if (index < 0 || index >= vertices) in.fail("a face uses a vertex that does not exist");
            corners.push_back(static_cast<std::uint32_t>(index));
        }
        add_polygon(mesh, corners);
    }
    if (mesh.triangles.empty()) in.fail_without_triangles(mesh.vertices.size());
    return mesh;
}

}  // namespace fluovox
