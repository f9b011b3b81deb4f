#include "fluovox/voxelize/mesh_topology.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

namespace fluovox {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

std::uint64_t hash(const Vec3& v) {
    std::uint64_t h = 0;
    for (int axis = 0; axis < 3; ++axis) {
        h ^= std::bit_cast<std::uint64_t>(v[axis] + 0.0);  // + 0.0: minus zero equals zero
        h *= 0x9e3779b97f4a7c15ULL;
        h ^= h >> 29U;
    }
    return h;
}

/// Numbers distinct positions as they come.
class VertexWelder {
public:
    explicit VertexWelder(std::size_t most) : mask_(std::bit_ceil(2 * most + 2) - 1), slots_(mask_ + 1, kNone) {}

    std::uint32_t add(const Vec3& position) {
        for (std::size_t slot = hash(position) & mask_;; slot = (slot + 1) & mask_) {
            if (slots_[slot] == kNone) {
                slots_[slot] = static_cast<std::uint32_t>(positions_.size());
                positions_.push_back(position);
                return slots_[slot];
            }
            if (positions_[slots_[slot]] == position) return slots_[slot];
        }
    }
    std::vector<Vec3> take() { return std::move(positions_); }
    std::size_t size() const { return positions_.size(); }

private:
    std::size_t mask_;
    std::vector<std::uint32_t> slots_;
    std::vector<Vec3> positions_;
};

/// A directed edge of the loops to be found.
struct Step {
    std::uint32_t component = 0;
    std::uint32_t from = 0;
    std::uint32_t to = 0;

    bool operator<(const Step& other) const {
        return std::tie(component, from, to) < std::tie(other.component, other.from, other.to);
    }
};

std::vector<Step> closing_steps(const std::vector<EdgeUse>& uses, const std::vector<std::uint32_t>& components) {
    std::vector<Step> steps;
    std::vector<std::pair<std::uint32_t, int>> net;  // component, forward minus backward
    for_each_edge(uses, [&](std::size_t first, std::size_t last) {
        net.clear();
        for (std::size_t i = first; i < last; ++i) {
            const std::uint32_t component = components[uses[i].triangle];
            auto entry = std::find_if(net.begin(), net.end(), [&](auto& n) { return n.first == component; });
            if (entry == net.end()) entry = net.insert(entry, {component, 0});
            entry->second += uses[i].forward ? 1 : -1;
        }
        for (const auto& [component, count] : net) {
            const Step step = count > 0 ? Step{component, uses[first].high, uses[first].low}
                                        : Step{component, uses[first].low, uses[first].high};
            steps.insert(steps.end(), static_cast<std::size_t>(std::abs(count)), step);
        }
    });
    std::sort(steps.begin(), steps.end());
    return steps;
}

/// Twice the signed area of the triangle (a, b, p) in the plane of y and z.
double side(const Vec3& a, const Vec3& b, double y, double z) {
    return (b.y - a.y) * (z - a.z) - (b.z - a.z) * (y - a.y);
}

/// +1 or -1 when a line from `p` towards +x leaves or enters through the triangle; 0 when it misses.
int crossing(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
    const double u = side(b, c, p.y, p.z);
    const double v = side(c, a, p.y, p.z);
    const double w = side(a, b, p.y, p.z);
    const bool inside = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
    const double sum = u + v + w;
    if (!inside || sum == 0) return 0;
    const double x = (u * a.x + v * b.x + w * c.x) / sum;
    if (x <= p.x) return 0;
    return sum > 0 ? 1 : -1;
}

}  // namespace

WeldedMesh weld(const Mesh& mesh) {
    WeldedMesh welded;
    VertexWelder welder(mesh.vertices.size());
    std::vector<std::uint32_t> renumbered(mesh.vertices.size(), kNone);
    std::size_t used = 0;
    welded.mesh.triangles.reserve(mesh.triangles.size());
    for (const auto& triangle : mesh.triangles) {
        Mesh::Triangle corners{};
        for (std::size_t i = 0; i < 3; ++i) {
            std::uint32_t& number = renumbered[triangle[i]];
            if (number == kNone) {
                number = welder.add(mesh.vertices[triangle[i]]);
                ++used;
            }
            corners[i] = number;
        }
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) {
            ++welded.degenerate_triangles;
        } else {
            welded.mesh.triangles.push_back(corners);
        }
    }
    welded.welded_vertices = used - welder.size();
    welded.mesh.vertices = welder.take();
    return welded;
}

