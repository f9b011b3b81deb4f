#include "fluovox/voxelize/mesh_repair.h"

#include "fluovox/voxelize/chunks.h"
#include "fluovox/voxelize/mesh_topology.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>
#include <utility>

namespace fluovox {
namespace {

void flip(Mesh::Triangle& triangle) {
    std::swap(triangle[1], triangle[2]);
}

double triangle_area(const Mesh& mesh, const Mesh::Triangle& t) {
    const Vec3 a = mesh.vertices[t[0]];
    return length(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a)) / 2;
}

void count_edges(const EdgeUses& uses, MeshReport& report) {
    struct Counts {
        std::size_t boundary = 0, nonmanifold = 0, misoriented = 0;
    };
    for (const Counts& some : map_chunks(uses.size(), [&](std::size_t begin, std::size_t end) {
             Counts counts;
             for_each_edge(uses, begin, end, [&](std::size_t first, std::size_t last) {
                 if (last - first == 1) ++counts.boundary;
                 if (last - first > 2) ++counts.nonmanifold;
                 if (last - first == 2 && uses[first].forward() == uses[first + 1].forward()) ++counts.misoriented;
             });
             return counts;
         })) {
        report.boundary_edges += some.boundary;
        report.nonmanifold_edges += some.nonmanifold;
        report.misoriented_edges += some.misoriented;
    }
}

/// Turns triangles whose neighbours across ordinary edges disagree with them, by the majority of area.
void agree_with_neighbours(Mesh& mesh, EdgeUses& uses, MeshReport& report) {
    if (report.misoriented_edges == 0) return;
    ParitySets sets(mesh.triangles.size());
    for_each_edge(uses, [&](std::size_t first, std::size_t last) {
        if (last - first != 2) return;
        sets.merge(uses[first].triangle(), uses[first + 1].triangle(),
                   uses[first].forward() == uses[first + 1].forward());
    });
    std::vector<double> balance(mesh.triangles.size(), 0.0);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [root, differs] = sets.find(t);
        balance[root] += (differs ? -1 : 1) * triangle_area(mesh, mesh.triangles[t]);
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto [root, differs] = sets.find(t);
        if (differs == (balance[root] >= 0)) {
            flip(mesh.triangles[t]);
            ++report.flipped_triangles;
        }
    }
    uses = sorted_edge_uses(mesh);
}

/// Numbers the parts that hang together by edges; returns the first triangle of each.
std::vector<std::uint32_t> number_components(const Mesh& mesh, const EdgeUses& uses,
                                             std::vector<std::uint32_t>& component) {
    JoinedSets sets(mesh.triangles.size());
    map_chunks(uses.size(), [&](std::size_t begin, std::size_t end) {
        for_each_edge(uses, begin, end, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first + 1; i < last; ++i)
                sets.join(uses[first].triangle(), uses[i].triangle());
        });
        return 0;
    });
    component.resize(mesh.triangles.size());
    std::vector<std::uint32_t> firsts;
    for (const auto& some : map_chunks(component.size(), [&](std::size_t begin, std::size_t end) {
             std::vector<std::uint32_t> found;
             for (std::size_t t = begin; t < end; ++t) {
                 component[t] = sets.find(static_cast<std::uint32_t>(t));
                 if (component[t] == t) found.push_back(component[t]);
             }
             return found;
         }))
        firsts.insert(firsts.end(), some.begin(), some.end());
    map_chunks(component.size(), [&](std::size_t begin, std::size_t end) {
        std::size_t last = 0;  // triangles of one part mostly follow each other
        for (std::size_t t = begin; t < end; ++t) {
            if (firsts[last] != component[t]) {
                const auto at = std::lower_bound(firsts.begin(), firsts.end(), component[t]);
                last = static_cast<std::size_t>(at - firsts.begin());
            }
            component[t] = static_cast<std::uint32_t>(last);
        }
        return 0;
    });
    return firsts;
}

/// Whether a fan over the loop is as good as the surface that is missing: the loop is nearly plane.
bool is_flat(const std::vector<Vec3>& loop, const Vec3& center) {
    if (loop.size() <= 4) return true;
    Vec3 normal;
    for (std::size_t i = 0; i < loop.size(); ++i)
        normal = normal + cross(loop[i] - center, loop[(i + 1) % loop.size()] - center);
    const double twice_area = length(normal);
    if (twice_area == 0) return true;  // a slit
    double deviation = 0;
    for (const Vec3& p : loop)
        deviation = std::max(deviation, std::abs(dot(p - center, normal)) / twice_area);
    constexpr double kFlat = 0.1;  // of the size of the hole
    return deviation <= kFlat * std::sqrt(twice_area / 2);
}

