#include "fluovox/voxelize/morphology.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/voxelize/morphology_internal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace fluovox {
namespace {

/// Cuts every circle of parents at one point, which becomes a root.
void cut_cycles(MorphologyTree& tree) {
    std::vector<std::uint32_t> walk(tree.points.size(), 0);  // number of the walk that came by first
    for (std::uint32_t start = 0; start < tree.points.size(); ++start) {
        std::uint32_t at = start;
        while (at != kNoParent && walk[at] == 0) {
            walk[at] = start + 1;
            std::uint32_t& parent = tree.points[at].parent;
            if (parent != kNoParent && walk[parent] == start + 1) {
                parent = kNoParent;
                ++tree.report.cycles;
            }
            at = parent;
        }
    }
}

/// Every point after its parent; as in the file where it keeps to that.
std::vector<std::uint32_t> parents_first(const std::vector<TracedPoint>& points) {
    std::vector<std::uint32_t> order;
    order.reserve(points.size());
    std::vector<bool> placed(points.size(), false);
    std::vector<std::uint32_t> line;
    for (std::uint32_t start = 0; start < points.size(); ++start) {
        for (std::uint32_t at = start; at != kNoParent && !placed[at]; at = points[at].parent) {
            placed[at] = true;
            line.push_back(at);
        }
        order.insert(order.end(), line.rbegin(), line.rend());
        line.clear();
    }
    return order;
}

bool has_radius(const TracedPoint& point) {
    return point.radius > 0;
}

/// Hands radii down and up the tree to points without, between points that `akin` allows.
template <class Akin>
void hand_radii(std::vector<TracedPoint>& points, const std::vector<std::uint32_t>& order, const Akin& akin) {
    const auto down = [&] {
        for (const std::uint32_t i : order) {
            TracedPoint& point = points[i];
            if (has_radius(point) || point.parent == kNoParent) continue;
            const TracedPoint& parent = points[point.parent];
            if (has_radius(parent) && akin(point, parent)) point.radius = parent.radius;
        }
    };
    down();
    const std::vector<std::uint32_t> children_first(order.rbegin(), order.rend());
    for (const std::uint32_t i : children_first) {
        const TracedPoint& point = points[i];
        if (!has_radius(point) || point.parent == kNoParent) continue;
        TracedPoint& parent = points[point.parent];
        if (!has_radius(parent) && akin(point, parent)) parent.radius = point.radius;
    }
    down();
}

/// Gives points without one the least radius of the others, among those that `chosen` takes.
template <class Chosen>
void give_least_radius(std::vector<TracedPoint>& points, const Chosen& chosen) {
    double least = std::numeric_limits<double>::max();
    for (const TracedPoint& point : points)
        if (has_radius(point) && chosen(point)) least = std::min(least, point.radius);
    if (least == std::numeric_limits<double>::max()) return;
    for (TracedPoint& point : points)
        if (!has_radius(point) && chosen(point)) point.radius = least;
}

/// Gives points without a positive radius that of the nearest ancestor of their type that has one, or else of a
/// descendant; then of any neurite; a soma's only where the file has no other.
void mend_radii(MorphologyTree& tree, const std::string& name) {
    auto& points = tree.points;
    const auto bad = points.size() - static_cast<std::size_t>(std::count_if(points.begin(), points.end(), has_radius));
    if (bad == 0) return;
    if (bad == points.size()) throw InputError(name + ": not one of its points has a radius above zero");
    tree.report.mended_radii = bad;
    const std::vector<std::uint32_t> order = parents_first(points);
    const auto soma = [](const TracedPoint& p) { return p.type == kSomaType; };
    using Point = TracedPoint;
    hand_radii(points, order, [](const Point& a, const Point& b) { return a.type == b.type; });
    hand_radii(points, order, [&](const Point& a, const Point& b) { return soma(a) == soma(b); });
    for (const bool of_soma : {false, true})
        give_least_radius(points, [&](const Point& point) { return soma(point) == of_soma; });
    hand_radii(points, order, [](const Point&, const Point&) { return true; });
    give_least_radius(points, [](const Point&) { return true; });
}

void add_ball(CapsuleNeuron& morphology, const Vec3& center, double radius) {
    morphology.capsules.push_back({center, center, radius, radius});
}

struct SomaDrawing {
    bool as_segments = true;     ///< its points are drawn like those of neurites
    std::optional<Vec3> center;  ///< of a body that neurites have to reach
};

SomaDrawing add_soma(CapsuleNeuron& morphology, const MorphologyTree& tree) {
    std::vector<std::uint32_t> soma;
    for (std::uint32_t i = 0; i < tree.points.size(); ++i)
        if (tree.points[i].type == kSomaType) soma.push_back(i);
    MorphologyReport& report = morphology.report;
    report.soma_points = soma.size();
    if (!tree.soma_contours.empty()) {
        morphology.capsules = soma_body(tree.soma_contours);
        report.soma = tree.soma_contours.size() == 1 ? "contour" : "contours";
        if (morphology.capsules.empty()) report.soma = "none (its contour has no area)";
        return {};
    }
    if (soma.empty()) {
        report.soma = "none";
        return {};
    }
    if (const std::vector<Vec3> outline = soma_outline(tree); !outline.empty()) {
        morphology.capsules = soma_body({outline});
        report.soma = "outline (" + std::to_string(outline.size()) + " thin points in a ring: taken as its contour)";
        Vec3 center;
        for (const Vec3& point : outline)
            center = center + (1.0 / static_cast<double>(outline.size())) * point;
        return {false, center};
    }
    const TracedPoint& first = tree.points[soma[0]];
    if (soma.size() == 1) {
        add_ball(morphology, first.position, first.radius);
        report.soma = "ball";
        return {false, {}};
    }
    // NeuroMorpho.org's cylinder: two more points at one radius on either side; 2 pi r 2 r is a ball's area.
    const bool cylinder =
        soma.size() == 3 && std::all_of(soma.begin() + 1, soma.end(), [&](std::uint32_t i) {
            const double away = length(tree.points[i].position - first.position);
            return tree.points[i].parent == soma[0] && std::abs(away - first.radius) < 0.05 * first.radius;
        });
    if (cylinder) {
        add_ball(morphology, first.position, first.radius);
        report.soma = "ball (of the area of a cylinder of three points)";
        return {false, {}};
    }
    report.soma =
        soma.size() == tree.points.size() ? "none (every point is typed soma: taken as neurites)" : "segments";
    return {};
}

/// How many points follow each one, noting roots and branches.
std::vector<std::uint32_t> count_children(const MorphologyTree& tree, MorphologyReport& report) {
    std::vector<std::uint32_t> children(tree.points.size(), 0);
    for (const TracedPoint& point : tree.points) {
        if (point.parent == kNoParent) {
            ++report.roots;
        } else if (++children[point.parent] == 2) {
            ++report.branch_points;
        }
    }
    return children;
}

/// Draws the way from a point's parent to it.
void add_segment(CapsuleNeuron& morphology, const TracedPoint& parent, const TracedPoint& point,
                 const SomaDrawing& drawing) {
    MorphologyReport& report = morphology.report;
    const double step = length(point.position - parent.position);
    if (step == 0) ++report.zero_lengths;
    if (point.type != kSomaType) report.cable_length += step;
    // A cable that leaves the soma, a spine or an axon that leaves a dendrite is as thick at its foot as it is
    // itself.
    const bool sprouts = parent.type != point.type && parent.type >= kSomaType && parent.type <= kLastCableType;
    if (sprouts && point.type == kSpineType) ++report.spines;
    if (sprouts && parent.type == kSomaType && drawing.center)
        morphology.capsules.push_back({*drawing.center, parent.position, point.radius, point.radius});
    morphology.capsules.push_back(
        {parent.position, point.position, sprouts ? point.radius : parent.radius, point.radius});
}

}  // namespace

