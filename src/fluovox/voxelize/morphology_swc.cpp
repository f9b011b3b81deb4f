#include "fluovox/voxelize/mesh_readers.h"
#include "fluovox/voxelize/morphology_internal.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace fluovox {

MorphologyTree parse_swc(std::string_view bytes, const std::string& name) {
    MorphologyTree tree;
    TextScanner in(bytes, name);
    std::unordered_map<long long, std::uint32_t> places;
    std::vector<long long> parents;
    while (in.next_line('#')) {
        // Some programs write whole numbers as 3.0 or 3e+000.
        const double written = in.number();
        if (std::abs(written) > 1e15) in.fail("the number of a point is out of range");
        const auto number = static_cast<long long>(written);
        TracedPoint point;
        point.type = static_cast<int>(std::min(std::max(in.number(), 0.0), 1e6));
        for (int axis = 0; axis < 3; ++axis)
            point.position[axis] = in.number();
        point.radius = in.number();
        const auto parent = static_cast<long long>(std::min(std::max(in.number(), -1.0), 1e15));
        if (!places.emplace(number, static_cast<std::uint32_t>(tree.points.size())).second) {
            ++tree.report.repeated_points;
            continue;
        }
        tree.points.push_back(point);
        parents.push_back(parent);
    }
    for (std::size_t i = 0; i < tree.points.size(); ++i) {
        if (parents[i] < 0) continue;
        const auto parent = places.find(parents[i]);
        if (parent == places.end()) {
            ++tree.report.missing_parents;
        } else {
            tree.points[i].parent = parent->second;
        }
    }
    return tree;
}

}  // namespace fluovox