/// Meshes cut out of a larger volume end at the faces of a box. Where all of a loop lies on faces of the box around the
/// mesh, a fan around a point on all those faces at once lies in them too; this moves `center` there.
bool snap_to_box(const std::vector<Vec3>& loop, const Bounds& box, Vec3& center) {
    double perimeter = 0;
    for (std::size_t i = 0; i < loop.size(); ++i)
        perimeter += length(loop[(i + 1) % loop.size()] - loop[i]);
    // Meshes are smoothed a little at the cut, so "on the face" means within half an edge, and near on any scale.
    constexpr double kNear = 0.002;
    const double near = std::min(0.5 * perimeter / static_cast<double>(loop.size()), kNear * length(box.size()));
    std::array<int, 6> on_face{};
    for (const Vec3& p : loop) {
        bool on_any = false;
        for (std::size_t face = 0; face < 6; ++face) {
            const int axis = static_cast<int>(face / 2);
            if (std::abs(p[axis] - (face % 2 == 0 ? box.min : box.max)[axis]) > near) continue;
            ++on_face[face];
            on_any = true;
        }
        if (!on_any) return false;
    }
    for (std::size_t face = 0; face < 6; ++face) {
        if (on_face[face] < 3) continue;
        if (face % 2 == 1 && on_face[face - 1] >= 3) return false;  // from one face to the opposite one
        const int axis = static_cast<int>(face / 2);
        center[axis] = (face % 2 == 0 ? box.min : box.max)[axis];
    }
    return true;
}

/// Closes a loop by a fan around `center`.
void add_cap(Mesh& mesh, const BoundaryLoop& loop, const Vec3& center) {
    if (loop.size() == 3) {
        mesh.triangles.push_back({loop[0], loop[1], loop[2]});
        return;
    }
    const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(center);
    for (std::size_t i = 0; i < loop.size(); ++i)
        mesh.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], middle});
}

/// Closes a loop by rings that shrink towards `center`, each with half the vertices of the one before, so that the
/// triangles are about as long as wide and the winding number of the cap is quick to find.
void add_ringed_cap(Mesh& mesh, BoundaryLoop ring, const Vec3& center) {
    constexpr std::size_t kFew = 16;
    while (ring.size() > kFew) {
        // As far inwards as its edges are long.
        const double shrink = 1 - 2 * std::numbers::pi / static_cast<double>(ring.size());
        BoundaryLoop inner;
        for (std::size_t i = 0; i < ring.size(); i += 2) {
            inner.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
            mesh.vertices.push_back(center + shrink * (mesh.vertices[ring[i]] - center));
        }
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::uint32_t here = inner[i / 2];
            const std::uint32_t next = inner[(i / 2 + 1) % inner.size()];
            mesh.triangles.push_back({ring[i], ring[(i + 1) % ring.size()], here});
            const bool step = i % 2 == 1 || i + 1 == ring.size();
            if (step) mesh.triangles.push_back({ring[(i + 1) % ring.size()], next, here});
        }
        ring = std::move(inner);
    }
    add_cap(mesh, ring, center);
}

/// `uneven`: of each component, whether one of its caps is a guess.
void add_caps(SolidMesh& solid, const EdgeUses& uses, std::vector<std::uint32_t>& component,
              std::vector<std::uint8_t>& uneven) {
    Mesh& mesh = solid.mesh;
    std::vector<std::uint32_t> loop_components;
    const auto loops = boundary_loops(mesh, component, uses, loop_components);
    if (loops.empty()) return;
    const Bounds box = mesh_bounds(mesh);
    std::vector<Vec3> corners;
    for (std::size_t n = 0; n < loops.size(); ++n) {
        const BoundaryLoop& loop = loops[n];
        if (loop.size() < 3) continue;  // there and back: nothing to close
        corners.clear();
        Vec3 center;
        for (const std::uint32_t vertex : loop) {
            corners.push_back(mesh.vertices[vertex]);
            center = center + mesh.vertices[vertex];
        }
        center = (1.0 / static_cast<double>(loop.size())) * center;
        const bool sure = snap_to_box(corners, box, center) || is_flat(corners, center);
        ++solid.report.holes;
        if (sure) {
            add_cap(mesh, loop, center);
        } else {
            ++solid.report.uneven_holes;
            uneven[loop_components[n]] = 1;
            add_ringed_cap(mesh, loop, center);
        }
        solid.cap_is_sure.resize(mesh.triangles.size() - solid.first_cap, static_cast<std::uint8_t>(sure));
        component.resize(mesh.triangles.size(), loop_components[n]);
    }
}

