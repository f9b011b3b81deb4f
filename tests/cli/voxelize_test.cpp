#include "cli/run_program.h"

#include <gtest/gtest.h>

#include <csignal>
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
    write("b.vdb", "a grid");
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
        {"a concentration beyond numbers",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=1e300M", "--voxel-size", "1um"},
         2,
         "--dye EGFP=1e300M: the concentration is denser than any matter"},
        {"no dye", {"voxelize", "box.obj", "-o", "a.vdb", "--voxel-size", "1um"}, 2, "add --dye"},
        {"no output", {"voxelize", "box.obj", "--dye", "EGFP=5uM", "--voxel-size", "1um"}, 2, "add -o"},
        {"an unknown option", with({"box.obj", "--voxel"}), 2, "unrecognised option"},
        {"padding of nothing", with({"box.obj", "--padding", "1um"}), 2, "give one of them"},
        {"a box beside the mesh", with({"box.obj", "--clip", "50um,50um,50um,60um,60um,60um"}), 4,
         "box.obj: nothing of it is inside the box of --bbox or --clip"},
        {"a grid given as a mesh", with({"b.vdb"}), 4, "b.vdb: is a grid already; --from-levelset"},
        {"an open mesh where only sound ones are wanted", with({"open.obj", "--strict"}), 4,
         "not watertight: 4 open edges"},
        {"a folder that does not exist",
         {"voxelize", "box.obj", "-o", "no/a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"},
         5,
         "does not exist"},
        {"a folder for the report that does not exist, before any work", with({"box.obj", "--report", "no/a.json"}), 5,
         "no/a.json: the folder no does not exist"},
        {"voxels smaller than an atom",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1e-6nm"},
         4,
         "smaller than an atom; choose a larger --voxel-size"},
    });
    EXPECT_EQ(files(),
              (std::vector<std::string>{"b.vdb", "box.obj", "empty.stl", "garbage.ply", "open.obj", "small.obj"}));
    expect_rows({
        {"an open mesh is capped, with a warning", with({"open.obj", "--repair"}), 0, "warning: open.obj: 4 open edges",
         "EGFP 6000 voxels"},
        {"a concentration that nothing dissolves",
         {"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=1M", "--voxel-size", "1um"},
         0,
         "warning: EGFP at 1 mol/L"},
    });
}

TEST_F(VoxelizeCommand, AnInputIsNeverTheOutput) {
    const std::string mesh = read("box.obj");
    const ProgramResult result =
        run({"voxelize", "box.obj", "-o", "./box.obj", "--dye", "EGFP=5uM", "--voxel-size", "1um"});
    EXPECT_EQ(run({"voxelize", "box.obj", "-o", "a.png", "--dye", "EGFP=5uM", "--voxel-size", "1um"}).exit_code, 2);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_TRUE(found("box.obj: is an input; give --output another name", result.err)) << result.err;
    EXPECT_EQ(read("box.obj"), mesh);
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

TEST_F(VoxelizeCommand, CtrlCLeavesNoFile) {
    RunLimits limits;
    limits.signal = SIGINT;
    // Once it is at work: well after it has begun, and long before it can be done.
    int asked = 0;
    limits.signal_when = [&] { return ++asked == 300; };
    const ProgramResult result =
        run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "6nm"}, limits);
    EXPECT_EQ(result.exit_code, 75) << result.err;
    EXPECT_TRUE(found("stopped; nothing was written", result.err)) << result.err;
    EXPECT_EQ(files(), (std::vector<std::string>{"box.obj", "small.obj"}));
}

TEST_F(VoxelizeCommand, ProgressSaysHowMuchTimeIsLeft) {
    const ProgramResult bar =
        run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "0.1um", "--progress", "bar"});
    EXPECT_TRUE(found("voxelizing +\\[=+ *\\] +[0-9]+ % +[0-9]+ s left", bar.err)) << bar.err;
    EXPECT_EQ(run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"}).err, "");
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
        {"a picture that is no PNG", {"info", "a.vdb", "--preview", "p.jpg"}, 2, "the picture is a PNG"},
    });
}

