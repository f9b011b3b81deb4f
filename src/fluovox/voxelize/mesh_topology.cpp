#include "fluovox/voxelize/mesh_topology.h"

#include "fluovox/voxelize/chunks.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

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

/// Finds vertices at the same place, from many threads at once.
class VertexWelder {
public:
    explicit VertexWelder(const std::vector<Vec3>& positions)
        : positions_(positions), mask_(std::bit_ceil(2 * positions.size() + 2) - 1), slots_(mask_ + 1) {}

    /// The slot of all vertices at the place of `vertex`.
    std::size_t add(std::uint32_t vertex) {
        std::size_t slot = hash(positions_[vertex]) & mask_;
        for (;; slot = (slot + 1) & mask_) {
            std::uint32_t holder = 0;
            if (slots_[slot].compare_exchange_strong(holder, vertex + 1)) return slot;
            if (!(positions_[holder - 1] == positions_[vertex])) continue;
            while (vertex + 1 < holder && !slots_[slot].compare_exchange_weak(holder, vertex + 1)) {
            }
            return slot;
        }
    }
    /// The first of the vertices of a slot, once all are added.
    std::uint32_t first(std::size_t slot) const { return slots_[slot].load(std::memory_order_relaxed) - 1; }

private:
    const std::vector<Vec3>& positions_;
    std::size_t mask_;
    std::vector<std::atomic<std::uint32_t>> slots_;  // number of a vertex plus one; 0: free
};

/// Vertices that a triangle uses.
std::vector<std::uint8_t> used_vertices(const Mesh& mesh) {
    std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
    for_items(mesh.triangles.size(), [&](std::size_t t) {
        for (const std::uint32_t vertex : mesh.triangles[t])
            std::atomic_ref(used[vertex]).store(1, std::memory_order_relaxed);
    });
    return used;
}

using VertexNumbers = std::vector<std::uint32_t, UnsetAllocator<std::uint32_t>>;

/// New numbers of vertices, the same for all at one place.
struct Numbering {
    VertexNumbers number;  // meaningless for vertices not in use
    std::size_t count = 0;
    std::size_t others = 0;  // vertices in use beyond the first of their place
};

/// `first`: for each vertex the first at its place, or kNone.
Numbering number_first(const VertexNumbers& first) {
    Numbering numbering;
    const std::size_t vertices = first.size();
    auto others = map_chunks(vertices, [&](std::size_t begin, std::size_t end) {
        std::size_t some = 0;
        for (std::size_t v = begin; v < end; ++v)
            some += first[v] != v && first[v] != kNone ? 1 : 0;
        return some;
    });
    auto places = map_chunks(vertices, [&](std::size_t begin, std::size_t end) {
        std::size_t some = 0;
        for (std::size_t v = begin; v < end; ++v)
            some += first[v] == v ? 1 : 0;
        return some;
    });
    numbering.others = counts_to_places(others);
    numbering.count = counts_to_places(places);
    numbering.number.resize(vertices);
    map_chunks(vertices, [&](std::size_t begin, std::size_t end) {
        auto next = static_cast<std::uint32_t>(places[begin / kItemsPerChunk]);
        for (std::size_t v = begin; v < end; ++v)
            if (first[v] == v) numbering.number[v] = next++;
        return 0;
    });
    if (numbering.others == 0) return numbering;
    for_items(vertices, [&](std::size_t v) {
        if (first[v] != v && first[v] != kNone) numbering.number[v] = numbering.number[first[v]];
    });
    return numbering;
}

/// Calls `visit` with the uses of edges by the triangles from `begin` to `end`.
template <class Visit>
void for_edge_uses(const Mesh& mesh, std::size_t begin, std::size_t end, Visit&& visit) {
    for (std::size_t t = begin; t < end; ++t) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t from = mesh.triangles[t][i];
            const std::uint32_t to = mesh.triangles[t][(i + 1) % 3];
            const std::uint32_t use = static_cast<std::uint32_t>(t) << 1U | (from < to ? 1U : 0U);
            visit(EdgeUse{std::min(from, to), std::max(from, to), use});
        }
    }
}

