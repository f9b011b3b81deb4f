#pragma once

// Steps of make_solid.

#include "fluovox/voxelize/mesh.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace fluovox {

/// The use of an edge by one triangle; triangles have numbers below 2^31.
struct EdgeUse {
    std::uint32_t low, high;  ///< its vertices
    std::uint32_t use;        ///< triangle and direction

    std::uint32_t triangle() const { return use >> 1U; }
    /// The triangle runs from `low` to `high`.
    bool forward() const { return (use & 1U) != 0; }
    bool same_edge(const EdgeUse& other) const { return low == other.low && high == other.high; }
};

/// Leaves elements as they come instead of zeroing them first: large arrays that many threads then fill.
template <class Value>
struct UnsetAllocator : std::allocator<Value> {
    template <class Other>
    struct rebind {  // NOLINT(readability-identifier-naming): the standard's name
        using other = UnsetAllocator<Other>;
    };
    template <class Other, class... Arguments>
    void construct(Other* place, Arguments&&... arguments) {
        if constexpr (sizeof...(Arguments) == 0) {
            ::new (static_cast<void*>(place)) Other;
        } else {
            ::new (static_cast<void*>(place)) Other(std::forward<Arguments>(arguments)...);
        }
    }
};
using EdgeUses = std::vector<EdgeUse, UnsetAllocator<EdgeUse>>;

/// A mesh with equal vertices made one, unused ones and triangles with equal corners left out.
struct WeldedMesh {
    Mesh mesh;
    std::size_t welded_vertices = 0;
    std::size_t degenerate_triangles = 0;
};
WeldedMesh weld(const Mesh& mesh);

/// Every use of every edge, grouped by edge.
EdgeUses sorted_edge_uses(const Mesh& mesh);

/// Calls `visit(first, last)` with the index range of each edge's uses, for edges that start from `begin` to `end`.
template <class Visit>
void for_each_edge(const EdgeUses& uses, std::size_t begin, std::size_t end, Visit&& visit) {
    while (begin > 0 && begin < end && uses[begin].same_edge(uses[begin - 1]))
        ++begin;
    for (std::size_t first = begin; first < end;) {
        std::size_t last = first + 1;
        while (last < uses.size() && uses[last].same_edge(uses[first]))
            ++last;
        visit(first, last);
        first = last;
    }
}

/// The same for every edge.
template <class Visit>
void for_each_edge(const EdgeUses& uses, Visit&& visit) {
    for_each_edge(uses, 0, uses.size(), visit);
}

/// Sets that merge, from many threads at once.
class JoinedSets {
public:
    explicit JoinedSets(std::size_t size);

    /// The lowest member of a set, once nobody joins any more.
    std::uint32_t find(std::uint32_t member);
    void join(std::uint32_t a, std::uint32_t b);

private:
    std::vector<std::atomic<std::uint32_t>> parent_;
};

/// Sets that merge, each member with a parity relative to its set's representative.
class ParitySets {
public:
    explicit ParitySets(std::size_t size);

    /// The representative of `member`'s set, and whether `member` differs from it.
    std::pair<std::uint32_t, bool> find(std::uint32_t member);
    /// Merges the sets of `a` and `b`, which differ or not; a contradiction to what is known is ignored.
    void merge(std::uint32_t a, std::uint32_t b, bool differ);

private:
    std::vector<std::uint32_t> parent_;
    std::vector<std::uint8_t> differs_;  // from the parent
};

/// A closed loop of directed edges, each vertex once.
using BoundaryLoop = std::vector<std::uint32_t>;

/// The directed edges that would close the mesh (the net boundary, reversed), cut into simple loops. Each loop stays
/// within one component; `loop_components` gets it.
std::vector<BoundaryLoop> boundary_loops(const Mesh& mesh, const std::vector<std::uint32_t>& component_of_triangle,
                                         const EdgeUses& uses, std::vector<std::uint32_t>& loop_components);

/// Signed number of times that the surface winds around each point, counted along a line towards +x. Exact for
/// closed surfaces and points that are not on them.
std::vector<int> winding_along_x(const Mesh& mesh, const std::vector<Vec3>& points);

}  // namespace fluovox
