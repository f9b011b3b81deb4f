#include "fluovox/image/stack_file.h"

#include "cli/run_program.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

const std::string kScene = R"([[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { box = { min = ["-50 um", "-50 um", "-50 um"], max = ["50 um", "50 um", "50 um"] } }
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
field      = "60 um"
resolution = [6, 5]
numerical_aperture = 0.3
[[film.channel]]
name = "green"
band = { center = "525 nm", width = "50 nm" }
[stack]
along = [0, 0, 1]
start = "0 um"
stop  = "2 um"
step  = "1 um"
[render]
samples = 200
)";

class SensorTest : public ProgramTest {
protected:
    SensorTest() {
        write("scene.toml", kScene);
        EXPECT_EQ(run({"render", "scene.toml", "-o", "stack.ome.tif", "-q"}).exit_code, 0);
    }
};

TEST_F(SensorTest, OneRenderGivesManyRealisationsEachTheSameEveryTime) {
    expect_rows({
        {"a preset",
         {"sensor", "stack.ome.tif", "-o", "a.ome.tif", "--camera", "scmos", "--exposure", "1us"},
         0,
         "^$",
         "^a.ome.tif\n$"},
        {"the same",
         {"sensor", "stack.ome.tif", "-o", "b.ome.tif", "--camera", "scmos", "--exposure", "1us", "--threads", "1"}},
        {"another",
         {"sensor", "stack.ome.tif", "-o", "c.ome.tif", "--camera", "scmos", "--exposure", "1us", "--seed", "2"}},
        {"for ImageJ",
         {"sensor", "stack.ome.tif", "-o", "a.tif", "--camera", "emccd", "--exposure", "1us", "--format", "imagej"}},
        {"as Zarr", {"sensor", "stack.ome.tif", "-o", "a.ome.zarr", "--camera", "ideal", "--exposure", "1us"}},
    });
    EXPECT_TRUE(read("a.ome.tif") == read("b.ome.tif"));
    EXPECT_FALSE(read("a.ome.tif") == read("c.ome.tif"));
}

TEST_F(SensorTest, ACameraFileSaysItsOwnNumbersAndComplaintsNameThePlace) {
    write("camera.toml", "preset = \"scmos\"\nquantum_efficiency = \"qe.csv\"\nbits = 12\nexposure = \"1 ms\"\n");
    write("qe.csv", "wavelength_nm,efficiency\n400,0.5\n700,0.9\n");
    write("bad.toml", "preset = \"scmos\"\nbits = 17\n");
    write("typo.toml", "gian = 2\n");
    expect_rows({
        {"a file", {"sensor", "stack.ome.tif", "-o", "a.ome.tif", "--camera", "camera.toml"}},
        {"saturation is told",
         {"sensor", "stack.ome.tif", "-o", "a.ome.tif", "--camera", "camera.toml", "--exposure", "100s"},
         0,
         "warning: .* % of the pixels are saturated \\(full well 30000 electrons, 12 bits\\): lower the exposure from "
         "100 s to about "},
        {"out of range",
         {"sensor", "stack.ome.tif", "-o", "b.ome.tif", "--camera", "bad.toml"},
         3,
         "bad.toml:2:8: error: bits = 17 must be 16 or less"},
        {"unknown key",
         {"sensor", "stack.ome.tif", "-o", "b.ome.tif", "--camera", "typo.toml"},
         3,
         "did you mean \"gain\""},
        {"no exposure", {"sensor", "stack.ome.tif", "-o", "b.ome.tif", "--camera", "scmos"}, 2, "--exposure 20ms"},
        {"no such camera",
         {"sensor", "stack.ome.tif", "-o", "b.ome.tif", "--camera", "scmoss"},
         2,
         "neither a file nor one of: ideal, scmos, emccd"},
        {"no stack of ours",
         {"sensor", "qe.csv", "-o", "b.ome.tif", "--camera", "scmos"},
         4,
         "qe.csv: is no stack that can be read: those are an OME-TIFF, an ImageJ TIFF, an OME-Zarr folder or planes of "
         ".exr"},
        {"missing", {"sensor", "none.ome.tif", "-o", "b.ome.tif", "--camera", "scmos"}, 4, "there is no such file"},
        {"a sensor's output is no radiance",
         {"sensor", "a.ome.tif", "-o", "b.ome.tif", "--camera", "scmos"},
         4,
         "says nothing about photons"},
    });
}