/// One connected part, closed by its caps.
struct Part {
    double volume = 0;
    Bounds bounds;
    Vec3 rightmost = {-Bounds::kFar, 0, 0};

    void add(const Part& other) {
        volume += other.volume;
        bounds.add(other.bounds);
        if (other.rightmost.x > rightmost.x) rightmost = other.rightmost;
    }
};

/// A triangle's share of its part, whose volume is seen from `origin`.
Part measure(const Mesh& mesh, const Mesh::Triangle& t, const Vec3& origin) {
    Part part;
    for (const std::uint32_t vertex : t) {
        const Vec3& v = mesh.vertices[vertex];
        part.bounds.add(v);
        if (v.x > part.rightmost.x) part.rightmost = v;
    }
    const Vec3 a = mesh.vertices[t[0]] - origin;
    part.volume = dot(a, cross(mesh.vertices[t[1]] - origin, mesh.vertices[t[2]] - origin)) / 6;
    return part;
}

/// `firsts`: one triangle of each part.
std::vector<Part> measure_parts(const Mesh& mesh, const std::vector<std::uint32_t>& component,
                                const std::vector<std::uint32_t>& firsts) {
    std::vector<Vec3> origins;
    origins.reserve(firsts.size());
    for (const std::uint32_t t : firsts)
        origins.push_back(mesh.vertices[mesh.triangles[t][0]]);
    std::vector<Part> parts(firsts.size());
    for (const auto& some : map_chunks(mesh.triangles.size(), [&](std::size_t begin, std::size_t end) {
             // Triangles of one part mostly follow each other.
             std::unordered_map<std::uint32_t, Part> found;
             Part* last = nullptr;
             for (std::size_t t = begin; t < end; ++t) {
                 if (t == begin || component[t] != component[t - 1]) last = &found[component[t]];
                 last->add(measure(mesh, mesh.triangles[t], origins[component[t]]));
             }
             return found;
         })) {
        for (const auto& [number, part] : some)
            parts[number].add(part);
    }
    return parts;
}

/// Turns parts that face inwards though nothing encloses them, and what lies inside them.
void face_outwards(SolidMesh& solid, const std::vector<std::uint32_t>& component,
                   const std::vector<std::uint32_t>& firsts, const std::vector<std::uint8_t>& uneven) {
    Mesh& mesh = solid.mesh;
    const auto parts = measure_parts(mesh, component, firsts);
    if (std::none_of(parts.begin(), parts.end(), [](const Part& p) { return p.volume < 0; })) return;
    // A point just right of a part's rightmost vertex is outside that part, so what winds around it are the others.
    std::vector<Vec3> beside;
    for (const Part& part : parts) {
        const double step = 1e-7 * length(part.bounds.size());
        beside.push_back(part.rightmost + Vec3{step, 0.37 * step, 0.23 * step});
    }
    const std::vector<int> around = winding_along_x(mesh, beside);
    std::vector<std::uint8_t> turn(parts.size(), 0);
    for (std::size_t i = 0; i < parts.size(); ++i) {
        // Inside something that is itself inside out: the whole nest is turned.
        turn[i] = static_cast<std::uint8_t>(around[i] < 0 || (around[i] == 0 && parts[i].volume < 0));
        if (turn[i] != 0) ++solid.report.flipped_components;
        if (turn[i] != 0 && uneven[i] != 0) ++solid.report.guessed_components;
        if (turn[i] != (parts[i].volume < 0 ? 1 : 0)) ++solid.report.cavities;
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (turn[component[t]] != 0) flip(mesh.triangles[t]);
}

}  // namespace

SolidMesh make_solid(const Mesh& mesh) {
    SolidMesh solid;
    WeldedMesh welded = weld(mesh);
    solid.mesh = std::move(welded.mesh);
    MeshReport& report = solid.report;
    report.vertices = solid.mesh.vertices.size();
    report.triangles = solid.mesh.triangles.size();
    report.welded_vertices = welded.welded_vertices;
    report.degenerate_triangles = welded.degenerate_triangles;
    report.area_um2 = surface_area(solid.mesh);

    EdgeUses uses = sorted_edge_uses(solid.mesh);
    count_edges(uses, report);
    agree_with_neighbours(solid.mesh, uses, report);
    std::vector<std::uint32_t> component;
    const std::vector<std::uint32_t> firsts = number_components(solid.mesh, uses, component);
    report.components = firsts.size();
    solid.first_cap = solid.mesh.triangles.size();
    std::vector<std::uint8_t> uneven(firsts.size(), 0);
    add_caps(solid, uses, component, uneven);
    face_outwards(solid, component, firsts, uneven);
    report.volume_um3 = signed_volume(solid.mesh);
    return solid;
}

}  // namespace fluovox
