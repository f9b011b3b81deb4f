#pragma once

#include "fluovox/voxelize/morphology.h"

#include <cstdint>
#include <limits>

namespace fluovox {

constexpr std::uint32_t kNoParent = std::numeric_limits<std::uint32_t>::max();
constexpr int kSomaType = 1;       // of SWC
constexpr int kLastCableType = 4;  // 2 axon, 3 basal and 4 apical dendrite
constexpr int kSpineType = 5;      // on a cable; an older meaning is a fork, of type 0

struct TracedPoint {
    Vec3 position;
    double radius = 0;
    int type = 0;
    std::uint32_t parent = kNoParent;  ///< by place in the list
};

/// Points with parents, a contour of the soma where the file has one, and spines.
struct MorphologyTree {
    std::vector<TracedPoint> points;
    std::vector<std::vector<Vec3>> soma_contours;
    std::vector<Capsule> spines;
    MorphologyReport report;
};

MorphologyTree parse_swc(std::string_view bytes, const std::string& name);
MorphologyTree parse_asc(std::string_view bytes, const std::string& name);

/// Bodies of the contours: ellipsoids of single ones, and one body of a stack. Contours without an area are left out.
std::vector<Capsule> soma_body(const std::vector<std::vector<Vec3>>& contours);

/// The soma points as the contour that they are, where they are one: four at least, in one row that closes, and much
/// thinner than what they go around. Empty otherwise.
std::vector<Vec3> soma_outline(const MorphologyTree& tree);

/// Mends a tree and makes capsules of it.
CapsuleNeuron build_morphology(MorphologyTree tree, const std::string& name);

}  // namespace fluovox