std::vector<EdgeUse> sorted_edge_uses(const Mesh& mesh) {
    std::vector<EdgeUse> uses;
    uses.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = mesh.triangles[t][i];
            const std::uint32_t to = mesh.triangles[t][(i + 1) % 3];
            uses.push_back({std::min(from, to), std::max(from, to), static_cast<std::uint32_t>(t), from < to});
        }
    }
    tbb::parallel_sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
    });
    return uses;
}

ParitySets::ParitySets(std::size_t size) : parent_(size), differs_(size, 0) {
    for (std::size_t i = 0; i < size; ++i)
        parent_[i] = static_cast<std::uint32_t>(i);
}

std::pair<std::uint32_t, bool> ParitySets::find(std::uint32_t member) {
    std::uint32_t root = member;
    bool differs = false;
    while (parent_[root] != root) {
        differs ^= differs_[root] != 0;
        root = parent_[root];
    }
    // Everybody on the way now hangs on the root, so that the next search is short.
    bool rest = differs;
    while (parent_[member] != root && member != root) {
        const bool own = differs_[member] != 0;
        const std::uint32_t next = parent_[member];
        parent_[member] = root;
        differs_[member] = static_cast<std::uint8_t>(rest);
        rest ^= own;
        member = next;
    }
    return {root, differs};
}

void ParitySets::merge(std::uint32_t a, std::uint32_t b, bool differ) {
    const auto [root_a, differs_a] = find(a);
    const auto [root_b, differs_b] = find(b);
    if (root_a == root_b) return;
    const auto [low, high] = std::minmax(root_a, root_b);
    parent_[high] = low;
    differs_[high] = static_cast<std::uint8_t>(differs_a ^ differs_b ^ differ);
}

std::vector<BoundaryLoop> boundary_loops(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_triangle,
                                         const std::vector<EdgeUse>& uses,
                                         std::vector<std::uint32_t>& loop_components) {
    const std::vector<Step> steps = closing_steps(uses, component_of_triangle);
    std::vector<BoundaryLoop> loops;
    std::vector<std::uint8_t> taken(steps.size(), 0);
    std::vector<std::uint32_t> place(mesh.vertices.size(), kNone);  // of a vertex on the path
    std::vector<std::uint32_t> path;
    const auto find_step = [&](std::uint32_t component, std::uint32_t from) {
        auto at = std::lower_bound(steps.begin(), steps.end(), Step{component, from, 0});
        for (; at != steps.end() && at->component == component && at->from == from; ++at) {
            if (taken[static_cast<std::size_t>(at - steps.begin())] == 0) return at;
        }
        return steps.end();
    };
    for (std::size_t first = 0; first < steps.size(); ++first) {
        if (taken[first] != 0) continue;
        const std::uint32_t component = steps[first].component;
        path.assign(1, steps[first].from);
        place[path.front()] = 0;
        // As many steps leave a vertex as reach it, so a walk ends only where it began; each time it comes back to a
        // vertex of its path, the part since then is a loop of its own.
        for (auto step = find_step(component, path.back()); step != steps.end();
             step = find_step(component, path.back())) {
            taken[static_cast<std::size_t>(step - steps.begin())] = 1;
            const std::uint32_t next = step->to;
            if (place[next] == kNone) {
                place[next] = static_cast<std::uint32_t>(path.size());
                path.push_back(next);
                continue;
            }
            loops.emplace_back(path.begin() + place[next], path.end());
            loop_components.push_back(component);
            while (path.back() != next) {
                place[path.back()] = kNone;
                path.pop_back();
            }
        }
        for (const std::uint32_t vertex : path)
            place[vertex] = kNone;
    }
    return loops;
}

std::vector<int> winding_along_x(const Mesh& mesh, const std::vector<Vec3>& points) {
    // Points sorted by y: each triangle looks only at those in its span.
    std::vector<std::uint32_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = static_cast<std::uint32_t>(i);
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return points[a].y < points[b].y; });
    std::vector<int> winding(points.size(), 0);
    for (const auto& t : mesh.triangles) {
        const Vec3& a = mesh.vertices[t[0]];
        const Vec3& b = mesh.vertices[t[1]];
        const Vec3& c = mesh.vertices[t[2]];
        const double low = std::min({a.y, b.y, c.y});
        const double high = std::max({a.y, b.y, c.y});
        auto at = std::lower_bound(order.begin(), order.end(), low, [&](auto i, double y) { return points[i].y < y; });
        for (; at != order.end() && points[*at].y <= high; ++at)
            winding[*at] += crossing(a, b, c, points[*at]);
    }
    return winding;
}

}  // namespace fluovox
