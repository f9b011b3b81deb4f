#include "cli/run_program.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace fluovox::testing {
namespace {

/// A box from the origin to (x, y, z).
std::string box_obj(int x, int y, int z) {
    std::string text;
    for (int i = 0; i < 8; ++i)
        text += "v " + std::to_string((i & 1) != 0 ? x : 0) + ' ' + std::to_string((i & 2) != 0 ? y : 0) + ' ' +
                std::to_string((i & 4) != 0 ? z : 0) + '\n';
    return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

class VoxelizeCommand : public ProgramTest {
protected:
    VoxelizeCommand() {
        write("box.obj", box_obj(10, 20, 30));
        write("small.obj", box_obj(4, 4, 4));
    }
};

TEST_F(VoxelizeCommand, MakesAGridWithTheRightAmountAndSaysWhatItIs) {
    const ProgramResult result =
        run({"voxelize", "box.obj", "-o", "box.vdb", "--dye", "egfp=5uM", "--voxel-size", "1um"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(found("^box.vdb: EGFP 6000 voxels, 3e-17 mol;.*\n$", result.out)) << result.out;
    EXPECT_EQ(result.err, "");
    const ProgramResult info = run({"info", "box.vdb", "--json"});
    for (const char* key : {"name", "dye", "value_unit", "voxel_size_um", "active_voxels", "bbox_um", "min", "mean",
                            "max", "total_mol", "memory_bytes"}) {
        EXPECT_TRUE(found(std::string("\"") + key + "\": ", info.out)) << info.out;
    }
    EXPECT_TRUE(found("\"active_voxels\": 6000", info.out));
    EXPECT_TRUE(found("\"total_mol\": 3e-17|\"total_mol\": (3.0000000|2.9999999)[0-9]*e-17", info.out)) << info.out;
    EXPECT_TRUE(found("total amount  3e-17 mol", run({"info", "box.vdb"}).out));
}

TEST_F(VoxelizeCommand, OtherProgramsReadTheGrid) {
    if (std::system("command -v vdb_print > /dev/null") != 0) GTEST_SKIP() << "vdb_print is not installed";
    run({"voxelize", "box.obj", "-o", "box.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"});
    const std::string command =
        "vdb_print -m '" + (folder() / "box.vdb").string() + "' > '" + (folder() / "out").string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    const std::string text = read("out");
    for (const char* line :
         {"EGFP +float", "6KVox", "class: fog volume", "dye: EGFP", "value_unit: umol/L", "length_unit: um",
          "source: box.obj", "source_sha256: [0-9a-f]{64}", "fluovox_version: "}) {
        EXPECT_TRUE(found(line, text)) << text;
    }
}

TEST_F(VoxelizeCommand, EachDyeCoversTheMeshesBeforeIt) {
    const ProgramResult result = run({"voxelize", "box.obj", "small.obj", "--dye", "EGFP=5uM", "small.obj", "--dye",
                                      "DAPI=1uM", "-o", "two.vdb", "--voxel-size", "1um"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    // small.obj lies inside box.obj and adds nothing to the union
    EXPECT_TRUE(found("EGFP 6000 voxels, .*; DAPI 64 voxels", result.out)) << result.out;
}

TEST_F(VoxelizeCommand, OneDyeAtTwoConcentrationsFollowsTheOverlapRule) {
    const auto total = [&](const char* rule) {
        run({"voxelize", "box.obj", "--dye", "EGFP=2uM", "small.obj", "--dye", "EGFP=1uM", "-o", "a.vdb",
             "--voxel-size", "1um", "--overlap", rule});
        return run({"info", "a.vdb"}).out;
    };
    EXPECT_TRUE(found("min 2, mean 2, max 2 ", total("max")));
    EXPECT_TRUE(found("min 2, .*max 3 ", total("sum")));
    EXPECT_TRUE(found("min 2, .*max 2 ", total("first")));
    EXPECT_TRUE(found("min 1, .*max 2 ", total("last")));
}

TEST_F(VoxelizeCommand, MistakesGetTheirExitCodeAndACure) {
    write("garbage.ply", "\x01\x02garbage");
    write("empty.stl", "");
    const std::string open = box_obj(10, 20, 30);
    write("open.obj", open.substr(0, open.rfind('f')));
    const std::vector<std::string> tail = {"-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"};
    const auto with = [&](std::vector<std::string> head) {
        head.insert(head.begin(), "voxelize");
        head.insert(head.end(), tail.begin(), tail.end());
        return head;
    };
    expect_rows({
        {"help", {"voxelize", "--help"}, 0, "", "Examples:[\\s\\S]*--mesh-unit"},
        {"a mesh in nm read as um", with({"box.obj", "--mesh-unit", "1cm"}), 4, "voxels of 1 um.*add --mesh-unit nm"},
        {"a missing mesh", with({"none.obj"}), 4, "none.obj: cannot be read: No such file"},
        {"garbage", with({"garbage.ply"}), 4, "garbage.ply:1: is not a PLY file"},
        {"an empty file", with({"empty.stl"}), 4, "empty.stl: is empty"},
        {"no mesh format", with({"a.docx"}), 4, "a.docx"},
        {"an unknown dye",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGPF=5uM", "--voxel-size", "1um"},
         3,
         "unknown dye \"EGPF\"; did you mean \"EGFP\""},
        {"a concentration without unit",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5", "--voxel-size", "1um"},
         2,
         "needs a unit[\\s\\S]*Usage: fluovox voxelize"},
        {"a concentration below zero",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=-5uM", "--voxel-size", "1um"},
         2,
         "greater than zero"},
        {"a voxel size of zero",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "0um"},
         2,
         "greater than zero"},
        {"a voxel size that is a power",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1mW"},
         2,
         "length"},
        {"no dye", {"voxelize", "box.obj", "-o", "a.vdb", "--voxel-size", "1um"}, 2, "add --dye"},
        {"no output", {"voxelize", "box.obj", "--dye", "EGFP=5uM", "--voxel-size", "1um"}, 2, "add -o"},
        {"an unknown option", with({"box.obj", "--voxel"}), 2, "unrecognised option"},
        {"an open mesh where only sound ones are wanted", with({"open.obj", "--strict"}), 4,
         "not watertight: 4 open edges"},
        {"a folder that does not exist",
         {"voxelize", "box.obj", "-o", "no/a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"},
         5,
         "does not exist"},
    });
    EXPECT_EQ(files(), (std::vector<std::string>{"box.obj", "empty.stl", "garbage.ply", "open.obj", "small.obj"}));
    expect_rows({
        {"an open mesh is capped, with a warning", with({"open.obj", "--repair"}), 0, "warning: open.obj: 4 open edges",
         "EGFP 6000 voxels"},
        {"a concentration that nothing dissolves",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=1M", "--voxel-size", "1um"},
         0,
         "warning: EGFP at 1 mol/L"},
    });
}

TEST_F(VoxelizeCommand, AFullDiskLeavesTheOldFile) {
    run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"});
    const std::string before = read("a.vdb");
    RunLimits limits;
    limits.max_file_bytes = 3000;
    const ProgramResult result =
        run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "0.3um"}, limits);
    EXPECT_EQ(result.exit_code, 5) << result.err;
    EXPECT_EQ(read("a.vdb"), before);
    EXPECT_EQ(files().size(), 3U);
}

TEST_F(VoxelizeCommand, InfoSaysWhatIsWrongWithAFile) {
    write("garbage.vdb", "garbage");
    run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"});
    write("cut.vdb", read("a.vdb").substr(0, 900));
    expect_rows({
        {"no file", {"info"}, 2, "which file"},
        {"a missing file", {"info", "none.vdb"}, 4, "none.vdb: cannot be read"},
        {"garbage", {"info", "garbage.vdb"}, 4, "not a VDB file"},
        {"a truncated file", {"info", "cut.vdb"}, 4, "truncated"},
    });
}

}  // namespace
}  // namespace fluovox::testing
