#include "fluovox/voxelize/winding_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

Vec3 centroid(const std::array<Vec3, 3>& t) {
    return (1.0 / 3) * (t[0] + t[1] + t[2]);
}

Vec3 area_vector(const std::array<Vec3, 3>& t) {
    return 0.5 * cross(t[1] - t[0], t[2] - t[0]);
}

}  // namespace

double solid_angle(const std::array<Vec3, 3>& triangle, const Vec3& point) {
    const Vec3 a = triangle[0] - point;
    const Vec3 b = triangle[1] - point;
    const Vec3 c = triangle[2] - point;
    const double la = length(a);
    const double lb = length(b);
    const double lc = length(c);
    const double volume = dot(a, cross(b, c));
    const double denominator = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    if (volume == 0) return 0;
    return 2 * std::atan2(volume, denominator);
}

WindingTree::WindingTree(const Mesh& mesh) {
    triangles_.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles)
        triangles_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    if (!triangles_.empty()) build(0, triangles_.size());
}

void WindingTree::build(std::size_t begin, std::size_t end) {
    constexpr std::size_t kLeaf = 1;
    const std::size_t index = nodes_.size();
    Node node;
    node.begin = begin;
    node.end = end;
    Bounds bounds;
    Vec3 mean;
    double area = 0;
    for (std::size_t i = begin; i < end; ++i) {
        const Vec3 vector = area_vector(triangles_[i]);
        node.normal = node.normal + vector;
        const double weight = length(vector);
        mean = mean + weight * centroid(triangles_[i]);
        area += weight;
        bounds.add(centroid(triangles_[i]));
    }
    node.center = area > 0 ? (1 / area) * mean : bounds.center();
    for (std::size_t i = begin; i < end; ++i) {
        for (const Vec3& corner : triangles_[i])
            node.radius = std::max(node.radius, length(corner - node.center));
    }
    nodes_.push_back(node);
    if (end - begin <= kLeaf) return;
    const Vec3 size = bounds.size();
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto first = triangles_.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                     first + static_cast<std::ptrdiff_t>(end),
                     [axis](const auto& a, const auto& b) { return centroid(a)[axis] < centroid(b)[axis]; });
    build(begin, middle);
    nodes_[index].right = nodes_.size();
    build(middle, end);
}

double WindingTree::operator()(const Vec3& point) const {
    return triangles_.empty() ? 0 : evaluate(0, point) / (4 * std::numbers::pi);
}

double WindingTree::evaluate(std::size_t index, const Vec3& point) const {
    constexpr double kFar = 2.2;  // radii; the dipole's error falls with the square of it
    const Node& node = nodes_[index];
    const Vec3 to = node.center - point;
    const double distance = length(to);
    if (distance > kFar * node.radius) return dot(to, node.normal) / (distance * distance * distance);
    if (node.right != 0) return evaluate(index + 1, point) + evaluate(node.right, point);
    double sum = 0;
    for (std::size_t i = node.begin; i < node.end; ++i)
        sum += solid_angle(triangles_[i], point);
    return sum;
}

}  // namespace fluovox
