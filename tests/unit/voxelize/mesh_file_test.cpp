#include "fluovox/voxelize/mesh_file.h"

#include "fluovox/core/error.h"

#include "unit/voxelize/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <functional>
#include <string>

namespace fluovox {
namespace {

template <class T>
void put(std::string& bytes, T value, bool big_endian) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof value);  // NOLINT(*-reinterpret-cast): bytes
    if (big_endian != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    bytes += raw;
}

std::string binary_ply(const Mesh& mesh, bool big_endian) {
    std::string bytes = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                        "_endian 1.0\ncomment x\nelement vertex " + std::to_string(mesh.vertices.size()) +
                        "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nelement face " +
                        std::to_string(mesh.triangles.size()) +
                        "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3& v : mesh.vertices) {
        for (int axis = 0; axis < 3; ++axis)
            put(bytes, v[axis], big_endian);
        put(bytes, std::uint8_t{7}, big_endian);
    }
    for (const auto& t : mesh.triangles) {
        put(bytes, std::uint8_t{3}, big_endian);
        for (const std::uint32_t vertex : t)
            put(bytes, static_cast<std::int32_t>(vertex), big_endian);
    }
    return bytes;
}

std::string binary_stl(const Mesh& mesh) {
    std::string bytes(80, 's');
    bytes.replace(0, 5, "solid");  // as some programs write it
    put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()), false);
    for (const auto& t : mesh.triangles) {
        for (int i = 0; i < 3; ++i)
            put(bytes, 0.0F, false);
        for (const std::uint32_t vertex : t)
            for (int axis = 0; axis < 3; ++axis)
                put(bytes, static_cast<float>(mesh.vertices[vertex][axis]), false);
        bytes += std::string(2, '\0');
    }
    return bytes;
}

std::string text_off(const Mesh& mesh) {
    std::string text = "COFF # with colours\n\n" + std::to_string(mesh.vertices.size()) + ' ' +
                       std::to_string(mesh.triangles.size()) + " 0\n";
    for (const Vec3& v : mesh.vertices)
        text += std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z) + " 255 0 0 1\n";
    for (const auto& t : mesh.triangles)
        text += "3 " + std::to_string(t[0]) + ' ' + std::to_string(t[1]) + ' ' + std::to_string(t[2]) + '\n';
    return text;
}

std::string message(const std::string& bytes, const std::string& extension) {
    try {
        parse_mesh(bytes, extension, "m" + extension);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

const Mesh kBox = testing::box({0, 0, 0}, {2, 3, 4});

TEST(MeshFile, ReadsEveryFormatOfABox) {
    EXPECT_DOUBLE_EQ(signed_volume(parse_mesh(binary_ply(kBox, false), ".ply", "m").mesh), 24);
    EXPECT_DOUBLE_EQ(signed_volume(parse_mesh(binary_ply(kBox, true), ".PLY", "m").mesh), 24);
    EXPECT_DOUBLE_EQ(signed_volume(parse_mesh(binary_stl(kBox), ".stl", "m").mesh), 24);
    EXPECT_DOUBLE_EQ(signed_volume(parse_mesh(text_off(kBox), ".off", "m").mesh), 24);
}

TEST(MeshFile, ObjTakesPolygonsSlashesAndNegativeIndices) {
    const std::string text =
        "# a box\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\r\nv 0 1 1\n"
        "vn 0 0 1\nf 4/1/1 3//2 2 1\nf 5 6 7 8\nf -8 -7 -3 -4\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    EXPECT_DOUBLE_EQ(signed_volume(parse_mesh(text, ".obj", "m").mesh), 1);
}

TEST(MeshFile, CoordinatesKeepDoublePrecision) {
    const Mesh mesh = parse_mesh("v 1000000.0001 0 0\nv 1000000.0002 1 0\nv 0 0 1\nf 1 2 3\n", ".obj", "m").mesh;
    EXPECT_NEAR(mesh.vertices[1].x - mesh.vertices[0].x, 1e-4, 1e-9);
}

TEST(MeshFile, GltfIsInMetresWithYUpwards) {
    std::string buffer;
    for (const float v : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 2.F, 0.F})
        put(buffer, v, false);
    static constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string base64;
    for (std::size_t i = 0; i < buffer.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t n = 0; n < 3; ++n)
            bits = bits << 8U | static_cast<unsigned char>(buffer[i + n]);
        for (const unsigned shift : {18U, 12U, 6U, 0U})
            base64 += kDigits[bits >> shift & 63U];
    }
    const std::string gltf =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,2,0]}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":36}],)"
        R"("buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)" +
        base64 + R"("}]})";
    const MeshFile file = parse_mesh(gltf, ".gltf", "m.gltf");
    EXPECT_EQ(file.um_per_unit, 1e6);
    EXPECT_EQ(mesh_bounds(file.mesh).max, (Vec3{1, 0, 2}));
}

TEST(MeshFile, MistakesNameTheFileAndTheLine) {
    EXPECT_NE(message("v 0 0 0\nv 1 x 0\n", ".obj").find("m.obj:2: \"x\" is not a number"), std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 1 2 3\n", ".obj").find("uses vertex 3"), std::string::npos);
    EXPECT_NE(message("v 0 0 nan\n", ".obj").find("not a finite number"), std::string::npos);
    EXPECT_NE(message("", ".obj").find("is empty"), std::string::npos);
    EXPECT_NE(message("hello", ".obj").find("m.obj:1: has no triangles"), std::string::npos);
    EXPECT_NE(message("hello", ".ply").find("not a PLY"), std::string::npos);
    EXPECT_NE(message("hello", ".stl").find("not an STL"), std::string::npos);
    EXPECT_NE(message("hello", ".off").find("not an OFF"), std::string::npos);
    EXPECT_NE(message("hello", ".gltf").find("m.gltf"), std::string::npos);
    EXPECT_NE(message("hello", ".jpg").find("no mesh that fluovox reads"), std::string::npos);
}

TEST(MeshFile, TruncationIsNoticedAnywhere) {
    for (const auto& [bytes, extension] : {std::pair(binary_ply(kBox, false), ".ply"),
                                           std::pair(binary_stl(kBox), ".stl"), std::pair(text_off(kBox), ".off")}) {
        // In a text format the last line break and digit may go without a trace.
        for (std::size_t length = 0; length + 3 < bytes.size(); length += 5)
            EXPECT_NE(message(bytes.substr(0, length), extension), "") << extension << length;
    }
}

TEST(MeshFile, CountsThatPromiseTooMuchDoNotAskForMemory) {
    EXPECT_NE(message("OFF 4000000000 4000000000 0\n", ".off"), "");
    EXPECT_NE(
        message("ply\nformat ascii 1.0\nelement vertex 9000000000000000000\nproperty float x\nend_header\n", ".ply"),
        "");
    EXPECT_NE(message("ply\nformat binary_little_endian 1.0\nelement vertex 9000000000000000000\nend_header\n", ".ply"),
              "");
}

}  // namespace
}  // namespace fluovox