/// Sorts uses of edges whose lower vertices are `vertices` many from `first_vertex` on.
void sort_uses(EdgeUse* begin, EdgeUse* end, std::uint32_t first_vertex, std::size_t vertices) {
    const EdgeUses unsorted(begin, end);
    std::vector<std::size_t> places(vertices, 0);
    for (const EdgeUse& use : unsorted)
        ++places[use.low - first_vertex];
    counts_to_places(places);
    for (const EdgeUse& use : unsorted)
        begin[places[use.low - first_vertex]++] = use;
    // Each place is now the end of its vertex's edges, which are few.
    const auto key = [](const EdgeUse& use) { return std::uint64_t{use.high} << 32U | use.use; };
    EdgeUse* from = begin;
    for (const std::size_t place : places) {
        std::sort(from, begin + place, [&](const EdgeUse& a, const EdgeUse& b) { return key(a) < key(b); });
        from = begin + place;
    }
}

/// A directed edge of the loops to be found.
struct Step {
    std::uint32_t component = 0;
    std::uint32_t from = 0;
    std::uint32_t to = 0;

    bool operator<(const Step& other) const {
        return std::tie(component, from, to) < std::tie(other.component, other.from, other.to);
    }
};

/// What one component has of an edge: forward minus backward.
struct NetUse {
    std::uint32_t component = 0;
    int count = 0;
};

/// The steps that the uses `first` to `last` of one edge leave to be closed. `net` is storage.
void add_steps(const EdgeUses& uses, std::size_t first, std::size_t last, const std::vector<std::uint32_t>& components,
               std::vector<NetUse>& net, std::vector<Step>& steps) {
    const bool paired = last - first == 2 && uses[first].forward() != uses[first + 1].forward();
    if (paired && components[uses[first].triangle()] == components[uses[first + 1].triangle()]) return;
    net.clear();
    for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t component = components[uses[i].triangle()];
        auto entry = std::find_if(net.begin(), net.end(), [&](auto& n) { return n.component == component; });
        if (entry == net.end()) entry = net.insert(entry, {component, 0});
        entry->count += uses[i].forward() ? 1 : -1;
    }
    for (const auto& [component, count] : net) {
        const Step step = count > 0 ? Step{component, uses[first].high, uses[first].low}
                                    : Step{component, uses[first].low, uses[first].high};
        steps.insert(steps.end(), static_cast<std::size_t>(std::abs(count)), step);
    }
}

std::vector<Step> closing_steps(const EdgeUses& uses, const std::vector<std::uint32_t>& components) {
    std::vector<Step> steps;
    for (const auto& some : map_chunks(uses.size(), [&](std::size_t begin, std::size_t end) {
             std::vector<Step> found;
             std::vector<NetUse> net;
             for_each_edge(uses, begin, end, [&](std::size_t first, std::size_t last) {
                 add_steps(uses, first, last, components, net, found);
             });
             return found;
         }))
        steps.insert(steps.end(), some.begin(), some.end());
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
    const std::size_t vertices = mesh.vertices.size();
    const std::vector<std::uint8_t> used = used_vertices(mesh);
    VertexWelder welder(mesh.vertices);
    std::vector<std::size_t, UnsetAllocator<std::size_t>> slots(vertices);
    for_items(vertices, [&](std::size_t v) {
        if (used[v] != 0) slots[v] = welder.add(static_cast<std::uint32_t>(v));
    });
    VertexNumbers first(vertices);
    for_items(vertices, [&](std::size_t v) { first[v] = used[v] != 0 ? welder.first(slots[v]) : kNone; });
    const Numbering numbering = number_first(first);
    welded.welded_vertices = numbering.others;
    const auto& number = numbering.number;
    welded.mesh.vertices.resize(numbering.count);
    for_items(vertices, [&](std::size_t v) {
        if (first[v] == v) welded.mesh.vertices[number[v]] = mesh.vertices[v];
    });
    welded.mesh.triangles.resize(mesh.triangles.size());
    const auto is_degenerate = [](const Mesh::Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; };
    for (const std::size_t some : map_chunks(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
             std::size_t degenerate = 0;
             for (std::size_t t = begin; t < end; ++t) {
                 for (std::size_t i = 0; i < 3; ++i)
                     welded.mesh.triangles[t][i] = number[mesh.triangles[t][i]];
                 degenerate += is_degenerate(welded.mesh.triangles[t]) ? 1 : 0;
             }
             return degenerate;
         }))
        welded.degenerate_triangles += some;
    if (welded.degenerate_triangles > 0) std::erase_if(welded.mesh.triangles, is_degenerate);
    return welded;
}

