#include "fluovox/voxelize/winding_tree.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace fluovox {
namespace {

Vec3 centroid(const std::array<Vec3, 3>& t) {
    return (1.0 / 3) * (t[0] + t[1] + t[2]);
}

Vec3 area_vector(const std::array<Vec3, 3>& t) {
    return 0.5 * cross(t[1] - t[0], t[2] - t[0]);
}

/// The halves of a triangle's solid angle as the argument of a complex number.
std::pair<double, double> half_angle(const std::array<Vec3, 3>& triangle, const Vec3& point) {
    const Vec3 a = triangle[0] - point;
    const Vec3 b = triangle[1] - point;
    const Vec3 c = triangle[2] - point;
    const double la = length(a);
    const double lb = length(b);
    const double lc = length(c);
    const double volume = dot(a, cross(b, c));
    return {la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb, volume};
}

/// Sums solid angles, most of them by multiplying complex numbers instead of an arc tangent each.
class AngleSum {
public:
    void add(const std::array<Vec3, 3>& triangle, const Vec3& point) {
        const auto [re, im] = half_angle(triangle, point);
        if (im == 0) return;
        const double size = std::abs(re) + std::abs(im);
        const double x = re / size;
        const double y = im / size;
        // While both are within a quarter turn of zero, their product's argument is the sum.
        if (!(x > 0)) {
            sum_ += std::atan2(y, x);
            return;
        }
        const double product = re_ * x - im_ * y;
        im_ = re_ * y + im_ * x;
        re_ = product;
        if (re_ > kLeast) return;
        sum_ += std::atan2(im_, re_);
        re_ = 1;
        im_ = 0;
    }
    double total() const { return 2 * (sum_ + std::atan2(im_, re_)); }

private:
    static constexpr double kLeast = 1e-3;  // products of numbers up to one get smaller

    double sum_ = 0;
    double re_ = 1;
    double im_ = 0;
};

/// Adds the integral of d d^T over the triangle, d from `center`.
void add_spread(const std::array<Vec3, 3>& t, const Vec3& center, std::array<Vec3, 3>& spread) {
    const double twelfth = length(area_vector(t)) / 12;
    Vec3 sum;
    const auto add = [&](const Vec3& d) {
        for (int row = 0; row < 3; ++row)
            spread[static_cast<std::size_t>(row)] = spread[static_cast<std::size_t>(row)] + (twelfth * d[row]) * d;
    };
    for (const Vec3& corner : t) {
        const Vec3 d = corner - center;
        sum = sum + d;
        add(d);
    }
    add(sum);
}

}  // namespace

double solid_angle(const std::array<Vec3, 3>& triangle, const Vec3& point) {
    const auto [denominator, volume] = half_angle(triangle, point);
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
    node.area = area;
    for (std::size_t i = begin; i < end; ++i)
        add_spread(triangles_[i], node.center, node.spread);
    for (std::size_t i = begin; i < end; ++i) {
        for (const Vec3& corner : triangles_[i])
            node.radius = std::max(node.radius, length(corner - node.center));
    }
    nodes_.push_back(node);
    nodes_[index].next = nodes_.size();
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
    nodes_[index].next = nodes_.size();
}

double WindingTree::operator()(const Vec3& point) const {
    constexpr double kFar = 2.2;  // radii; the error falls with the fourth power of it
    double far = 0;
    AngleSum near;
    for (std::size_t index = 0; index < nodes_.size();) {
        const Node& node = nodes_[index];
        const Vec3 to = node.center - point;
        const double squared = dot(to, to);
        if (squared > kFar * kFar * node.radius * node.radius) {
            const Vec3 spread_to = {dot(node.spread[0], to), dot(node.spread[1], to), dot(node.spread[2], to)};
            const double trace = node.spread[0].x + node.spread[1].y + node.spread[2].z;
            const double facing = dot(to, node.normal);
            const double second =
                -3 * dot(node.normal, spread_to) + facing * (7.5 * dot(to, spread_to) / squared - 1.5 * trace);
            far += (facing + second / (node.area * squared)) / (squared * std::sqrt(squared));
            index = node.next;
            continue;
        }
        if (node.right == 0) {
            for (std::size_t i = node.begin; i < node.end; ++i)
                near.add(triangles_[i], point);
        }
        ++index;
    }
    return (far + near.total()) / (4 * std::numbers::pi);
}

bool WindingTree::any_within(const Vec3& point, double distance) const {
    for (std::size_t index = 0; index < nodes_.size();) {
        const Node& node = nodes_[index];
        if (length(node.center - point) > distance + node.radius) {
            index = node.next;
            continue;
        }
        if (node.right == 0) return true;
        ++index;
    }
    return false;
}

}  // namespace fluovox
