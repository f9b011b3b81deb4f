#include "cli/run_program.h"

namespace fluovox::testing {
namespace {

const std::string kScene = R"([[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = "everywhere"
[[medium]]
scattering = "20 /mm"
anisotropy = 0.9
region     = "everywhere"
[[light]]
kind       = "beam"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-1 mm", "0 um", "0 um"]
direction  = [1, 0, 0]
radius     = "5 um"
[camera]
position   = ["0 um", "0 um", "2 mm"]
target     = ["0 um", "0 um", "0 um"]
field      = "500 um"
resolution = [64, 32]
[film]
spectrum = { from = "480 nm", to = "620 nm", bins = 28 }
)";

class CheckTest : public ProgramTest {
protected:
    /// The row for a scene in which `from` has become `to`.
    CommandRow mistake(const std::string& promise, const std::string& from, const std::string& to, int exit_code,
                       const std::string& message) {
        std::string text = kScene;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        const std::string name = "scene" + std::to_string(++count_) + ".toml";
        write(name, text.replace(at, from.size(), to));
        return {promise, {"check", name}, exit_code, message, "^$"};
    }

private:
    int count_ = 0;
};

TEST_F(CheckTest, AGoodSceneIsSummedUpAndPrinted) {
    write("scene.toml", kScene);
    expect_rows({
        {"a summary", {"check", "scene.toml"}, 0, "^$", "camera +telecentric, 500 um high, 64 x 32 pixels"},
        {"the scene as JSON",
         {"check", "scene.toml", "--print"},
         0,
         "^$",
         "^\\{[\\s\\S]*\"focus\": \"2000 um\"[\\s\\S]*\\}\n$"},
        {"the same by --json", {"check", "scene.toml", "--json"}, 0, "^$", "\"seed\": 1"},
        {"quiet", {"check", "scene.toml", "-q"}, 0, "^$", "^$"},
        {"the aperture as it was given",
         {"check", "scene.toml", "--set", "camera.numerical_aperture=0.8", "--set", "camera.immersion_index=1.33"},
         0,
         "^$",
         "numerical aperture 0.8 in index 1.33\n"},
        {"how many planes",
         {"check", "scene.toml", "--set", "stack={along=[0,0,1],start=\"-1 um\",stop=\"1.1 um\",step=\"0.5 um\"}"},
         0,
         "^$",
         "stack +5 planes from -1 um to 1.1 um in steps of 0.5 um\n"},
        {"channels with what they let through",
         {"check", "scene.toml", "--set", "film={channel=[{name=\"green\",band={from=\"500 nm\",to=\"550 nm\"}}]}"},
         0,
         "^$",
         "channels green \\(500 nm to 550 nm\\), in watts"},
        {"an override", {"check", "scene.toml", "--set", "camera.resolution=[8,4]"}, 0, "^$", "8 x 4 pixels"},
        {"several",
         {"check", "--set", "render.seed=3", "scene.toml", "--set", "render.samples=9"},
         0,
         "^$",
         "9 samples per pixel, seed 3"},
        {"examples come first in the help", {"check", "--help"}, 0, "^$", "^Examples:[\\s\\S]*--set KEY=VALUE"},
    });
    EXPECT_EQ(run({"check", "scene.toml", "--print"}).out, run({"check", "scene.toml", "--print"}).out);
    EXPECT_EQ(files(), std::vector<std::string>{"scene.toml"});
}

TEST_F(CheckTest, WrongCommandLinesShowTheUsage) {
    write("scene.toml", kScene);
    expect_rows({
        {"no scene", {"check"}, 2, "the scene is missing[\\s\\S]*Usage: fluovox check SCENE.toml", "^$"},
        {"unknown option", {"check", "scene.toml", "--prnit"}, 2, "prnit[\\s\\S]*Usage: fluovox check", "^$"},
        {"two scenes", {"check", "scene.toml", "scene.toml"}, 2, "Usage: fluovox check", "^$"},
        {"an override without a value",
         {"check", "scene.toml", "--set", "camera.focus"},
         2,
         "--set takes KEY=VALUE",
         "^$"},
        {"an option without its argument",
         {"check", "scene.toml", "--set"},
         2,
         "set[\\s\\S]*Usage: fluovox check",
         "^$"},
    });
}

TEST_F(CheckTest, MistakesInTheSceneNamePlaceCauseAndCure) {
    expect_rows({
        mistake("number without unit", "field      =", "focus      = 6.5\nfield      =", 3,
                "^scene1\\.toml:19:14: error: camera\\.focus = 6\\.5 needs a unit, for example \"6\\.5 um\"\n$"),
        mistake(
            "wrong kind of unit", "\"500 um\"", "\"500 mW\"", 3,
            "^scene2\\.toml:19:14: error: camera\\.field = \"500 mW\" is a power, not a length \\(its units: um nm"),
        mistake("misspelt key", "anisotropy", "anisotropi", 3,
                "^scene3\\.toml:7:1: error: unknown key \"medium\\.1\\.anisotropi\"; did you mean \"anisotropy\"\\?"),
        mistake("unknown dye", "\"EGFP\"", "\"EGPF\"", 3, "^scene4\\.toml:2:17: error: .*EGPF.*EGFP.*fluovox dyes"),
        mistake("g out of range", "0.9", "1.0", 3,
                "^scene5\\.toml:7:14: error: medium\\.1\\.anisotropy = 1 is out of range: it must lie from -1 to 1"),
        mistake("negative concentration", "\"10 uM\"", "\"-10 uM\"", 3,
                "^scene6\\.toml:3:17: error: medium\\.0\\.concentration = \"-10 uM\" must be 0 or more"),
        mistake("impossible concentration", "\"10 uM\"", "\"1e300 M\"", 3,
                "medium\\.0\\.concentration = \"1e300 M\" is denser than any matter"),
        mistake("impossible coefficient", "\"20 /mm\"", "\"1e300 /mm\"", 3,
                "medium\\.1\\.scattering = \"1e300 /mm\" is more than matter can do: it must be 1000 /um or less"),
        mistake("a part of a pixel", "[64, 32]", "[64, 32.5]", 3, "camera\\.resolution\\.1 = 32\\.5 must be a whole"),
        mistake("negative coefficient", "\"20 /mm\"", "\"-20 /mm\"", 3,
                "medium\\.1\\.scattering = \"-20 /mm\" must be 0 or more"),
        mistake("reversed band", "\"620 nm\"", "\"420 nm\"", 3,
                "film\\.spectrum\\.to = \"420 nm\" must be above film\\.spectrum\\.from = \"480 nm\""),
        mistake("film larger than memory", "[64, 32]", "[900000, 900000]", 3,
                "camera\\.resolution = \\[900000, 900000\\] .*larger than the memory.*take fewer pixels"),
        mistake("negative resolution", "[64, 32]", "[64, -32]", 3,
                "^scene13\\.toml:20:19: error: camera\\.resolution\\.1 = -32 must be 1 or more"),
        mistake("no bins", "bins = 28", "bins = 0", 3, "film\\.spectrum\\.bins = 0 must be 1 or more"),
        mistake("no direction", "[1, 0, 0]", "[0, 0, 0]", 3, "light\\.0\\.direction = \\[0, 0, 0\\] has no direction"),
        mistake("a dye file that is absent", "\"EGFP\"", "\"mine.toml\"", 4, "scene16\\.toml:2:17: .*mine\\.toml"),
        mistake("a lamp file that is absent", "wavelength = \"488 nm\"", "spectrum = { file = \"lamp.csv\" }", 4,
                "scene17\\.toml:11:21: light\\.0\\.spectrum\\.file: .*lamp\\.csv"),
    });
}

TEST_F(CheckTest, OverriddenMistakesNameTheOption) {
    write("scene.toml", kScene);
    expect_rows({
        {"value",
         {"check", "scene.toml", "--set", "camera.focus=6.5"},
         3,
         "^--set camera\\.focus=6\\.5: error: camera\\.focus = 6\\.5 needs a unit",
         "^$"},
        {"key",
         {"check", "scene.toml", "--set", "camera.fokus=\"1 mm\""},
         3,
         "^--set camera\\.fokus=\"1 mm\": error: unknown key \"camera\\.fokus\"; did you mean \"focus\"",
         "^$"},
    });
}

TEST_F(CheckTest, WhatIsAllowedButOddIsAWarning) {
    write("strong.toml", kScene);
    expect_rows({
        {"concentration over 0.1 mol/L",
         {"check", "strong.toml", "--set", "medium.0.concentration=0.5 M"},
         0,
         "^warning: medium\\.0\\.concentration = \"0\\.5 M\" is more than 0\\.1 mol/L",
         "medium"},
        {"a name that stands for another dye",
         {"check", "strong.toml", "--set", "medium.0.dye=GFP"},
         0,
         "^note: medium\\.0\\.dye: .*EGFP",
         "medium"},
    });
}

TEST_F(CheckTest, FilesThatAreNoScenesAreRefused) {
    write("empty.toml", "");
    write("cut.toml", kScene.substr(0, kScene.size() - 12));
    write("garbage.toml", std::string("\x7f"
                                      "ELF\x02\x01\0\0\xff\xfe garbage",
                                      18));
    write("zeros.toml", std::string(5000, '\0'));
    write("deep.toml", "x = " + std::string(100'000, '['));
    std::string dots;
    for (int i = 0; i < 50'000; ++i)
        dots += "a.";
    write("dots.toml", dots + "a = 1\n");
    write("large.toml", std::string((std::size_t{16} << 20) + 1, '\n'));
    expect_rows({
        {"empty", {"check", "empty.toml"}, 3, "^empty\\.toml:1:1: error: camera is missing", "^$"},
        {"cut off", {"check", "cut.toml"}, 3, "^cut\\.toml:22:[0-9]+: error: not a scene: ", "^$"},
        {"binary", {"check", "garbage.toml"}, 3, "^garbage\\.toml:1:[0-9]+: error: not a scene: ", "^$"},
        {"zeros", {"check", "zeros.toml"}, 3, "^zeros\\.toml:1:[0-9]+: error: not a scene: ", "^$"},
        {"a key without end", {"check", "dots.toml"}, 3, "^dots\\.toml:1:1: error: .*more than 256 dots", "^$"},
        {"nested without end", {"check", "deep.toml"}, 3, "^deep\\.toml:1:[0-9]+: error: not a scene: ", "^$"},
        {"huge", {"check", "large.toml"}, 3, "^large\\.toml: error: is larger than 16 MiB", "^$"},
        {"absent", {"check", "absent.toml"}, 4, "absent\\.toml: cannot be read: No such file", "^$"},
        {"a folder", {"check", "."}, 4, "\\.: is a folder", "^$"},
    });
}

TEST_F(CheckTest, GridsAreLookedFor) {
    const std::string dye = "concentration = \"10 uM\"\nregion        = \"everywhere\"\n";
    const std::string grid = "grid = { file = \"neuron.vdb\" }\n";
    CommandRow row = mistake("a grid file that is absent", dye, grid, 4, "scene1\\.toml:3:8: neuron\\.vdb: cannot be");
    row.out = "";
    expect_rows({row});
    write("neuron.vdb", "no VDB file");
    row.promise = "a grid file that is none";
    row.err = "scene1\\.toml:3:8: neuron\\.vdb: ";
    expect_rows({row});
}

}  // namespace
}  // namespace fluovox::testing
