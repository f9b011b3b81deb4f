#pragma once

#include "fluovox/voxelize/mesh.h"

#include <array>
#include <cstddef>
#include <vector>

namespace fluovox {

/// The generalized winding number of a set of triangles, by a hierarchy of dipoles for what is far away.
/// Jacobson et al., ACM TOG 32(4), 2013; Barill et al., ACM TOG 37(4), 2018; the second-order term takes a
/// group's normal for that of all its parts.
class WindingTree {
public:
    WindingTree() = default;
    explicit WindingTree(const Mesh& mesh);

    bool empty() const { return triangles_.empty(); }
    /// Solid angle of the triangles seen from `point`, over 4 pi; positive on the side that they face away from. Near 1
    /// inside a closed surface and 0 outside. Far groups are off by 1 % at most.
    double operator()(const Vec3& point) const;

    /// Whether a triangle may be nearer to `point` than `distance`.
    bool any_within(const Vec3& point, double distance) const;

private:
    struct Node {
        Vec3 center;  // weighted by area
        Vec3 normal;  // sum of area times unit normal
        double area = 0;
        std::array<Vec3, 3> spread;  // integral of d d^T over the area, d from `center`
        double radius = 0;           // of a ball around `center` that holds all
        std::size_t begin = 0;       // triangles
        std::size_t end = 0;
        std::size_t right = 0;  // the left child follows its parent; 0: a leaf
        std::size_t next = 0;   // the node after this one and all below it
    };

    void build(std::size_t begin, std::size_t end);

    std::vector<std::array<Vec3, 3>> triangles_;
    std::vector<Node> nodes_;
};

/// Signed solid angle of a triangle seen from `point`. Van Oosterom & Strackee, IEEE TBME 30(2), 1983.
double solid_angle(const std::array<Vec3, 3>& triangle, const Vec3& point);

}  // namespace fluovox
