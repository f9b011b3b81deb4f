#include "fluovox/voxelize/morphology_internal.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace fluovox {
namespace {

using std::numbers::pi;

/// A contour as a plane figure.
struct Section {
    Vec3 center;
    Vec3 normal;
    double area = 0;
    Vec3 long_axis;         ///< of its moments of area
    double proportion = 1;  ///< long by short axis of the ellipse with these moments

    double radius() const { return std::sqrt(area / pi); }  ///< of the disc of its area
};

double perimeter(const std::vector<Vec3>& contour) {
    double sum = length(contour.front() - contour.back());
    for (std::size_t i = 1; i < contour.size(); ++i)
        sum += length(contour[i] - contour[i - 1]);
    return sum;
}

/// Nothing where the contour has no area to speak of.
std::optional<Section> measure(const std::vector<Vec3>& contour) {
    Section section;
    const Vec3 origin = contour.front();
    Vec3 doubled;  // Newell's normal
    for (std::size_t i = 0; i < contour.size(); ++i)
        doubled = doubled + cross(contour[i] - origin, contour[(i + 1) % contour.size()] - origin);
    section.area = length(doubled) / 2;
    const double around = perimeter(contour);
    constexpr double kThin = 0.005;  // a circle has 0.08
    if (!(section.area > kThin * around * around)) return {};
    section.normal = normalized(doubled);
    const Vec3 n = section.normal;
    const Vec3 u = normalized(cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const Vec3 v = cross(n, u);
    // Sums over triangles from the origin, with signs, as for any polygon.
    double first_u = 0;
    double first_v = 0;
    double uu = 0;
    double uv = 0;
    double vv = 0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const Vec3 a = contour[i] - origin;
        const Vec3 b = contour[(i + 1) % contour.size()] - origin;
        const double au = dot(a, u);
        const double av = dot(a, v);
        const double bu = dot(b, u);
        const double bv = dot(b, v);
        const double twice = au * bv - av * bu;
        first_u += twice * (au + bu) / 6;
        first_v += twice * (av + bv) / 6;
        uu += twice * (au * au + au * bu + bu * bu) / 12;
        vv += twice * (av * av + av * bv + bv * bv) / 12;
        uv += twice * (2 * au * av + au * bv + av * bu + 2 * bu * bv) / 24;
    }
    const double cu = first_u / section.area;
    const double cv = first_v / section.area;
    section.center = origin + cu * u + cv * v;
    double height = 0;  // contours are plane but for their noise
    for (const Vec3& p : contour)
        height += dot(p - origin, n) / static_cast<double>(contour.size());
    section.center = section.center + height * n;
    uu = uu / section.area - cu * cu;
    vv = vv / section.area - cv * cv;
    uv = uv / section.area - cu * cv;
    const double middle = (uu + vv) / 2;
    const double spread = std::hypot((uu - vv) / 2, uv);
    const double angle = std::atan2(2 * uv, uu - vv) / 2;
    section.long_axis = std::cos(angle) * u + std::sin(angle) * v;
    constexpr double kLongest = 10;
    if (middle > spread) section.proportion = std::min(kLongest, std::sqrt((middle + spread) / (middle - spread)));
    return section;
}

/// The ellipsoid of revolution about the long axis with the section's area and proportions, a ball for a round one: the
/// union of the balls of radius b sqrt(1 - c^2 / (a^2 - b^2)) at c along its axis, |c| <= (a^2 - b^2) / a.
void add_spheroid(std::vector<Capsule>& body, const Section& section) {
    const double a = section.radius() * std::sqrt(section.proportion);
    const double b = section.radius() / std::sqrt(section.proportion);
    constexpr double kRound = 1.01;
    if (section.proportion < kRound) {
        body.push_back({section.center, section.center, section.radius(), section.radius()});
        return;
    }
    const double focal = a * a - b * b;
    constexpr int kPieces = 24;
    const auto ball = [&](int i) {
        const double c = (2.0 * i / kPieces - 1) * focal / a;
        return std::pair(section.center + c * section.long_axis, b * std::sqrt(std::max(0.0, 1 - c * c / focal)));
    };
    for (int i = 0; i < kPieces; ++i) {
        const auto [from, from_radius] = ball(i);
        const auto [to, to_radius] = ball(i + 1);
        body.push_back({from, to, from_radius, to_radius});
    }
}

/// Sections on top of each other as frusta between discs of their areas, and a paraboloid half a section high at
/// either end. Areas between sections follow a cubic (Hermite) through theirs, as those of a ball do exactly.
void add_stack(std::vector<Capsule>& body, const std::vector<Section>& stack) {
    const Vec3 n = stack.front().normal;
    const std::size_t last = stack.size() - 1;
    std::vector<double> at;
    double largest = 0;
    for (const Section& section : stack) {
        at.push_back(dot(section.center - stack.front().center, n));
        largest = std::max(largest, section.area);
    }
    const auto secant = [&](std::size_t i) { return (stack[i + 1].area - stack[i].area) / (at[i + 1] - at[i]); };
    std::vector<double> slope(stack.size(), secant(0));
    for (std::size_t i = 1; i < last; ++i) {
        const double before = at[i] - at[i - 1];
        const double after = at[i + 1] - at[i];
        slope[i] = (after * secant(i - 1) + before * secant(i)) / (before + after);
    }
    slope[last] = secant(last - 1);
    if (last > 1) {
        slope[0] = 2 * secant(0) - slope[1];
        slope[last] = 2 * secant(last - 1) - slope[last - 1];
    }
    Vec3 from = stack.front().center;
    double from_radius = stack.front().radius();
    const auto go_on = [&](const Vec3& to, double area) {
        const double to_radius = std::sqrt(area / pi);
        body.push_back({from, to, from_radius, to_radius, n});
        from = to;
        from_radius = to_radius;
    };
    constexpr int kPieces = 8;
    for (std::size_t i = 0; i < last; ++i) {
        const double step = at[i + 1] - at[i];
        const double least = std::min(stack[i].area, stack[i + 1].area);
        for (int k = 1; k <= kPieces; ++k) {
            const double s = static_cast<double>(k) / kPieces;
            const double area = stack[i].area * (1 + 2 * s) * (1 - s) * (1 - s) +
                                slope[i] * step * s * (1 - s) * (1 - s) + stack[i + 1].area * s * s * (3 - 2 * s) +
                                slope[i + 1] * step * s * s * (s - 1);
            go_on(stack[i].center + s * (stack[i + 1].center - stack[i].center), std::clamp(area, least, largest));
        }
    }
    for (const bool top : {false, true}) {
        const Section& end = top ? stack.back() : stack.front();
        const double half = (top ? at[last] - at[last - 1] : at[0] - at[1]) / 2;
        from = end.center;
        from_radius = end.radius();
        for (int k = 1; k <= kPieces; ++k) {
            const double s = static_cast<double>(k) / kPieces;
            go_on(end.center + (s * half) * n, end.area * (1 - s));
        }
    }
}

/// Whether `upper` may go on where `lower` ends.
bool follows(const Section& lower, const Section& upper) {
    const Vec3 step = upper.center - lower.center;
    const double up = dot(step, lower.normal);
    const double aside = length(step - up * lower.normal);
    const double radii = lower.radius() + upper.radius();
    return up > 1e-3 * radii && up < 2 * radii && aside < radii;
}

}  // namespace

