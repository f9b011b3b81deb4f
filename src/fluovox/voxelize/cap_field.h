#pragma once

#include "fluovox/voxelize/winding_tree.h"

#include <array>

namespace fluovox {

/// The winding number of caps within one block of voxels. Away from the caps it is smooth, and a few values serve for
/// all of the block or for an eighth of it; close by each point is asked for itself.
class CapField {
public:
    /// The block from `corner`, `side` long each way.
    CapField(const WindingTree& caps, const Vec3& corner, double side);

    double operator()(const Vec3& point) const;

private:
    /// A cube with values at 3 x 3 x 3 points of it, where it is smooth.
    struct Cube {
        Vec3 corner;
        double side = 0;
        bool smooth = false;
        std::array<double, 27> values{};

        double interpolated(const Vec3& point) const;
    };

    Cube make_cube(const Vec3& corner, double side) const;

    const WindingTree& caps_;
    Cube whole_;
    std::array<Cube, 8> eighths_;
};

}  // namespace fluovox
