#include "cli/run_program.h"

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

// A dye box in a thin host, lit by a laser beam and a lamp band: every kind of layer has light.
const std::string kScene = R"([[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { box = { min = ["-200 um", "-200 um", "-200 um"], max = ["200 um", "200 um", "200 um"] } }
[[medium]]
scattering = "2 /mm"
anisotropy = 0.9
region     = { box = { min = ["-200 um", "-200 um", "-200 um"], max = ["200 um", "200 um", "200 um"] } }
[[light]]
kind       = "beam"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-1 mm", "0 um", "0 um"]
direction  = [1, 0, 0]
radius     = "50 um"
[[light]]
kind      = "point"
spectrum  = { from = "450 nm", to = "500 nm" }
power     = "1 mW"
position  = ["0 um", "1 mm", "0 um"]
[camera]
kind       = "telecentric"
position   = ["0 um", "0 um", "2 mm"]
target     = ["0 um", "0 um", "0 um"]
field      = "500 um"
resolution = [12, 8]
[film]
spectrum = { from = "480 nm", to = "620 nm", bins = 7 }
[render]
samples = 8
)";

class RenderTest : public ProgramTest {
protected:
    /// Writes the scene with `from` replaced by `to` under `name`.
    void write_changed(const std::string& name, const std::string& from, const std::string& to) const {
        std::string text = kScene;
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        write(name, text.replace(at, from.size(), to));
    }
};

// However much there is to do before the next pixel or batch of photons is done.
TEST_F(RenderTest, EndsSoonAfterItIsAskedToStop) {
    write("scene.toml", kScene);
    const std::vector<std::vector<std::string>> commands = {
        {"render", "scene.toml", "-o", "image.exr", "--samples", "20000000", "--set", "render.estimator=path"},
        {"render", "scene.toml", "-o", "image.exr", "--samples", "20000000"},
        {"render", "scene.toml", "-o", "image.exr", "--samples", "20000000", "--set", "render.estimator=light"},
        {"fluence", "scene.toml", "--photons", "20000000000"},
    };
    for (const std::vector<std::string>& command : commands) {
        RunLimits limits;
        limits.signal = SIGTERM;
        limits.seconds = 8;
        int asked = 0;
        limits.signal_when = [&] { return ++asked == 100 * kSlowness; };
        const ProgramResult result = run(command, limits);
        EXPECT_EQ(result.exit_code, 75) << result.command << result.err;
        EXPECT_FALSE(result.timed_out) << result.command;
    }
    EXPECT_EQ(files(), std::vector<std::string>{"scene.toml"});
}

TEST_F(RenderTest, SeedsThatAreTooLargeAreToldWithTheirRange) {
    write_changed("real.toml", "samples = 8", "seed = 1e19");
    const std::string range = "must be a whole number from 0 to 9223372036854775807";
    expect_rows({
        {"as a real number", {"check", "real.toml"}, 3, "real.toml:[0-9]+:.*" + range},
        {"set", {"check", "real.toml", "--set", "render.seed=18446744073709551615"}, 3, "--set.*" + range},
    });
}

TEST_F(RenderTest, SaysHowMuchMemoryItTookWhereMoreIsAskedFor) {
    write("scene.toml", kScene);
    const std::vector<std::string> command = {"render", "scene.toml", "-o", "image.exr", "--samples", "1"};
    EXPECT_FALSE(found("peak memory", run(command).err));
    std::vector<std::string> verbose = command;
    verbose.emplace_back("-v");
    const ProgramResult result = run(verbose);
    EXPECT_TRUE(found("peak memory [1-9][0-9]* MB", result.err)) << result.err;
}

