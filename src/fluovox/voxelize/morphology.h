#pragma once

#include "fluovox/core/vec.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// The convex hull of two balls: one segment of a neurite, or a ball where both ends agree. With a normal: a slice of a
/// soma, the hull of two discs across it.
struct Capsule {
    Vec3 from, to;
    double from_radius = 0;
    double to_radius = 0;
    Vec3 normal = {};  ///< of both discs, of length one; zero for balls

    bool is_frustum() const { return dot(normal, normal) > 0; }
};

/// What was found in a morphology file, and mended.
struct MorphologyReport {
    std::size_t points = 0;
    std::size_t roots = 0;
    std::size_t soma_points = 0;
    std::size_t branch_points = 0;
    std::size_t spines = 0;
    double cable_length = 0;          ///< in the file's unit, without the soma
    std::size_t mended_radii = 0;     ///< zero or negative: taken from the nearest neighbour that has one
    std::size_t zero_lengths = 0;     ///< points on top of their parent
    std::size_t missing_parents = 0;  ///< made roots
    std::size_t cycles = 0;           ///< cut
    std::size_t repeated_points = 0;  ///< with the number of an earlier one; dropped
    std::string soma;                 ///< how the soma was made: "ball", "none" ...
};

/// A neuron as capsules whose union it is, in the file's unit.
struct CapsuleNeuron {
    std::vector<Capsule> capsules;
    MorphologyReport report;
};

bool is_morphology_file(const std::filesystem::path& file);

/// Reads SWC or Neurolucida ASC. Small damage is mended and counted. Throws InputError with the line: no points, not
/// such a file, numbers that are none, no positive radius at all.
///
/// Soma: one point is a ball; three points as NeuroMorpho.org writes them (a cylinder as wide as long) are the ball of
/// the same area; a contour (of ASC, or a ring of thin SWC points) is the ball of its area, or the ellipsoid of
/// revolution of its proportions; contours on top of each other are one body that ends half a section beyond the outer
/// ones; other somata are segments like the rest, also where every point is typed soma. A neurite that starts at the
/// soma has its own radius from the soma's centre on.
CapsuleNeuron parse_morphology(std::string_view bytes, const std::string& extension, const std::string& name);

/// Volume of one capsule.
double capsule_volume(const Capsule& capsule);

}  // namespace fluovox