EdgeUses sorted_edge_uses(const Mesh& mesh) {
    // Dealt out by ranges of the lower vertex first, each range then sorted by itself: every thread writes to places of
    // its own, and a range fits into the cache.
    constexpr std::size_t kFewVertices = 8192;
    constexpr std::size_t kMostRanges = 256;
    const std::size_t vertices = mesh.vertices.size();
    const std::size_t range = std::max(kFewVertices, vertices / kMostRanges + 1);
    const std::size_t ranges = vertices / range + 1;
    std::vector<std::vector<std::size_t>> places =
        map_chunks(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
            std::vector<std::size_t> counts(ranges, 0);
            for_edge_uses(mesh, begin, end, [&](const EdgeUse& use) { ++counts[use.low / range]; });
            return counts;
        });
    std::vector<std::size_t> bounds(ranges + 1, 0);
    std::size_t sum = 0;
    for (std::size_t i = 0; i < ranges; ++i) {
        for (auto& chunk : places)
            chunk[i] = std::exchange(sum, sum + chunk[i]);
        bounds[i + 1] = sum;
    }
    EdgeUses uses(sum);
    map_chunks(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<std::size_t>& place = places[begin / kItemsPerChunk];
        for_edge_uses(mesh, begin, end, [&](const EdgeUse& use) { uses[place[use.low / range]++] = use; });
        return 0;
    });
    tbb::parallel_for(std::size_t{0}, ranges, [&](std::size_t i) {
        sort_uses(uses.data() + bounds[i], uses.data() + bounds[i + 1], static_cast<std::uint32_t>(i * range), range);
    });
    return uses;
}

JoinedSets::JoinedSets(std::size_t size) : parent_(size) {
    for_items(size, [&](std::size_t i) { parent_[i].store(static_cast<std::uint32_t>(i), std::memory_order_relaxed); });
}

std::uint32_t JoinedSets::find(std::uint32_t member) {
    for (;;) {
        std::uint32_t parent = parent_[member].load();
        if (parent == member) return member;
        const std::uint32_t next = parent_[parent].load();
        if (next != parent) parent_[member].compare_exchange_weak(parent, next);
        member = next;
    }
}

void JoinedSets::join(std::uint32_t a, std::uint32_t b) {
    for (;;) {
        a = find(a);
        b = find(b);
        if (a == b) return;
        if (a < b) std::swap(a, b);
        std::uint32_t root = a;
        if (parent_[a].compare_exchange_strong(root, b)) return;
    }
}

ParitySets::ParitySets(std::size_t size) : parent_(size), differs_(size, 0) {
    for (std::size_t i = 0; i < size; ++i)
        parent_[i] = static_cast<std::uint32_t>(i);
}

std::pair<std::uint32_t, bool> ParitySets::find(std::uint32_t member) {
    std::uint32_t root = member;
    bool differs = false;
    while (parent_[root] != root) {
        differs = differs != (differs_[root] != 0);
        root = parent_[root];
    }
    // Everybody on the way now hangs on the root, so that the next search is short.
    bool rest = differs;
    while (parent_[member] != root && member != root) {
        const bool own = differs_[member] != 0;
        const std::uint32_t next = parent_[member];
        parent_[member] = root;
        differs_[member] = static_cast<std::uint8_t>(rest);
        rest = rest != own;
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
    differs_[high] = static_cast<std::uint8_t>((differs_a != differs_b) != differ);
}

std::vector<BoundaryLoop> boundary_loops(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_triangle,
                                         const EdgeUses& uses, std::vector<std::uint32_t>& loop_components) {
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
    for_items(mesh.triangles.size(), [&](std::size_t number) {
        const auto& t = mesh.triangles[number];
        const Vec3& a = mesh.vertices[t[0]];
        const Vec3& b = mesh.vertices[t[1]];
        const Vec3& c = mesh.vertices[t[2]];
        const double low = std::min({a.y, b.y, c.y});
        const double high = std::max({a.y, b.y, c.y});
        auto at = std::lower_bound(order.begin(), order.end(), low, [&](auto i, double y) { return points[i].y < y; });
        for (; at != order.end() && points[*at].y <= high; ++at)
            std::atomic_ref(winding[*at]) += crossing(a, b, c, points[*at]);
    });
    return winding;
}

}  // namespace fluovox
