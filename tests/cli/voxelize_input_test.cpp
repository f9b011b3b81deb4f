#include "cli/run_program.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

// What `fluovox voxelize` says about files that are not what they should be.

/// The corner of a box, cut off, `x`, `y` and `z` long.
std::string corner_obj(double x, double y, double z) {
    const auto number = [](double value) { return std::to_string(value) + ' '; };
    return "v 0 0 0\nv " + number(x) + "0 0\nv 0 " + number(y) + "0\nv 0 0 " + number(z) +
           "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
}

template <class Number>
void put(std::string& bytes, Number number) {
    const auto raw = std::bit_cast<std::array<char, sizeof number>>(number);
    bytes.append(raw.data(), raw.size());
}

/// The numbers of `corner_obj` as a glTF file has them beside it.
std::string corner_bin(float x, float y, float z) {
    std::string bytes;
    for (const float v : {0.F, 0.F, 0.F, x, 0.F, 0.F, 0.F, y, 0.F, 0.F, 0.F, z})
        put(bytes, v);
    for (const std::uint16_t corner : std::vector<std::uint16_t>{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})
        put(bytes, corner);
    return bytes;
}

constexpr const char* kGltf =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
    R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
    R"("buffers":[{"byteLength":72,"uri":"corner.bin"}],"bufferViews":[{"buffer":0,"byteLength":48},)"
    R"({"buffer":0,"byteOffset":48,"byteLength":24}],)"
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},)"
    R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})";

class VoxelizeInput : public ProgramTest {
protected:
    static std::vector<std::string> with(std::vector<std::string> head) {
        const std::vector<std::string> tail = {"-o", "a.vdb", "--dye", "EGFP=5uM"};
        head.insert(head.begin(), "voxelize");
        head.insert(head.end(), tail.begin(), tail.end());
        return head;
    }
};

TEST_F(VoxelizeInput, ASizeThatLooksLikeNanometresIsDoubted) {
    write("cell.obj", corner_obj(8192, 8192, 19320));
    write("volume.obj", corner_obj(2e6, 1e6, 1e6));
    write("axon.swc", "1 1 0 0 0 5 -1\n2 2 9000 0 0 1 1\n");
    write("fly.swc", "1 1 0 0 0 5 -1\n2 2 25000 0 0 100 1\n");
    const std::string hint = "often in nanometres: add --mesh-unit nm";
    expect_rows({
        {"nm as um is filled with a warning", with({"cell.obj", "--resolution", "64"}), 0,
         "warning: cell.obj: its bounding box is 8192 x 8192 x 19320 um.*" + hint},
        {"whatever the voxels", with({"cell.obj", "--voxel-size", "300um"}), 0, hint},
        {"a skeleton too", with({"fly.swc", "--resolution", "64"}), 0, "warning: fly.swc: .*" + hint},
        {"a metre is refused", with({"volume.obj", "--resolution", "64"}), 4,
         "error: volume.obj: its bounding box is 2e\\+06 x 1e\\+06 x 1e\\+06 um.*" + hint},
    });
    for (const std::vector<std::string>& sure :
         {with({"cell.obj", "--resolution", "64", "--mesh-unit", "nm"}), with({"axon.swc", "--resolution", "64"}),
          with({"cell.obj", "--resolution", "64", "--mesh-unit", "um"}),
          with({"volume.obj", "--resolution", "64", "--mesh-unit", "um"})}) {
        const ProgramResult result = run(sure);
        EXPECT_EQ(result.exit_code, 0) << result.command;
        EXPECT_FALSE(found("nanometres", result.err)) << result.command;
    }
    for (const char* name : {"b.obj", "c.obj"})
        write(name, corner_obj(8192, 8192, 19320));
    const ProgramResult many = run(with({"cell.obj", "b.obj", "c.obj", "--resolution", "64"}));
    EXPECT_EQ(many.err.find(hint), many.err.rfind(hint)) << many.err;
}

TEST_F(VoxelizeInput, ATruncatedMeshSaysWhere) {
    const std::string obj = corner_obj(1, 2, 3);
    write("cut.obj", obj.substr(0, obj.find("f 1 3 2")));
    write("cut.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n");
    const std::string text = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    write("cut.ply", "ply\nformat ascii 1.0\n" + text + faces + "0 0 0\n1 0 0\n");
    write("points.ply", "ply\nformat ascii 1.0\n" + text + "end_header\n0 0 0\n1 0 0\n0 1 0\n");
    std::string binary = "ply\nformat binary_little_endian 1.0\n" + text + faces;
    const std::size_t header = binary.size();
    for (const float v : {0.F, 0.F, 0.F, 1.F, 0.F})
        put(binary, v);
    write("binary.ply", binary);
    write("cut.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n");
    write("none.stl", std::string(84, '\0'));
    const auto row = [](const std::string& file, const std::string& message) {
        return CommandRow{file, with({file, "--voxel-size", "1um"}), 4, message};
    };
    expect_rows({
        row("cut.obj", "cut.obj:4: has no triangles: it ends here, after 4 vertices and no faces .*truncated"),
        row("cut.off", "cut.off:7: is truncated: 3 faces are missing"),
        row("cut.ply", "cut.ply:11: is truncated: it ends at \"vertex\" 3 of 3"),
        row("points.ply", "points.ply:10: has no triangles: its header names no faces"),
        row("binary.ply",
            "binary.ply: byte " + std::to_string(header + 20) + ": is truncated: it ends at \"vertex\" 2 of 3"),
        row("cut.stl", "cut.stl:4: is truncated: \"endsolid\" is missing"),
        row("none.stl", "none.stl: has no triangles: its count, at byte 80, is 0"),
    });
}

