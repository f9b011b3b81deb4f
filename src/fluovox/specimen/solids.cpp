#include "fluovox/specimen/solids.h"

#include "fluovox/voxelize/mesh_topology.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <sstream>
#include <utility>

namespace fluovox {
namespace {

Mesh make_icosahedron() {
    const double g = std::numbers::phi;
    Mesh mesh;
    for (const double a : {-1.0, 1.0}) {
        for (const double b : {-g, g}) {
            mesh.vertices.push_back({a, b, 0});
            mesh.vertices.push_back({0, a, b});
            mesh.vertices.push_back({b, 0, a});
        }
    }
    // Neighbours are 2 apart; each triple of mutual neighbours is a face.
    const auto near = [&](std::uint32_t i, std::uint32_t j) {
        return length_squared(mesh.vertices[i] - mesh.vertices[j]) < 4.1;
    };
    const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = i + 1; j < count; ++j) {
            for (std::uint32_t k = j + 1; k < count; ++k) {
                if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
                const Vec3 p = mesh.vertices[i];
                const Vec3 normal = cross(mesh.vertices[j] - p, mesh.vertices[k] - p);
                if (dot(normal, p) > 0)
                    mesh.triangles.push_back({i, j, k});
                else
                    mesh.triangles.push_back({i, k, j});
            }
        }
    }
    return mesh;
}

Mesh divided(const Mesh& coarse) {
    Mesh fine{coarse.vertices, {}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t i, std::uint32_t j) {
        const auto next = static_cast<std::uint32_t>(fine.vertices.size());
        const auto [entry, is_new] = middles.try_emplace(std::minmax(i, j), next);
        if (is_new) fine.vertices.push_back(0.5 * (fine.vertices[i] + fine.vertices[j]));
        return entry->second;
    };
    for (const auto& [a, b, c] : coarse.triangles) {
        const std::uint32_t ab = middle(a, b);
        const std::uint32_t bc = middle(b, c);
        const std::uint32_t ca = middle(c, a);
        fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    return fine;
}

}  // namespace

std::size_t count_bad_edges(const Mesh& mesh) {
    std::size_t bad = 0;
    const EdgeUses uses = sorted_edge_uses(mesh);
    for_each_edge(uses, [&](std::size_t first, std::size_t last) {
        const bool good = last - first == 2 && uses[first].forward() != uses[first + 1].forward();
        if (!good) ++bad;
    });
    return bad;
}

Mesh make_ball(Vec3 center, double radius_um, int divisions) {
    Mesh ball = make_icosahedron();
    for (int i = 0; i < divisions; ++i)
        ball = divided(ball);
    for (Vec3& point : ball.vertices)
        point = normalized(point);
    const double sphere = 4 * std::numbers::pi / 3;
    const double scale = radius_um * std::cbrt(sphere / signed_volume(ball));
    for (Vec3& point : ball.vertices)
        point = center + scale * point;
    return ball;
}

Mesh stretched(Mesh mesh, Vec3 center, Vec3 factors) {
    for (Vec3& point : mesh.vertices) {
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = center[axis] + factors[axis] * (point[axis] - center[axis]);
    }
    return mesh;
}

std::string to_obj(const Mesh& mesh, const std::string& comment) {
    std::string text;
    std::istringstream lines(comment);
    for (std::string line; std::getline(lines, line);)
        text += line.empty() ? "#\n" : "# " + line + '\n';
    auto out = std::back_inserter(text);
    for (const Vec3& p : mesh.vertices)
        fmt::format_to(out, "v {:.4f} {:.4f} {:.4f}\n", p.x, p.y, p.z);
    for (const auto& [a, b, c] : mesh.triangles)
        fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
    return text;
}

}  // namespace fluovox