TEST_F(RenderTest, WritesTheImageAndItsPreview) {
    write("scene.toml", kScene);
    expect_rows({
        {"names of the results on stdout",
         {"render", "scene.toml", "-o", "image.exr"},
         0,
         "note: estimator cached, since light is scattered[\\s\\S]*biased[\\s\\S]*12 x 8 pixels, 8 samples each, "
         "estimator cached",
         "^image.exr\nimage.png\n$",
         {"image.exr", "image.png"}},
        {"JSON for machines",
         {"render", "scene.toml", "-o", "image.exr", "--json"},
         0,
         "",
         "\"outputs\": \\[\\s*\"image.exr\",\\s*\"image.png\"\\s*\\],\\s*\"seconds\": [\\s\\S]*\"samples\": "
         "8,\\s*\"threads\": "
         "\\d+,\\s*\"estimator\": \"cached\",\\s*\"nan_count\": 0,\\s*\"bound_violations\": "
         "0,\\s*\"median_relative_error\": "},
        {"quiet says nothing but the results", {"render", "scene.toml", "-o", "image.exr", "-q"}, 0, "^$", "image.exr"},
        {"examples first", {"render", "--help"}, 0, "", "^Examples:"},
        {"one sample tells no error",
         {"render", "scene.toml", "-o", "image.exr", "--samples", "1"},
         0,
         "median relative error unknown \\(one sample per pixel\\), unknown"},
        {"which JSON has as null",
         {"render", "scene.toml", "-o", "image.exr", "--samples", "1", "--json"},
         0,
         "",
         "\"median_relative_error\": null,\\s*\"bright_relative_error\": null"},
    });
}

