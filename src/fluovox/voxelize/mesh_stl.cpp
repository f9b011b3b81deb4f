#include "fluovox/core/error.h"
#include "fluovox/voxelize/mesh_readers.h"

#include <bit>
#include <cmath>
#include <cstring>

namespace fluovox {
namespace {

constexpr std::size_t kHeader = 80;
constexpr std::size_t kFacet = 50;  // normal, three corners, two bytes of attributes

void add_facet(Mesh& mesh) {
    const auto end = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.triangles.push_back({end - 3, end - 2, end - 1});
}

/// Little-endian, whatever the machine.
template <class Integer>
Integer little_endian(const char* bytes) {
    Integer value = 0;
    for (std::size_t i = sizeof value; i-- > 0;)
        value = (value << 8U) | static_cast<unsigned char>(bytes[i]);
    return value;
}

Mesh parse_binary(std::string_view bytes, const std::string& name) {
    const auto count = little_endian<std::uint32_t>(bytes.data() + kHeader);
    const std::size_t body = bytes.size() - kHeader - sizeof count;
    if (body / kFacet < count) {
        throw InputError(name + ": is truncated or no STL file: it says " + std::to_string(count) +
                         " triangles and has room for " + std::to_string(body / kFacet));
    }
    if (count == 0) throw InputError(name + ": has no triangles: its count, at byte 80, is 0");
    Mesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
        const char* facet = bytes.data() + kHeader + sizeof count + i * kFacet + 3 * sizeof(float);
        for (int corner = 0; corner < 3; ++corner) {
            Vec3 vertex;
            for (int axis = 0; axis < 3; ++axis, facet += sizeof(float)) {
                vertex[axis] = static_cast<double>(std::bit_cast<float>(little_endian<std::uint32_t>(facet)));
                if (!std::isfinite(vertex[axis])) {
                    throw InputError(name + ": triangle " + std::to_string(i) + " is not finite");
                }
            }
            mesh.vertices.push_back(vertex);
        }
        add_facet(mesh);
    }
    return mesh;
}

Mesh parse_text(std::string_view bytes, const std::string& name) {
    TextScanner in(bytes, name);
    Mesh mesh;
    int corners = 0;
    bool ended = false;
    while (in.next_line('\0')) {
        const auto keyword = in.token();
        if (keyword == "vertex") {
            const double x = in.number();
            const double y = in.number();
            mesh.vertices.push_back({x, y, in.number()});
            if (++corners > 3) in.fail("a facet has more than three corners");
        } else if (keyword == "endloop") {
            if (corners != 3) in.fail("a facet has fewer than three corners");
            add_facet(mesh);
            corners = 0;
        } else if (keyword == "solid" || keyword == "endsolid") {
            ended = keyword == "endsolid";
        } else if (keyword != "facet" && keyword != "outer" && keyword != "endfacet") {
            in.fail("\"" + std::string(keyword.substr(0, 40)) + "\" has no meaning in an STL file");
        }
    }
    if (!ended) in.fail("is truncated: \"endsolid\" is missing");
    if (mesh.triangles.empty()) in.fail_without_triangles(mesh.vertices.size());
    return mesh;
}

}  // namespace

Mesh parse_stl(std::string_view bytes, const std::string& name) {
    // Some binary files begin with "solid" too, so the size decides where it can.
    if (bytes.size() >= kHeader + sizeof(std::uint32_t)) {
        const auto count = little_endian<std::uint32_t>(bytes.data() + kHeader);
        const bool fits = bytes.size() == kHeader + sizeof count + std::size_t{count} * kFacet;
        if (fits || !bytes.starts_with("solid")) return parse_binary(bytes, name);
    }
    if (!bytes.starts_with("solid")) throw InputError(name + ": is not an STL file");
    return parse_text(bytes, name);
}

}  // namespace fluovox
