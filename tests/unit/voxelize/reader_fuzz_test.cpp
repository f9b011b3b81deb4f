#include "fluovox/core/error.h"
#include "fluovox/core/rng.h"
#include "fluovox/voxelize/mesh_file.h"
#include "fluovox/voxelize/mesh_repair.h"
#include "fluovox/voxelize/morphology.h"
#include "fluovox/voxelize/voxelize.h"

#include "unit/voxelize/damage.h"
#include "unit/voxelize/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

// Damaged files of every format: each is read or refused with InputError, never a crash, a hang or a flood of memory.
// FLUOVOX_FUZZ=100000 in the environment runs that many instead of the few thousand of the suite.

namespace fluovox {
namespace {

struct Seed {
    std::string extension;
    std::string bytes;
};

template <class T>
void put(std::string& bytes, T value) {
    std::array<char, sizeof value> raw{};
    std::memcpy(raw.data(), &value, sizeof value);
    bytes.append(raw.data(), raw.size());
}

/// A box with its numbers inside the text, as base64.
std::string gltf(const Mesh& mesh) {
    std::string bytes;
    for (const Vec3& v : mesh.vertices)
        for (int axis = 0; axis < 3; ++axis)
            put(bytes, static_cast<float>(v[axis]));
    const std::size_t places = bytes.size();
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t corner : t)
            put(bytes, static_cast<std::uint16_t>(corner));
    static const std::string kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    const std::size_t size = bytes.size();
    bytes.append(2, '\0');
    for (std::size_t i = 0; i < size; i += 3) {
        const auto byte = [&](std::size_t n) {
            return static_cast<unsigned>(static_cast<unsigned char>(bytes[i + n]));
        };
        const unsigned word = byte(0) << 16U | byte(1) << 8U | byte(2);
        for (int digit = 3; digit >= 0; --digit)
            text += kDigits[word >> (6U * static_cast<unsigned>(digit)) & 63U];
    }
    const auto number = [](std::size_t n) { return std::to_string(n); };
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":)" +
           number(size) + R"(,"uri":"data:application/octet-stream;base64,)" + text +
           R"("}],"bufferViews":[{"buffer":0,"byteLength":)" + number(places) + R"(},{"buffer":0,"byteOffset":)" +
           number(places) + R"(,"byteLength":)" + number(size - places) +
           R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[2,3,4]},)"
           R"({"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}]})";
}

std::vector<Seed> seeds() {
    const Mesh box = testing::box({0, 0, 0}, {2, 3, 4});
    std::string obj;
    std::string off = "OFF\n8 12 0\n";
    std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
    std::string binary =
        "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
        "property float z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n";
    std::string stl = "solid x\n";
    std::string binary_stl(80, ' ');
    for (const Vec3& v : box.vertices) {
        const std::string line = std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z) + '\n';
        obj += "v " + line;
        off += line;
        ply += line;
        for (int axis = 0; axis < 3; ++axis)
            put(binary, static_cast<float>(v[axis]));
    }
    put(binary_stl, static_cast<std::uint32_t>(box.triangles.size()));
    for (const auto& t : box.triangles) {
        obj +=
            "f " + std::to_string(t[0] + 1) + ' ' + std::to_string(t[1] + 1) + "/1 " + std::to_string(t[2] + 1) + '\n';
        const std::string face =
            "3 " + std::to_string(t[0]) + ' ' + std::to_string(t[1]) + ' ' + std::to_string(t[2]) + '\n';
        off += face;
        ply += face;
        binary += '\3';
        stl += "facet normal 0 0 0\nouter loop\n";
        binary_stl.append(12, '\0');
        for (const std::uint32_t corner : t) {
            put(binary, corner);
            const Vec3& v = box.vertices[corner];
            stl += "vertex " + std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z) + '\n';
            for (int axis = 0; axis < 3; ++axis)
                put(binary_stl, static_cast<float>(v[axis]));
        }
        stl += "endloop\nendfacet\n";
        binary_stl.append(2, '\0');
    }
    return {{".obj", obj},
            {".off", off},
            {".ply", ply},
            {".ply", binary},
            {".stl", stl + "endsolid\n"},
            {".stl", binary_stl},
            {".gltf", gltf(box)},
            {".swc", "# a cell\n1 1 0 0 0 5 -1\n2 3 10 0 0 1 1\n3 3 20 1 0 1 2\n4 3 20 -9 0 0.5 2\n5 2 -9 0 0 1 1\n"},
            {".asc",
             "(\"Soma\" (CellBody) (5 0 0 1) (0 4 0 1) (-5 0 0 1))\n((Dendrite) (0 0 0 2) (10 0 0 2) <(10 2 0 1)>\n"
             "( (20 5 0 1) Normal | (20 -5 0 1) ( (25 -9 0 1) | (25 -1 0 1) High ) ) )\n"}};
}

/// True when it was read (and, being small, voxelized), false when it was refused.
bool survives(const std::string& extension, const std::string& bytes) {
    try {
        VoxelizeSettings settings;
        settings.max_bytes = 3e6;
        settings.voxel_size_um = 0.5;
        NoProgress progress;
        if (extension == ".swc" || extension == ".asc") {
            voxelize_capsules(parse_morphology(bytes, extension, "m").capsules, settings, progress);
        } else {
            voxelize({make_solid(parse_mesh(bytes, extension, "m").mesh)}, settings, progress);
        }
        return true;
    } catch (const InputError&) {
        return false;
    }
}

TEST(ReaderFuzz, DamagedFilesAreReadOrRefused) {
    const char* const asked = std::getenv("FLUOVOX_FUZZ");
    const long long runs = asked != nullptr ? std::atoll(asked) : 4000;
    const std::vector<Seed> all = seeds();
    for (const Seed& seed : all)
        EXPECT_TRUE(survives(seed.extension, seed.bytes)) << seed.extension;
    long long refused = 0;
    for (long long run = 0; run < runs; ++run) {
        Rng random(2026, static_cast<std::uint64_t>(run), 0);
        const Seed& seed = all[static_cast<std::size_t>(run) % all.size()];
        refused += survives(seed.extension, testing::damaged(seed.bytes, random)) ? 0 : 1;
    }
    EXPECT_GT(refused, runs / 10);
    EXPECT_LT(refused, runs);
}

}  // namespace
}  // namespace fluovox