CapsuleNeuron build_morphology(MorphologyTree tree, const std::string& name) {
    if (tree.points.empty() && tree.soma_contours.empty()) throw InputError(name + ": has no points");
    if (!tree.points.empty()) {
        cut_cycles(tree);
        mend_radii(tree, name);
    }
    CapsuleNeuron morphology;
    morphology.report = tree.report;
    MorphologyReport& report = morphology.report;
    report.points = tree.points.size();
    report.spines = tree.spines.size();
    const SomaDrawing drawing = add_soma(morphology, tree);
    const std::vector<std::uint32_t> children = count_children(tree, report);
    for (std::size_t i = 0; i < tree.points.size(); ++i) {
        const TracedPoint& point = tree.points[i];
        if (point.type == kSomaType && !drawing.as_segments) continue;
        if (point.parent != kNoParent) {
            add_segment(morphology, tree.points[point.parent], point, drawing);
        } else if (children[i] == 0) {
            add_ball(morphology, point.position, point.radius);
        }
    }
    morphology.capsules.insert(morphology.capsules.end(), tree.spines.begin(), tree.spines.end());
    return morphology;
}

bool is_morphology_file(const std::filesystem::path& file) {
    const std::string extension = lower_case(file.extension().string());
    return extension == ".swc" || extension == ".asc";
}

CapsuleNeuron parse_morphology(std::string_view bytes, const std::string& extension, const std::string& name) {
    if (bytes.empty()) throw InputError(name + ": is empty");
    const bool swc = lower_case(extension) == ".swc";
    return build_morphology(swc ? parse_swc(bytes, name) : parse_asc(bytes, name), name);
}

double capsule_volume(const Capsule& capsule) {
    using std::numbers::pi;
    const double a = capsule.from_radius;
    const double b = capsule.to_radius;
    const double distance = length(capsule.to - capsule.from);
    if (capsule.is_frustum()) {
        return pi * std::abs(dot(capsule.to - capsule.from, capsule.normal)) * (a * a + a * b + b * b) / 3;
    }
    const double larger = std::max(a, b);
    if (distance <= std::abs(a - b)) return 4 * pi / 3 * larger * larger * larger;
    // Two cut balls and the frustum between the circles where the common cone touches them.
    const double sine = (a - b) / distance;
    const double cosine2 = 1 - sine * sine;
    const double ra = a * std::sqrt(cosine2);
    const double rb = b * std::sqrt(cosine2);
    const double height = distance - (a - b) * sine;
    const auto cap = [](double r, double from_center) {  // part of a ball beyond a plane
        const double h = r - from_center;
        return pi * h * h * (3 * r - h) / 3;
    };
    return 4 * pi / 3 * a * a * a - cap(a, a * sine) + cap(b, b * sine) +
           pi * height * (ra * ra + ra * rb + rb * rb) / 3;
}

}  // namespace fluovox