TEST_F(RenderTest, SameSeedSameBytesForAnyNumberOfThreads) {
    write("scene.toml", kScene);
    for (const char* threads : {"1", "2", "4"}) {
        const auto result = run({"render", "scene.toml", "-o", std::string(threads) + ".exr", "--threads", threads});
        ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    EXPECT_EQ(read("1.exr"), read("2.exr"));
    EXPECT_EQ(read("1.exr"), read("4.exr"));
    EXPECT_EQ(read("1.png"), read("4.png"));
    ASSERT_EQ(run({"render", "scene.toml", "-o", "other.exr", "--seed", "2"}).exit_code, 0);
    EXPECT_NE(read("1.exr"), read("other.exr"));
}

TEST_F(RenderTest, WarnsOfWhatMayBeAMistake) {
    write_changed("laser.toml", "wavelength = \"488 nm\"", "wavelength = \"700 nm\"");
    write_changed("mol.toml", "concentration = \"10 uM\"", "concentration = \"10 M\"");
    write_changed("dark.toml", "position   = [\"-1 mm\", \"0 um\", \"0 um\"]",
                  "position   = [\"-1 mm\", \"9 mm\", \"0 um\"]");
    std::string lamp = read("laser.toml");
    lamp.replace(lamp.find("450 nm"), 6, "650 nm");
    lamp.replace(lamp.find("500 nm\" }"), 6, "700 nm");
    write("laser.toml", lamp);
    std::string dark = read("dark.toml");
    dark.erase(dark.find("[[light]]\nkind      = \"point\""),
               dark.find("[camera]") - dark.find("[[light]]\nkind      = \"point\""));
    write("dark.toml", dark);
    expect_rows({
        {"a light that the dye hardly absorbs",
         {"render", "laser.toml", "-o", "a.exr"},
         0,
         "warning: EGFP absorbs the light at [0-9.e-]+ % of its peak \\(48\\d nm\\); expect almost no signal"},
        {"an absurd concentration",
         {"render", "mol.toml", "-o", "b.exr"},
         0,
         "warning: .*10 mol/L.*did you mean 10 uM\\?"},
        {"a black image says what misses what",
         {"render", "dark.toml", "-o", "c.exr"},
         0,
         "warning: the image has no fluorescence\nwarning: .*the beam passes it 8\\.\\d+ mm away"},
    });
}

TEST_F(RenderTest, ErrorsOfVeryFaintLightAreNoLargerThanIt) {
    // Dye far out in a Gaussian beam, and a little in its middle: one sample of eight that has light means 100 %,
    // however little that is.
    std::string faint = R"([[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { sphere = { center = ["31 um", "9 um", "0 um"], radius = "8 um" } }
[[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { sphere = { center = ["31 um", "110 um", "0 um"], radius = "50 um" } }
)" + kScene.substr(kScene.find("[[light]]"));
    faint.erase(faint.find("[[light]]\nkind      = \"point\""),
                faint.find("[camera]") - faint.find("[[light]]\nkind      = \"point\""));
    faint.replace(faint.find("\"50 um\"", faint.find("radius     =")), 7, "\"10 um\"");
    write("faint.toml", faint);
    const auto result = run({"render", "faint.toml", "-o", "f.exr", "--json", "--set", "render.estimator=path"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const std::string key = "\"median_relative_error\": ";
    const double error = std::stod(result.out.substr(result.out.find(key) + key.size()));
    EXPECT_GT(error, 0);
    EXPECT_LE(error, 1.0001);
}

TEST_F(RenderTest, WithoutConversionsTheElasticLightIsShown) {
    write("scene.toml", kScene);
    expect_rows({
        {"nothing is amiss",
         {"render", "scene.toml", "-o", "e.exr", "--set", "render.fluorescence_orders=0", "--samples", "64"},
         0,
         "^note: estimator path, since no light is to be converted\n12 x 8 pixels, 64 samples each, estimator path, .*"
         "median relative error [1-9]"},
        {"nor with its spectrum", {"spectrum", "e.exr", "-o", "e.csv"}, 0, "no fluorescence; this is all of its light"},
    });
    const std::string csv = read("e.csv");
    EXPECT_GT(std::stod(csv.substr(csv.find("\n490,") + 5)), 0) << csv;  // the laser's bin
}

TEST_F(RenderTest, EmptyAndImpossibleGridsAreTold) {
    write("box.off", "OFF\n4 4 0\n0 0 0\n90 0 0\n0 90 0\n0 0 90\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
    const auto made = run({"voxelize", "box.off", "-o", "box.vdb", "--dye", "EGFP=5uM", "--voxel-size", "5um"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const std::string region = kScene.substr(kScene.find("concentration"),
                                             kScene.find("[[medium]]\nscattering") - kScene.find("concentration"));
    write_changed("empty.toml", region, "grid = { file = \"box.vdb\", scale = 0 }\n");
    write_changed("dense.toml", region, "grid = { file = \"box.vdb\", scale = 1e12 }\n");
    write_changed("endless.toml", region, "grid = { file = \"box.vdb\", scale = 1e300 }\n");
    std::vector<CommandRow> rows = {
        {"denser than matter", {"render", "dense.toml", "-o", "d.exr"}, 4, "box.vdb: .*5e\\+06 mol/L, denser than any"},
        {"beyond numbers",
         {"render", "endless.toml", "-o", "e.exr"},
         4,
         "box.vdb: .*no finite number, denser than any"},
    };
    for (const char* estimator : {"path", "light", "cached"}) {
        rows.push_back({std::string("an empty grid, estimator ") + estimator,
                        {"render", "empty.toml", "-o", "a.exr", "--set", std::string("render.estimator=") + estimator},
                        0,
                        "warning: the image has no fluorescence\nwarning: EGFP: its grid is empty"});
    }
    expect_rows(rows);
}

TEST_F(RenderTest, RefusesWhatThePathEstimatorCannotSample) {
    write_changed("pencil.toml", "radius     = \"50 um\"", "radius     = \"0 um\"");
    write_changed("facing.toml", "position   = [\"-1 mm\", \"0 um\", \"0 um\"]\ndirection  = [1, 0, 0]",
                  "position   = [\"0 um\", \"0 um\", \"-1 mm\"]\ndirection  = [0, 0, 1]");
    expect_rows({
        {"a pencil beam",
         {"render", "pencil.toml", "-o", "a.exr", "--set", "render.estimator=path"},
         3,
         "pencil.toml:9:1: error: .*estimator.*\"light\"",
         "^$",
         {},
         {"a.exr"}},
        {"light straight into the camera",
         {"render", "facing.toml", "-o", "a.exr", "--set", "render.estimator=path"},
         3,
         "shines straight into the camera"},
        {"left to the program",
         {"render", "facing.toml", "-o", "b.exr"},
         0,
         "note: estimator light, since paths from the camera cannot show every light here"},
    });
}

TEST_F(RenderTest, OutputTroubleLosesNothing) {
    write("scene.toml", kScene);
    write("old.exr", "an image of yesterday");
    expect_rows({
        {"a folder that is not there",
         {"render", "scene.toml", "-o", "nowhere/a.exr"},
         5,
         "nowhere/a.exr: the folder nowhere does not exist"},
        {"no output named", {"render", "scene.toml"}, 2, "-o OUT.exr[\\s\\S]*Usage: fluovox render"},
        {"another format", {"render", "scene.toml", "-o", "a.jpg"}, 2, "OpenEXR"},
        {"no scene named", {"render", "-o", "a.exr"}, 2, "which scene"},
        {"options of stacks",
         {"render", "scene.toml", "-o", "a.exr", "--truth", "all"},
         2,
         "--truth is of stacks, and the scene has no \\[stack\\]"},
        {"of which overwriting is one", {"render", "scene.toml", "-o", "a.exr", "--overwrite"}, 2, "--overwrite is of"},
        {"a scene that is not there", {"render", "gone.toml", "-o", "a.exr"}, 4, "gone.toml"},
        {"no samples",
         {"render", "scene.toml", "-o", "a.exr", "--samples", "0"},
         2,
         "--samples must be 1 or more\nUsage: fluovox render"},
        {"a negative seed",
         {"render", "scene.toml", "-o", "a.exr", "--seed", "-1"},
         2,
         "--seed must be 0 or more\nUsage: fluovox render"},
    });
    const auto full = run({"render", "scene.toml", "-o", "old.exr"}, {60, 1000});
    EXPECT_EQ(full.exit_code, 5) << full.err;
    EXPECT_EQ(read("old.exr"), "an image of yesterday");
    EXPECT_EQ(files(), (std::vector<std::string>{"old.exr", "scene.toml"}));
}

TEST_F(RenderTest, AnImageRendersAgainFromTheSceneInIt) {
    write("scene.toml", kScene);
    ASSERT_EQ(run({"render", "scene.toml", "-o", "a.exr", "--seed", "5"}).exit_code, 0);
    std::filesystem::remove(folder() / "scene.toml");
    ASSERT_EQ(run({"render", "a.exr", "-o", "b.exr"}).exit_code, 0);
    EXPECT_TRUE(read("a.exr") == read("b.exr"));
    write("resolved.json", run({"info", "a.exr", "--scene"}).out);
    ASSERT_EQ(run({"render", "resolved.json", "-o", "c.exr"}).exit_code, 0);
    EXPECT_TRUE(read("a.exr") == read("c.exr"));
    ASSERT_EQ(run({"render", "a.exr", "-o", "d.exr", "--set", "render.seed=6"}).exit_code, 0);
    EXPECT_FALSE(read("a.exr") == read("d.exr"));
    expect_rows({
        {"an image is not rendered into itself", {"render", "a.exr", "-o", "a.exr"}, 2, "a.exr: is an input"},
        {"one sample", {"render", "a.exr", "-o", "e.exr", "--samples", "1"}, 0, "12 x 8 pixels, 1 sample each"},
        {"a grid that is not there, with its place in the scene",
         {"render", "a.exr", "-o", "e.exr", "--set", "medium.0={dye=\"EGFP\",grid={file=\"none.vdb\"}}"},
         4,
         "error: (a.exr|--set [^\\n]*):\\d+:\\d+: none.vdb: cannot be read"},
        {"an image that is not there", {"check", "none.exr"}, 4, "none.exr: there is no such file"},
    });
}

}  // namespace
}  // namespace fluovox::testing