TEST_F(VoxelizeCommand, ACircuitPlacesScalesAndLabelsItsCells) {
    write("cells.csv",
          "file,x,y,z,rz,scale,dye,concentration,label\nsmall.obj,0,0,0,0,1,EGFP,5uM,7\n# a remark\n"
          "small.obj,20,0,0,90,2,DAPI,1uM,9\n");
    const ProgramResult result =
        run({"voxelize", "--circuit", "cells.csv", "-o", "c.vdb", "--voxel-size", "1um", "--labels"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(found("EGFP 64 voxels, .*; DAPI 512 voxels, .*; labels 576 voxels", result.out)) << result.out;
    EXPECT_TRUE(
        found("labels\n  values +int32 \\(whole numbers such as labels[^\n]*\n  labels +2, the largest 9\n"
              "[\\s\\S]*bounding box  \\[0, 0, 0\\] to \\[20, 8, 8\\] um",
              run({"info", "c.vdb"}).out))
        << run({"info", "c.vdb"}).out;
    // turned by 90 degrees about z: from x 0..8 to -8..0, then moved by 20
    EXPECT_TRUE(found("\\[12, 0, 0\\] to \\[20, 8, 8\\] um", run({"info", "c.vdb"}).out)) << run({"info", "c.vdb"}).out;
    write("bad.csv", "file,x\nsmall.obj,zero\n");
    write("gap.csv", "file\nsmall.obj\nnone.swc\n");
    write("odd.csv", "file,colour\nsmall.obj,red\n");
    expect_rows({
        {"a cell that is no number",
         {"voxelize", "--circuit", "bad.csv", "-o", "d.vdb", "--voxel-size", "1um", "--dye", "EGFP=1uM"},
         4,
         "bad.csv:2: x = \"zero\" is not a number"},
        {"a cell whose file is missing, before any work",
         {"voxelize", "--circuit", "gap.csv", "-o", "d.vdb", "--voxel-size", "1um", "--dye", "EGFP=1uM"},
         4,
         "gap.csv:3: none.swc cannot be read: no such file"},
        {"a column nobody knows",
         {"voxelize", "--circuit", "odd.csv", "-o", "d.vdb", "--voxel-size", "1um", "--dye", "EGFP=1uM"},
         4,
         "odd.csv:1: no column \"colour\""},
    });
}

TEST_F(VoxelizeCommand, MorphologiesShellsAndLevelSetsBecomeGrids) {
    write("cell.swc", "1 1 0 0 0 5 -1\n2 3 10 0 0 1 1\n3 3 20 0 0 -1 2\n");
    const ProgramResult cell =
        run({"voxelize", "cell.swc", "-o", "cell.vdb", "--dye", "EGFP=5uM", "--voxel-size", "0.5um"});
    EXPECT_EQ(cell.exit_code, 0) << cell.err;
    EXPECT_TRUE(found("warning: cell.swc: 1 radii of zero or less replaced", cell.err)) << cell.err;
    // 2200 um2 of surface, 10 nm thick, 5 umol/L
    const ProgramResult shell = run(
        {"voxelize", "box.obj", "-o", "shell.vdb", "--dye", "EGFP=5uM", "--voxel-size", "0.3um", "--shell", "10nm"});
    EXPECT_TRUE(found("1\\.1e-19 mol|1\\.09999[0-9]*e-19 mol", shell.out)) << shell.out << shell.err;
    EXPECT_EQ(run({"voxelize", "--from-levelset", "cell.vdb", "-o", "l.vdb", "--dye", "EGFP=5uM"}).exit_code, 4);
    if (std::system("command -v vdb_tool > /dev/null") != 0) GTEST_SKIP() << "vdb_tool is not installed";
    const std::string make = "vdb_tool -quiet -sphere r=2 v=0.1 -write '" + (folder() / "ball.vdb").string() + "'";
    ASSERT_EQ(std::system(make.c_str()), 0);
    EXPECT_TRUE(found("distances +-0.29[0-9]* to 0.29.* --from-levelset", run({"info", "ball.vdb"}).out));
    const ProgramResult ball = run({"voxelize", "--from-levelset", "ball.vdb", "-o", "b.vdb", "--dye", "EGFP=5uM"});
    EXPECT_TRUE(found("EGFP .* 1\\.67[0-9]*e-19 mol", ball.out)) << ball.out << ball.err;  // 33.5 um3
}

// A volume of Blender or Houdini is no concentration until the scene says so.
TEST_F(VoxelizeCommand, GridsOfOthersThatSayNoUnitAreDoubtedUntilTheSceneSaysIt) {
    if (std::system("command -v vdb_tool > /dev/null") != 0) GTEST_SKIP() << "vdb_tool is not installed";
    const std::string make =
        "vdb_tool -quiet -sphere r=2 v=0.1 -ls2fog -write '" + (folder() / "fog.vdb").string() + "'";
    ASSERT_EQ(std::system(make.c_str()), 0);
    write("scene.toml", R"([[medium]]
dye  = "EGFP"
grid = { file = "fog.vdb" }
[[light]]
kind       = "point"
wavelength = "488 nm"
power      = "1 mW"
position   = ["0 um", "0 um", "50 um"]
[camera]
position   = ["0 um", "0 um", "50 um"]
target     = ["0 um", "0 um", "0 um"]
field      = "10 um"
resolution = [4, 4]
[film]
spectrum = { from = "480 nm", to = "620 nm", bins = 7 }
)");
    expect_rows({
        {"doubted",
         {"render", "scene.toml", "-o", "a.exr", "--samples", "2"},
         0,
         "warning: .*fog.vdb: does not say what its values are: taken as umol/L; say it in the scene, grid = \\{ ..., "
         "unit = \"uM\" \\}\n"},
        {"no more when the scene says it",
         {"render", "scene.toml", "-o", "a.exr", "--samples", "2", "--set", "medium.0.grid.unit=\"uM\""},
         0,
         "^(?!.*does not say)note"},
        {"nor is the amount a fact", {"info", "fog.vdb"}, 0, "^$", "range +min .*\n.* mol if the values are umol/L"},
    });
}

TEST_F(VoxelizeCommand, SixteenBitsAreRefusedWhereTheyCannotHoldTheConcentration) {
    const auto with = [](const std::string& dye) {
        return std::vector<std::string>{"voxelize", "small.obj", "-o", "h.vdb",        "--dye",
                                        dye,        "--half",    "-q", "--voxel-size", "1um"};
    };
    expect_rows({
        {"too large", with("EGFP=100mM"), 4, "EGFP at 100000 umol/L: --half keeps .* 65504 umol/L; leave out --half"},
        {"too small", with("EGFP=1e-7uM"), 4, "EGFP at 1e-07 umol/L: .*leave out --half"},
    });
    EXPECT_EQ(files(), (std::vector<std::string>{"box.obj", "small.obj"}));
    expect_rows({
        {"the largest sum",
         {"voxelize", "box.obj", "--dye", "EGFP=40mM", "small.obj", "--dye", "EGFP=39mM", "-o", "h.vdb", "--overlap",
          "sum", "--half", "--voxel-size", "1um"},
         4,
         "EGFP at 79000 umol/L"},
        {"what they hold", with("EGFP=65mM"), 0, ""},
    });
    EXPECT_TRUE(found("max 64992 ", run({"info", "h.vdb"}).out)) << run({"info", "h.vdb"}).out;
}

TEST_F(VoxelizeCommand, AClipBetweenVoxelsKeepsTheAmountInItsBox) {
    // 3.1 x 2 x 0.2 um3 of 5 umol/L: faces within voxels, and both within one
    const ProgramResult result = run({"voxelize", "box.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size",
                                      "0.3um", "--clip", "0.5um,1um,10.25um,3.6um,3um,10.45um", "--report", "r.json"});
    EXPECT_TRUE(found(" 6\\.2e-21 mol| 6\\.2000[0-9]*e-21", result.out)) << result.out << result.err;
    EXPECT_TRUE(found("\"volume_um3\": 1\\.(2400|23999)", read("r.json"))) << read("r.json");
}

TEST_F(VoxelizeCommand, RoundingLeavesNoVoxelsBesideMeshesOfOneDye) {
    const std::string half =
        "v 0.1 0.1 0.1\nv 1.1 0.1 0.1\nv 0.1 1.1 0.1\nv 1.1 1.1 0.1\nv 0.1 0.1 1.1\n"
        "v 1.1 0.1 1.1\nv 0.1 1.1 1.1\nv 1.1 1.1 1.1\n";
    const std::string box = box_obj(1, 1, 1);
    write("a.obj", half + box.substr(box.find("f ")));
    write("b.obj", box);
    const ProgramResult result =
        run({"voxelize", "a.obj", "b.obj", "-o", "a.vdb", "--dye", "EGFP=5uM", "--voxel-size", "0.1um"});
    EXPECT_TRUE(found("EGFP 1271 voxels", result.out)) << result.out;  // 2 x 1000 - 729
    EXPECT_TRUE(found("\\[0, 0, 0\\] to \\[1.1, 1.1, 1.1\\] um", run({"info", "a.vdb"}).out))
        << run({"info", "a.vdb"}).out;
}

TEST_F(VoxelizeCommand, ACircuitSaysWhatIsWrongWithItsTable) {
    const std::string head = "file,x,dye,concentration\n";
    write("all.csv", "\xef\xbb\xbf" + head + "small.obj,0,EGFP,5uM\n");
    write("some.csv", head + "small.obj,0,EGFP,5uM\nsmall.obj,20,,\n");
    write("semicolons.csv", "file;x;dye;concentration\nsmall.obj;0;EGFP;5uM\n");
    write("dye.csv", head + "small.obj,0,EGPF,5uM\n");
    write("mesh.csv", head + "small.obj,0,EGFP,5uM\nbroken.obj,9,EGFP,5uM\n");
    write("broken.obj", "v 0 0 0\nv 0 0 one\n");
    const auto with = [](const std::string& table, std::vector<std::string> more = {}) {
        std::vector<std::string> all = {"voxelize", "--circuit", table, "-o", "c.vdb"};
        if (more.empty() || more.front() != "--resolution") all.insert(all.end(), {"--voxel-size", "1um"});
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    expect_rows({
        {"a byte order mark is passed over", with("all.csv"), 0, "", "EGFP 64 voxels"},
        {"a dye for the cells without one", with("some.csv", {"--dye", "DAPI=1uM"}), 0, "", "DAPI 64 voxels"},
        {"a dye that no cell takes", with("all.csv", {"--dye", "EGFP=9uM"}), 2, "the table gives each cell its dye"},
        {"labels of a segmentation", with("all.csv", {"--label", "1=EGFP:9uM"}), 2,
         "the table gives each cell its dye"},
        {"semicolons", with("semicolons.csv"), 4, "semicolons.csv:1: its columns must be separated by commas"},
        {"an unknown dye", with("dye.csv"), 3, "error: dye.csv:2: .*unknown dye \"EGPF\""},
        {"a broken mesh", with("mesh.csv"), 4, "error: mesh.csv:3: broken.obj:2: \"one\" is not a number"},
        {"found early", with("mesh.csv", {"--resolution", "9"}), 4, "error: mesh.csv:3: broken.obj:2: "},
    });
}

// 4 x 3 x 2 voxels of 16 x 16 x 40 nm: six of label 17, two of label 3.
TEST_F(VoxelizeCommand, ASegmentationBecomesGridsByLabel) {
    write("labels.nrrd",
          "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nencoding: ascii\nspacings: 16 16 40\n"
          "units: \"nm\" \"nm\" \"nm\"\n\n"
          "17 17 17 0  0 0 0 0  3 0 0 -1\n17 17 17 0  0 0 0 0  3 0 0 0\n");
    const ProgramResult result = run({"voxelize", "labels.nrrd", "-o", "s.vdb", "--label", "17=EGFP:5uM", "--label",
                                      "3=mCherry:2uM", "--labels", "--report", "r.json"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(
        found("EGFP 6 voxels, 3\\.072e-25 mol; mCherry 2 voxels, .*; labels 8 voxels; voxels of 0\\.016 x 0\\.016 "
              "x 0\\.04 um",
              result.out))
        << result.out;
    EXPECT_TRUE(found("\"voxel_size_um\": \\[\\s*0.016,\\s*0.016,\\s*0.0(4|3999)", read("r.json"))) << read("r.json");
    EXPECT_TRUE(found("\"label\": 17,\\s*\"voxels\": 6", read("r.json"))) << read("r.json");
    expect_rows({
        {"a label that is not there",
         {"voxelize", "labels.nrrd", "-o", "t.vdb", "--label", "18=EGFP:5uM"},
         4,
         "has no label 18 .*it has 2 labels: 3, 17"},
        {"no dye", {"voxelize", "labels.nrrd", "-o", "t.vdb"}, 2, "--label 17=EGFP:5uM"},
        {"a label without a dye", {"voxelize", "labels.nrrd", "-o", "t.vdb", "--label", "17"}, 2, "wants LABEL=DYE"},
        {"a label with two dyes",
         {"voxelize", "labels.nrrd", "-o", "t.vdb", "--label", "10-17=EGFP:5uM", "--label", "17=DAPI:5uM"},
         2,
         "--label 17=DAPI: label 17 has EGFP already"},
        {"label 0", {"voxelize", "labels.nrrd", "-o", "t.vdb", "--label", "0=EGFP:1uM"}, 2, "from 1"},
        {"a range that runs backwards",
         {"voxelize", "labels.nrrd", "-o", "t.vdb", "--label", "9-3=EGFP:1uM"},
         2,
         "9-3 is no range"},
        {"an option of meshes",
         {"voxelize", "labels.nrrd", "-o", "t.vdb", "--dye", "EGFP=1uM", "--resolution", "64"},
         2,
         "--resolution is for meshes"},
        {"labels of a mesh",
         {"voxelize", "box.obj", "-o", "t.vdb", "--label", "1=EGFP:1uM", "--voxel-size", "1um"},
         2,
         "--label is for segmentations"},
        {"with a mesh",
         {"voxelize", "box.obj", "labels.nrrd", "-o", "t.vdb", "--dye", "EGFP=1uM"},
         2,
         "takes a run and a file of its own"},
    });
    EXPECT_EQ(files(), (std::vector<std::string>{"box.obj", "labels.nrrd", "r.json", "s.vdb", "small.obj"}));
}

TEST_F(VoxelizeCommand, InfoDrawsAPreview) {
    run({"voxelize", "box.obj", "-o", "box.vdb", "--dye", "EGFP=5uM", "--voxel-size", "1um"});
    EXPECT_EQ(run({"info", "box.vdb", "--preview", "box.png"}).exit_code, 0);
    const std::string png = read("box.png");
    ASSERT_GT(png.size(), 24U);
    // Seen along x, the shortest side: 20 voxels of y to the right, 30 of z upwards.
    EXPECT_EQ(png[19], 20);
    EXPECT_EQ(png[23], 30);
}

}  // namespace
}  // namespace fluovox::testing
