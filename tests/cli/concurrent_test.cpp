// Two runs of the program on one and the same output.

#include "cli/run_program.h"

#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

namespace fs = std::filesystem;

const std::string kImage = R"([[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { sphere = { center = ["0 um", "0 um", "0 um"], radius = "30 um" } }
[[medium]]
scattering = "2 /mm"
anisotropy = 0.9
region     = { box = { min = ["-100 um", "-100 um", "-100 um"], max = ["100 um", "100 um", "100 um"] } }
[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-1 mm", "0 um", "0 um"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "300 um"
thickness  = "5 um"
[camera]
position   = ["0 um", "0 um", "2 mm"]
target     = ["0 um", "0 um", "0 um"]
field      = "144 um"
resolution = [14, 12]
numerical_aperture = 0.3
[[film.channel]]
name = "green"
band = { center = "525 nm", width = "50 nm" }
[render]
estimator = "path"
samples = 700
)";
const std::string kStack = R"([stack]
along = [0, 0, 1]
start = "-20 um"
stop  = "20 um"
step  = "10 um"
)";

class ConcurrentTest : public ProgramTest {
protected:
    ConcurrentTest() {
        write("image.toml", kImage);
        write("scene.toml", kImage + kStack);
    }

    /// Runs `first`, and `second` as soon as `file` is there; the results of both, in that order.
    std::vector<ProgramResult> run_beside(const std::vector<std::string>& first, const fs::path& file,
                                          const std::vector<std::string>& second) const {
        std::optional<ProgramResult> other;
        RunLimits limits;
        limits.signal_when = [&] {
            if (!other && fs::exists(folder() / file)) other = run(second);
            return false;
        };
        const ProgramResult one = run(first, limits);
        if (!other) {
            ADD_FAILURE() << "the first run was too quick";
            return {one, one};
        }
        return {one, *other};
    }
};

TEST_F(ConcurrentTest, ASecondRunOnAStackStopsAtOnceAndTheFirstEndsAsIfAlone) {
    for (const std::string name : {"stack.ome.tif", "stack.ome.zarr", "stack.exr"}) {
        const std::vector<std::string> first = {"render", "scene.toml", "-o", name};
        std::vector<std::string> second = first;
        if (name != "stack.ome.tif") second.insert(second.end(), {"--seed", "2", "--overwrite"});
        const auto results = run_beside(first, name + ".planes/00000.plane", second);
        EXPECT_EQ(results[0].exit_code, 0) << results[0].err;
        EXPECT_EQ(results[1].exit_code, 5) << results[1].err;
        EXPECT_TRUE(found("^fluovox: error: " + name +
                              ".planes: another run is at work on this stack: wait until it ends, stop it \\(what it "
                              "has finished is kept\\), or choose another -o\n$",
                          results[1].err));
        EXPECT_FALSE(fs::exists(folder() / (name + ".planes")));
    }
    ASSERT_EQ(run({"render", "scene.toml", "-o", "alone.ome.tif"}).exit_code, 0);
    EXPECT_TRUE(read("stack.ome.tif") == read("alone.ome.tif"));
}

TEST_F(ConcurrentTest, AKilledRunIsNoneAndTheNextGoesOn) {
    const std::vector<std::string> command = {"render", "scene.toml", "-o", "stack.ome.tif"};
    RunLimits limits;
    limits.signal_when = [&] { return fs::exists(folder() / "stack.ome.tif.planes/00001.plane"); };
    ASSERT_EQ(run(command, limits).exit_code, 128 + SIGKILL);
    const ProgramResult next = run(command);
    EXPECT_EQ(next.exit_code, 0) << next.err;
    EXPECT_TRUE(found("[2-4] of 5 planes are there already", next.err));
    EXPECT_EQ(files(),
              (std::vector<std::string>{"image.toml", "scene.toml", "stack.apng", "stack.ome.tif", "stack.png"}));
}

// A single image is written under another name and takes its place in one step, so the last one stays, whole.
TEST_F(ConcurrentTest, TwoRunsOnOneImageDoEachOtherNoHarm) {
    const std::vector<std::string> command = {"render", "image.toml", "-o", "image.exr", "--samples", "4000"};
    ASSERT_EQ(run({"render", "image.toml", "-o", "alone.exr", "--samples", "4000"}).exit_code, 0);
    // The scene is there from the start: the second run begins with the first and ends during it.
    const auto results = run_beside(command, "image.toml", {"render", "image.toml", "-o", "image.exr", "--seed", "2"});
    EXPECT_EQ(results[0].exit_code, 0) << results[0].err;
    EXPECT_EQ(results[1].exit_code, 0) << results[1].err;
    EXPECT_TRUE(read("image.exr") == read("alone.exr"));
    EXPECT_EQ(files(), (std::vector<std::string>{"alone.exr", "alone.png", "image.exr", "image.png", "image.toml",
                                                 "scene.toml"}));
}

}  // namespace
}  // namespace fluovox::testing