/// Every value of a stack, page by page.
std::vector<float> values_of(const std::filesystem::path& path) {
    StackFile file(path);
    const StackInfo& info = file.info();
    std::vector<float> all;
    std::vector<float> page(info.pixels());
    for (int plane = 0; plane < info.planes; ++plane) {
        for (int channel = 0; channel < static_cast<int>(info.channels.size()); ++channel) {
            file.read(plane, channel, page);
            all.insert(all.end(), page.begin(), page.end());
        }
    }
    return all;
}

TEST_F(SensorTest, TheSameLightGivesTheSameCountsWhateverFormatTheStackHas) {
    for (const char* name : {"z.ome.zarr", "e.exr"})
        ASSERT_EQ(run({"render", "scene.toml", "-o", name, "-q"}).exit_code, 0) << name;
    ASSERT_EQ(run({"render", "scene.toml", "-o", "j.tif", "-q", "--format", "imagej"}).exit_code, 0);
    const auto noisy = [](const std::string& stack, const std::string& output) {
        return CommandRow{stack, {"sensor", stack, "-o", output, "--camera", "scmos", "--exposure", "1us"}};
    };
    expect_rows({noisy("stack.ome.tif", "t.ome.tif"), noisy("z.ome.zarr", "z.ome.tif"), noisy("e.exr", "e.ome.tif"),
                 noisy("e-0001.exr", "e1.ome.tif"), noisy("j.tif", "j.ome.tif"), noisy("z.ome.zarr/", "zz.ome.zarr")});
    const std::vector<float> counts = values_of(folder() / "t.ome.tif");
    ASSERT_EQ(counts.size(), 6U * 5U * 3U);
    EXPECT_GT(*std::max_element(counts.begin(), counts.end()), 110);
    for (const char* name : {"z.ome.tif", "e.ome.tif", "e1.ome.tif", "j.ome.tif", "zz.ome.zarr"})
        EXPECT_EQ(values_of(folder() / name), counts) << name;
    // What the files say of the stack is the same as well, except of the work they are the end of.
    const StackInfo seen = StackFile(folder() / "e.ome.tif").info();
    const StackInfo first = StackFile(folder() / "t.ome.tif").info();
    EXPECT_EQ(seen.quantity, first.quantity);
    EXPECT_EQ(seen.scene_json, first.scene_json);
    EXPECT_EQ(seen.channels.at(0).excitation_nm, 488);
    EXPECT_EQ(seen.positions_um.at(2).z, first.positions_um.at(2).z);
}

TEST_F(SensorTest, WhatIsNoWholeStackIsNamed) {
    for (const char* name : {"z.ome.zarr", "e.exr"})
        ASSERT_EQ(run({"render", "scene.toml", "-o", name, "-q"}).exit_code, 0) << name;
    write("image.toml", kScene.substr(0, kScene.find("[stack]")) + "[render]\nsamples = 2\n");
    ASSERT_EQ(run({"render", "image.toml", "-o", "image.exr", "-q"}).exit_code, 0);
    std::filesystem::copy(folder() / "e-0000.exr", folder() / "other-0000.exr");
    std::filesystem::copy(folder() / "e-0002.exr", folder() / "other-0001.exr");
    std::filesystem::remove(folder() / "e-0002.exr");
    std::filesystem::create_directories(folder() / "empty.ome.zarr");
    std::filesystem::remove(folder() / "z.ome.zarr/0/0/1/0/0");
    const auto row = [](const std::string& stack, const std::string& err) {
        return CommandRow{stack,
                          {"sensor", stack, "-o", "b.ome.tif", "--camera", "scmos", "--exposure", "1us"},
                          4,
                          err,
                          {},
                          {},
                          {"b.ome.tif"}};
    };
    expect_rows({
        row("e.exr", "e-0002.exr: there is no such file"),
        row("other.exr", "other-0001.exr: is another plane of its stack than its name says"),
        row("image.exr", "image.exr: is no stack that can be read: those are"),
        row("nothing.exr", "nothing.exr: there is no such file"),
        row("empty.ome.zarr", "empty.ome.zarr: is a folder, but no OME-Zarr: what can be read is an OME-TIFF"),
        row("z.ome.zarr", "z.ome.zarr/0/0/1/0/0: is missing: the stack is not whole"),
    });
}

}  // namespace
}  // namespace fluovox::testing
