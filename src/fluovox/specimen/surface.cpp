#include "fluovox/specimen/surface.h"

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

Surface make_icosahedron() {
    const double g = std::numbers::phi;
    Surface surface;
    for (const double a : {-1.0, 1.0}) {
        for (const double b : {-g, g}) {
            surface.points.push_back({a, b, 0});
            surface.points.push_back({0, a, b});
            surface.points.push_back({b, 0, a});
        }
    }
    // Neighbours are 2 apart; each triple of mutual neighbours is a face.
    const auto near = [&](std::uint32_t i, std::uint32_t j) {
        return length_squared(surface.points[i] - surface.points[j]) < 4.1;
    };
    const auto count = static_cast<std::uint32_t>(surface.points.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = i + 1; j < count; ++j) {
            for (std::uint32_t k = j + 1; k < count; ++k) {
                if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
                const Vec3 p = surface.points[i];
                const Vec3 normal = cross(surface.points[j] - p, surface.points[k] - p);
                if (dot(normal, p) > 0)
                    surface.triangles.push_back({i, j, k});
                else
                    surface.triangles.push_back({i, k, j});
            }
        }
    }
    return surface;
}

Surface divided(const Surface& coarse) {
    Surface fine{coarse.points, {}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t i, std::uint32_t j) {
        const auto next = static_cast<std::uint32_t>(fine.points.size());
        const auto [entry, is_new] = middles.try_emplace(std::minmax(i, j), next);
        if (is_new) fine.points.push_back(0.5 * (fine.points[i] + fine.points[j]));
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

void Surface::add(const Surface& other) {
    const auto offset = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), other.points.begin(), other.points.end());
    for (const auto& [a, b, c] : other.triangles)
        triangles.push_back({a + offset, b + offset, c + offset});
}

double signed_volume_um3(const Surface& surface) {
    double sum = 0;
    for (const auto& [a, b, c] : surface.triangles)
        sum += dot(surface.points[a], cross(surface.points[b], surface.points[c]));
    return sum / 6;
}

std::size_t count_bad_edges(const Surface& surface) {
    std::vector<std::array<std::uint32_t, 3>> edges;  // low point, high point, direction
    edges.reserve(3 * surface.triangles.size());
    for (const auto& triangle : surface.triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = triangle[i];
            const std::uint32_t b = triangle[(i + 1) % 3];
            edges.push_back({std::min(a, b), std::max(a, b), a < b ? 0U : 1U});
        }
    }
    std::sort(edges.begin(), edges.end());
    std::size_t bad = 0;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        while (end < edges.size() && edges[end][0] == edges[begin][0] && edges[end][1] == edges[begin][1])
            ++end;
        const bool good = end - begin == 2 && edges[begin][2] == 0 && edges[begin + 1][2] == 1;
        if (!good) ++bad;
    }
    return bad;
}

Surface make_ball(Vec3 center, double radius_um, int divisions) {
    Surface ball = make_icosahedron();
    for (int i = 0; i < divisions; ++i)
        ball = divided(ball);
    for (Vec3& point : ball.points)
        point = normalized(point);
    const double sphere = 4 * std::numbers::pi / 3;
    const double scale = radius_um * std::cbrt(sphere / signed_volume_um3(ball));
    for (Vec3& point : ball.points)
        point = center + scale * point;
    return ball;
}

Surface stretched(Surface ball, Vec3 center, Vec3 factors) {
    for (Vec3& point : ball.points) {
        for (int axis = 0; axis < 3; ++axis)
            point[axis] = center[axis] + factors[axis] * (point[axis] - center[axis]);
    }
    return ball;
}

std::string to_obj(const Surface& surface, const std::string& comment) {
    std::string text;
    std::istringstream lines(comment);
    for (std::string line; std::getline(lines, line);)
        text += line.empty() ? "#\n" : "# " + line + '\n';
    auto out = std::back_inserter(text);
    for (const Vec3& p : surface.points)
        fmt::format_to(out, "v {:.4f} {:.4f} {:.4f}\n", p.x, p.y, p.z);
    for (const auto& [a, b, c] : surface.triangles)
        fmt::format_to(out, "f {} {} {}\n", a + 1, b + 1, c + 1);
    return text;
}

}  // namespace fluovox
