#include "cli/run_program.h"

#include <string>

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
         "qe.csv: is no TIFF file"},
        {"missing", {"sensor", "none.ome.tif", "-o", "b.ome.tif", "--camera", "scmos"}, 4, "there is no such file"},
        {"a sensor's output is no radiance",
         {"sensor", "a.ome.tif", "-o", "b.ome.tif", "--camera", "scmos"},
         4,
         "says nothing about photons"},
    });
}

}  // namespace
}  // namespace fluovox::testing