std::vector<Capsule> soma_body(const std::vector<std::vector<Vec3>>& contours) {
    std::vector<Section> sections;
    std::vector<Capsule> body;
    for (const auto& contour : contours)
        if (const auto section = measure(contour)) sections.push_back(*section);
    if (sections.empty()) return body;
    const Vec3 up = sections.front().normal;
    for (Section& section : sections)
        if (dot(section.normal, up) < 0) section.normal = -1.0 * section.normal;
    std::stable_sort(sections.begin(), sections.end(),
                     [&](const Section& a, const Section& b) { return dot(a.center, up) < dot(b.center, up); });
    std::vector<std::vector<Section>> stacks;
    constexpr double kParallel = 0.94;
    for (Section& section : sections) {
        const bool parallel = dot(section.normal, up) > kParallel;
        const auto stack = std::find_if(stacks.begin(), stacks.end(), [&](const std::vector<Section>& some) {
            return parallel && dot(some.back().normal, up) > kParallel && follows(some.back(), section);
        });
        if (parallel) section.normal = up;
        if (stack == stacks.end()) {
            stacks.push_back({section});
        } else {
            stack->push_back(section);
        }
    }
    for (const auto& stack : stacks) {
        if (stack.size() == 1) {
            add_spheroid(body, stack.front());
        } else {
            add_stack(body, stack);
        }
    }
    return body;
}

std::vector<Vec3> soma_outline(const MorphologyTree& tree) {
    std::vector<Vec3> outline;
    std::vector<std::uint32_t> next(tree.points.size(), kNoParent);
    std::uint32_t first = kNoParent;
    std::size_t count = 0;
    double widest = 0;
    for (std::uint32_t i = 0; i < tree.points.size(); ++i) {
        const TracedPoint& point = tree.points[i];
        if (point.type != kSomaType) continue;
        ++count;
        widest = std::max(widest, point.radius);
        if (point.parent == kNoParent || tree.points[point.parent].type != kSomaType) {
            if (first != kNoParent) return {};
            first = i;
        } else {
            if (next[point.parent] != kNoParent) return {};
            next[point.parent] = i;
        }
    }
    if (count < 4) return {};
    double longest = 0;
    for (std::uint32_t at = first; at != kNoParent; at = next[at]) {
        const Vec3& position = tree.points[at].position;
        if (!outline.empty()) longest = std::max(longest, length(position - outline.back()));
        outline.push_back(position);
    }
    const auto section = measure(outline);
    constexpr double kTiny = 0.2;    // of the points' radii against the outline's
    constexpr double kNearly = 2.5;  // of the gap against the longest step
    if (!section || widest > kTiny * section->radius()) return {};
    const double gap = length(outline.front() - outline.back());
    return gap <= kNearly * longest ? outline : std::vector<Vec3>();
}

}  // namespace fluovox