TEST_F(VoxelizeInput, NumbersTooLargeForDoublePrecisionAreNoCoordinates) {
    const std::string obj = corner_obj(1, 2, 3);
    write("far.obj", "v 0 0 1e400\n" + obj);
    write("near.obj", "v 0 0 1e-400\n" + obj);
    write("far.off", "OFF\n3 1 0\n0 0 0\n1 0 -1e400\n0 1 0\n3 0 1 2\n");
    write("far.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 1e999 0\n");
    write("far.ply",
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "end_header\n0 1e400 0\n");
    const auto row = [](const std::string& file, const std::string& message) {
        return CommandRow{file, with({file, "--voxel-size", "1um"}), 4, message};
    };
    expect_rows({
        row("far.obj", "far.obj:1: \"1e400\" is not a finite number"),
        row("far.off", "far.off:4: \"-1e400\" is not a finite number"),
        row("far.stl", "far.stl:4: \"1e999\" is not a finite number"),
        row("far.ply", "far.ply:8: \"1e400\" is not a finite number"),
    });
    const ProgramResult near = run(with({"near.obj", "--voxel-size", "1um"}));
    EXPECT_FALSE(found("finite", near.err)) << near.err;
}

TEST_F(VoxelizeInput, FilesThatAreNotWhatTheyAreCalledAreNamed) {
    write("obj.ply", corner_obj(1, 2, 3));
    write("huge.nrrd",
          "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1000000 1000000 1000000\nencoding: raw\n"
          "spacings: 1 1 1\nunits: \"um\" \"um\" \"um\"\n\nabc");
    expect_rows({
        {"an OBJ", with({"obj.ply", "--voxel-size", "1um"}), 4, "obj.ply:1: .*\\(it does not begin with \"ply\"\\)"},
        {"a volume larger than its file", with({"huge.nrrd"}), 4, "error: huge.nrrd: is truncated"},
    });
}

TEST_F(VoxelizeInput, GarbageIsNotSentToTheTerminal) {
    write("garbage.swc", "\x1b[2J\xff\x07\x01 9\n");
    write("garbage.obj", "v \x1b]0;x\x07 1 2\n");
    expect_rows({
        {"a morphology", with({"garbage.swc", "--voxel-size", "1um"}), 4,
         R"(garbage.swc:1: "\\x1b\[2J\\xff\\x07\\x01" is not a number)"},
        {"a mesh", with({"garbage.obj", "--voxel-size", "1um"}), 4, R"("\\x1b\]0;x\\x07" is not a number)"},
    });
    for (const char* file : {"garbage.swc", "garbage.obj"})
        EXPECT_EQ(run(with({file, "--voxel-size", "1um"})).err.find('\x1b'), std::string::npos) << file;
}

TEST_F(VoxelizeInput, AMeshUnitThatIsNoneIsNamedAsTyped) {
    write("corner.obj", corner_obj(10, 20, 30));
    expect_rows({
        {"no unit", with({"corner.obj", "--voxel-size", "1um", "--mesh-unit", "furlong"}), 2,
         "error: --mesh-unit: unknown unit \"furlong\"; one of um, nm, mm, cm, m, .*\nUsage: fluovox voxelize"},
        {"a number of none", with({"corner.obj", "--voxel-size", "1um", "--mesh-unit", "8px"}), 2,
         "unknown unit \"8px\""},
        {"nothing", with({"corner.obj", "--voxel-size", "1um", "--mesh-unit", "0nm"}), 2, "greater than zero"},
        {"eight nanometres", with({"corner.obj", "--voxel-size", "10nm", "--mesh-unit", "8nm"}), 0, "", "EGFP"},
    });
}

TEST_F(VoxelizeInput, AGltfFindsTheFileBesideIt) {
    write("in/corner.gltf", kGltf);
    expect_rows({
        {"without its numbers", with({"in/corner.gltf", "--voxel-size", "1um"}), 4,
         "in/corner.gltf: cannot be read: .*corner.bin"},
    });
    write("in/corner.bin", corner_bin(20e-6F, 40e-6F, 10e-6F));
    // In metres, with y upwards: what was (x, y, z) is (x, -z, y).
    const ProgramResult result = run(with({"in/corner.gltf", "--voxel-size", "0.5um"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(found("6.6666[0-9]*e-18 mol|6.66667e-18 mol", result.out)) << result.out;
    EXPECT_TRUE(found("bounding box +\\[0, -10, 0\\] to \\[20, 0, 40\\] um", run({"info", "a.vdb"}).out));
    write("in/corner.bin", corner_bin(20e-6F, 40e-6F, 10e-6F).substr(0, 50));
    expect_rows({
        {"with too few numbers", with({"in/corner.gltf", "--voxel-size", "1um"}), 4, "in/corner.gltf: cannot be read"},
    });
}

TEST_F(VoxelizeInput, ASheetWithoutAnInsideIsRefused) {
    write("sheet.obj",
          "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 0 0 10\nv 10 0 10\nv 0 10 10\nf 1 2 6 5\nf 1 5 7 4\n");
    expect_rows(
        {CommandRow{"two quads", with({"sheet.obj", "--voxel-size", "0.5um"}), 4, "too open to have an inside"}});
}

}  // namespace
}  // namespace fluovox::testing
