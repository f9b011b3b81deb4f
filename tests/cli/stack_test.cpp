// What stacks hold and how others read them.

#include "fluovox/image/stack_file.h"

#include "cli/stack_fixture.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <numeric>
#include <regex>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

namespace fs = std::filesystem;

TEST_F(StackTest, WritesAStackItsProjectionAndAnAnimationAndNothingElse) {
    expect_rows({{"names on stdout",
                  {"render", "scene.toml", "-o", "stack.ome.tif"},
                  0,
                  "7 planes of 14 x 12 pixels, 2 channels, 16 samples each, estimator path.*\nOpen with Fiji",
                  "^stack.ome.tif\nstack.png\nstack.apng\n$"},
                 {"a second run keeps the finished one",
                  {"render", "scene.toml", "-o", "stack.ome.tif"},
                  0,
                  "stack.ome.tif is finished already",
                  "^stack.ome.tif\n"},
                 {"an image of another scene takes its place",
                  {"render", "scene.toml", "-o", "stack.ome.tif", "--seed", "2"},
                  0,
                  "7 planes"}});
    EXPECT_EQ(files(), (std::vector<std::string>{"scene.toml", "stack.apng", "stack.ome.tif", "stack.png"}));
    const auto json = nlohmann::json::parse(run({"render", "scene.toml", "-o", "j.ome.tif", "--json"}).out);
    EXPECT_EQ(json.at("planes").size(), 7U);
    EXPECT_EQ(json.at("planes").at(2).at("offset_um"), -10.0);
    EXPECT_GT(json.at("bright_relative_error"), 0.0);
}

TEST_F(StackTest, IndependentReadersSeeSizesChannelsAndTheSameValuesInEveryFormat) {
    if (!has_readers()) GTEST_SKIP() << "python3 or xmllint is not installed";
    for (const std::vector<std::string>& more : {std::vector<std::string>{"a.ome.tif"},
                                                 {"c.ome.tif", "--type", "uint16"},
                                                 {"j.tif", "--format", "imagej"},
                                                 {"k.tif", "--format", "imagej", "--type", "uint16"},
                                                 {"z.ome.zarr"}}) {
        std::vector<std::string> arguments = {"render", "scene.toml", "-o"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        ASSERT_EQ(run(arguments).exit_code, 0) << more.front();
    }
    const std::string seen = python("a.ome.tif c.ome.tif j.tif k.tif z.ome.zarr");
    EXPECT_TRUE(found(R"(a.ome.tif ome classic ZCYX float32 \[7, 2, 12, 14\])", seen));
    EXPECT_TRUE(found(R"(c.ome.tif ome classic ZCYX uint16 \[7, 2, 12, 14\])", seen));
    const std::string sizes = R"(\{'unit': 'um', 'spacing': 10, 'slices': 7, 'channels': 2\})";
    EXPECT_TRUE(found("j.tif imagej classic ZCYX " + sizes + R"( float32 \[7, 2, 12, 14\])", seen));
    EXPECT_TRUE(found("k.tif imagej classic ZCYX " + sizes + R"( uint16 \[7, 2, 12, 14\])", seen));
    EXPECT_TRUE(found(
        R"(z.ome.zarr 0.4 czyx \[\[2, 7, 12, 14\]\] \[1.0, 10.0, 12.0, 12.0\] \[0.0, -30.0, -66.0, -78.0\] \['green', 'red'\] float32)",
        seen));
    shell(R"py(/usr/bin/python3 -c "
import numpy as np
a, c, j, k, z = (np.load(n + '.npy') for n in ('a.ome.tif', 'c.ome.tif', 'j.tif', 'k.tif', 'z.ome.zarr'))
assert a.max() > 0 and (a == j).all() and (a == z).all()
assert (c == k).all() and c.max() == 65535 and abs(c * a.max() / 65535 - a).max() <= a.max() / 65535
assert a[3, 0].max() > 3 * a[0, 1].max() and a[4, 1].max() > 0")py");
    const std::string xml = read("a.ome.tif.xml");
    for (const char* part :
         {"PhysicalSizeX=\"12\"", "PhysicalSizeZ=\"10\"", "AcquisitionMode=\"SPIM\"", "LensNA=\"0.3\"",
          "Fluor=\"EGFP\" ExcitationWavelength=\"488\"", "Fluor=\"mCherry\" ExcitationWavelength=\"561\"",
          "EmissionWavelength=\"610\"", "PositionZ=\"-20\"", "ExposureTime=\"0.02\"", "&quot;anisotropy&quot;"}) {
        EXPECT_NE(xml.find(part), std::string::npos) << part;
    }
    const fs::path schema = fs::path(FLUOVOX_SHARED_DIR) / "reference" / "ome.xsd";
    if (!fs::exists(schema)) GTEST_SKIP() << "no " << schema << ": the XML was not validated";
    EXPECT_TRUE(found("a.ome.tif.xml validates",
                      shell("xmllint --nonet --noout --schema '" + schema.string() + "' a.ome.tif.xml")));
}

TEST_F(StackTest, PlainImageJSeesTheHyperstack) {
    if (!has_imagej()) GTEST_SKIP() << "ImageJ (libij-java, bsh, a Java runtime) is not installed";
    if (!has_readers()) GTEST_SKIP() << "python3 is not installed";
    for (const char* type : {"float32", "uint16"}) {
        const std::string file = std::string(type) + ".tif";
        ASSERT_EQ(run({"render", "scene.toml", "-o", file, "--format", "imagej", "--type", type}).exit_code, 0);
        const std::string seen = imagej(file);
        EXPECT_TRUE(found("14 x 12, 2 channels, 7 slices, 1 frames, (32|16) bits, hyperstack true\n", seen));
        EXPECT_TRUE(found("voxel 12.0 12.0 10.0\n", seen));
        python(file);
        std::ofstream(folder() / "seen.txt") << seen;
        shell("/usr/bin/python3 -c \"\nimport numpy as np\na = np.load('" + file +
              ".npy')\nseen = [float(l.split()[1]) for l in open('seen.txt').readlines()[2:16]]\n"
              "assert len(seen) == 14 and (abs(a.max(axis=(2, 3)).ravel() - seen) <= 1e-6 * a.max()).all(), seen\"");
    }
}

TEST_F(StackTest, PlainImageJShowsEveryChannelAndLabelAtOnce) {
    if (!has_imagej()) GTEST_SKIP() << "ImageJ (libij-java, bsh, a Java runtime) is not installed";
    const std::vector<std::string> render = {"render", "scene.toml", "-o", "s.tif", "--format", "imagej", "--truth"};
    const auto with = [&](std::vector<std::string> more) {
        std::vector<std::string> all = render;
        all.insert(all.end(), more.begin(), more.end());
        return run(all).exit_code;
    };
    for (const char* type : {"float32", "uint16"}) {
        ASSERT_EQ(with({"labels,concentration", "--type", type, "--overwrite"}), 0);
        EXPECT_TRUE(found("shown labels 0.0 2.0 ffffffff\n$", imagej("s-labels.tif")));
        EXPECT_TRUE(found("shown EGFP 0.0 10.0 [0-9a-f]*\nshown mCherry 0.0 10.0 ", imagej("s-concentration.tif")));
        // The red ball is dimmer than the green one, and is shown as bright.
        const std::string seen = imagej("s.tif");
        std::smatch high;
        const std::regex shown(R"(shown green 0.0 ([0-9.]+) ff00ff[0-9a-f]*\nshown red 0.0 ([0-9.]+) ffff00)");
        ASSERT_TRUE(std::regex_search(seen, high, shown)) << seen;
        EXPECT_GT(std::stod(high[1]), 2 * std::stod(high[2]));
        EXPECT_GT(std::stod(high[2]), 0);
        EXPECT_LE(std::stod(high[1]), 65535);
    }
}

TEST_F(StackTest, TheSameBytesForAnyNumberOfThreadsAndOneExrForEachPlane) {
    ASSERT_EQ(run({"render", "scene.toml", "-o", "one.exr", "--threads", "1"}).exit_code, 0);
    ASSERT_EQ(run({"render", "scene.toml", "-o", "two.exr", "--threads", "2"}).exit_code, 0);
    for (int plane = 0; plane < 7; ++plane) {
        const std::string end = "-000" + std::to_string(plane) + ".exr";
        EXPECT_TRUE(read("one" + end) == read("two" + end)) << end;
    }
    EXPECT_NE(read("one-0000.exr"), read("one-0001.exr"));
}

TEST_F(StackTest, ViewsTurnCameraAndSheetsTogether) {
    // Half a turn about y: the second ball changes sides in the image, and the depth it is sharp at changes sign.
    write_changed(
        "views.toml", "[stack]\n",
        "[stack]\nviews = { axis = [0, 1, 0], center = [\"0 um\", \"0 um\", \"0 um\"], angles_deg = [0, 180] }\n");
    const ProgramResult result = run({"render", "views.toml", "-o", "turn.ome.tif", "--samples", "200"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out,
              "turn-view000.ome.tif\nturn-view000.png\nturn-view000.apng\n"
              "turn-view180.ome.tif\nturn-view180.png\nturn-view180.apng\n");
    if (!has_readers()) GTEST_SKIP() << "python3 is not installed";
    python("turn-view000.ome.tif turn-view180.ome.tif");
    shell(R"py(/usr/bin/python3 -c "
import numpy as np
a, b = (np.load('turn-view%s.ome.tif.npy' % n)[:, 1] for n in ('000', '180'))
z, y, x = (np.indices(a.shape)[i] for i in range(3))
def centre(s): return [(s * i).sum() / s.sum() for i in (z, y, x)]
ca, cb = centre(a), centre(b)
assert ca[2] > 8 and cb[2] < 5 and abs(ca[1] - cb[1]) < 0.5, (ca, cb)
assert ca[0] > 3.2 and cb[0] < 2.8, (ca, cb)")py");
}

TEST_F(StackTest, GroundTruthHasTheStacksPixelsAndTheScenesNumbers) {
    const ProgramResult result = run({"render", "scene.toml", "-o", "s.ome.tif", "--truth", "all"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out,
              "s.ome.tif\ns-labels.ome.tif\ns-concentration.ome.tif\ns-irradiance.ome.tif\ns-photons.ome.tif\n"
              "s.png\ns.apng\n");
    EXPECT_EQ(run({"render", "scene.toml", "-o", "s.ome.tif", "--truth", "all"}).out, result.out);
    ASSERT_EQ(run({"render", "scene.toml", "-o", "z.ome.zarr", "--truth", "labels"}).exit_code, 0);
    expect_rows({
        {"the labels are a segmentation whose voxels say their size",
         {"voxelize", "s-labels.ome.tif", "-o", "back.vdb", "--label", "1=EGFP:5uM"},
         0,
         "^$",
         "back.vdb: EGFP [0-9]+ voxels"},
        {"which stays", {"info", "back.vdb"}, 0, "^$", "voxel size +12 x 12 x 10 um"},
    });
    if (!has_readers()) GTEST_SKIP() << "python3 is not installed";
    const std::string seen = python(
        "s.ome.tif s-labels.ome.tif s-concentration.ome.tif s-photons.ome.tif "
        "s-irradiance.ome.tif");
    EXPECT_TRUE(found(R"(s-labels.ome.tif ome classic ZYX uint16 \[7, 12, 14\])", seen));
    for (const char* name : {"labels", "concentration", "photons", "irradiance"})
        EXPECT_TRUE(
            found("PhysicalSizeX=\"12\".*PhysicalSizeZ=\"10\"", read("s-" + std::string(name) + ".ome.tif.xml")));
    // The balls: radii 30 and 20 um. The sheet: 1 mW over 300 um x a Gaussian of sigma 1.25 um, after the host's 1 mm
    // to 0.1 mm of scattering at 2 /mm. Photons: radiance x pi 0.3^2 x (12 um)^2 x 20 ms over the energy of one.
    shell(R"py(/usr/bin/python3 -c "
import numpy as np, zarr
s, l, c, p, e = (np.load('s%s.ome.tif.npy' % n) for n in ('', '-labels', '-concentration', '-photons', '-irradiance'))
z = zarr.open('z.ome.zarr', 'r')
assert (z['labels/labels/0'][0] == l).all() and z['labels'].attrs['labels'] == ['labels']
assert set(np.unique(l)) == {0, 1, 2} and l[3, 5, 6] == 1 and l[4, 4, 10] == 2
for i, r in ((0, 30), (1, 20)):
    volume = c[:, i].sum() / 10 * 12 * 12 * 10
    assert abs(volume / (4 / 3 * np.pi * r**3) - 1) < 0.06, (i, volume)
    assert abs((l == i + 1).sum() * 1440 / (4 / 3 * np.pi * r**3) - 1) < 0.2
factor = np.pi * 0.09 * 144e-12 * 0.02 / (6.62607015e-34 * 299792458 / np.array([525e-9, 610e-9]))
for i in (0, 1):  # the dyes' light does not lie in the middle of the bands
    ratio = (p[:, i] / (s[:, i] * factor[i]))[s[:, i] > 0]
    assert abs(ratio.mean() - 1) < 0.015 and ratio.max() / ratio.min() < 1.00001, (i, ratio.mean())
peak = 1e-3 / 0.3 / (1.25e-3 * np.sqrt(2 * np.pi))
x = (np.arange(14) - 6.5) * 12
assert np.allclose(e[0, 0, 0], peak * np.exp(-2 * np.clip(0.1 + x / 1000, 0, None)), rtol=0.02), e[0, 0, 0]
assert (e[3, 0, 5, 8:10] < e[0, 0, 5, 8:10]).all()")py");
}

// A wide channel's middle is far from where the dye shines: by the energy of its photons, not of the middle's.
TEST_F(StackTest, WattsBecomeAsManyPhotonsAsCountingThemGives) {
    std::string wide = kStackScene;
    const std::string band = "band = { center = \"525 nm\", width = \"50 nm\" }";
    wide.replace(wide.find(band), band.size(), "band = { from = \"495 nm\", to = \"800 nm\" }");
    write("wide.toml", wide);
    const auto photons = [&](const std::string& unit) {
        const std::string name = unit + ".ome.tif";
        const ProgramResult result =
            run({"render", "wide.toml", "-o", name, "--truth", "photons", "--set", "film.unit=" + unit, "--layer",
                 "fluorescence", "--set", "medium.1.concentration=\"1 pM\"", "--set", "stack.start=\"0 um\"", "--set",
                 "stack.stop=\"0 um\"", "--samples", "64"});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        StackFile stack(folder() / (unit + "-photons.ome.tif"));
        std::vector<float> page(stack.info().pixels());
        stack.read(0, 0, page);
        return std::accumulate(page.begin(), page.end(), 0.0);
    };
    const double ratio = photons("watts") / photons("photons");
    EXPECT_NEAR(ratio, 1, 0.01);  // 650 nm, the middle, would give 1.25
}

TEST_F(StackTest, IrradianceOfASheetFromBothSidesIsOneChannelOfBothTogether) {
    write_changed("one.toml", "thickness  = \"5 um\"",
                  "waist = [\"0 um\", \"0 um\", \"0 um\"]\nthickness  = \"5 um\"\n"
                  "numerical_aperture = 0.1");
    write_changed("both.toml", "thickness  = \"5 um\"",
                  "waist = [\"0 um\", \"0 um\", \"0 um\"]\nthickness  = \"5 um\"\nnumerical_aperture = 0.1\n"
                  "two_sided = true\npivot_deg = [-2, 0, 2]");
    for (const std::string name : {"one", "both"}) {
        const ProgramResult result =
            run({"render", name + ".toml", "-o", name + ".ome.tif", "--truth", "irradiance", "--samples", "1"});
        ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    if (!has_readers()) GTEST_SKIP() << "python3 is not installed";
    EXPECT_TRUE(found(R"(both-irradiance.ome.tif ome classic ZCYX float32 \[7, 2, 12, 14\])",
                      python("one-irradiance.ome.tif both-irradiance.ome.tif")));
    EXPECT_TRUE(found("Name=\"light 1 \\(488 nm\\)\"[\\s\\S]*Name=\"light 2 \\(561 nm\\)\"",
                      read("both-irradiance.ome.tif.xml")));
    // From both sides the light is as strong as from one in the middle, and the same on both sides of it.
    shell(R"py(/usr/bin/python3 -c "
import numpy as np
one, both = (np.load(n + '-irradiance.ome.tif.npy')[3, 0].mean(axis=0) for n in ('one', 'both'))
assert abs(both[6:8].mean() / one[6:8].mean() - 1) < 0.1, (one, both)
assert np.allclose(both, both[::-1], rtol=0.1), both
assert one[2] > 1.05 * one[-3], one")py");
}

TEST_F(StackTest, InfoTellsWhatAStackOrAPlaneIsAndGivesItsSceneBack) {
    ASSERT_EQ(run({"render", "scene.toml", "-o", "s.ome.tif", "--samples", "2"}).exit_code, 0);
    ASSERT_EQ(run({"render", "scene.toml", "-o", "s.ome.zarr", "--samples", "2"}).exit_code, 0);
    ASSERT_EQ(run({"render", "scene.toml", "-o", "s.exr", "--samples", "2"}).exit_code, 0);
    const std::string scene = run({"check", "scene.toml", "--print", "--set", "render.samples=2"}).out;
    for (const char* name : {"s.ome.tif", "s.ome.zarr", "s.exr"})
        EXPECT_EQ(run({"info", name, "--scene"}).out, scene) << name;
    expect_rows({
        {"a stack",
         {"info", "s.ome.tif"},
         0,
         "^$",
         "7 planes of 14 x 12 pixels[\\s\\S]*12 x 12 x 10 um[\\s\\S]*green, EGFP, excited at 488 nm, seen at 525 "
         "nm[\\s\\S]*radiance in W"},
        {"a plane",
         {"info", "s-0003.exr"},
         0,
         "^$",
         "14 x 12 pixels[\\s\\S]*estimator path, 2 samples per pixel, seed"},
        {"a preview of an image", {"info", "s-0003.exr", "--preview", "p.png"}, 2, "--preview draws grids"},
        {"the scene of a grid", {"info", "s.vdb", "--scene"}, 2, "--scene is of images and stacks"},
        {"no such stack", {"info", "t.ome.tif"}, 4, "t.ome.tif: there is no such file"},
        {"no image", {"info", "scene.exr"}, 4, "scene.exr: "},
    });
    const auto image = nlohmann::json::parse(run({"info", "s-0003.exr", "--json"}).out);
    EXPECT_EQ(image.at("samples"), 2);
    EXPECT_TRUE(image.at("scene").at("stack").is_null()) << "a plane is an image with its own seed";
    EXPECT_EQ(image.at("scene").at("film"), nlohmann::json::parse(scene).at("film"));
    const auto stack = nlohmann::json::parse(run({"info", "s.ome.zarr", "--json"}).out);
    EXPECT_EQ(stack.at("stack").at("size"), nlohmann::json({14, 12, 7}));
    EXPECT_EQ(stack.at("scene"), nlohmann::json::parse(scene));
}

// By the camera that volumes/voxelizing/README.md names for it. Values between voxels are trilinear, so that a pixel
// holds about half of its own voxel.
TEST_F(StackTest, ASegmentationIsSeenTheWayItIsStored) {
    const std::vector<int> labels = {1, 0, 0, 0, 2, 0, 0, 1, 0, 0, 0, 0,  // rows of four, three of them a slice
                                     0, 0, 0, 0, 0, 2, 0, 0, 1, 1, 0, 2};
    std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: text\n\n";
    for (const int label : labels)
        nrrd += std::to_string(label) + ' ';
    write("labels.nrrd", nrrd);
    ASSERT_EQ(run({"voxelize", "labels.nrrd", "-o", "labels.vdb", "--voxel-size", "1um", "--label", "1=EGFP:5uM",
                   "--label", "2=mCherry:5uM"})
                  .exit_code,
              0);
    write("seen.toml", R"([[medium]]
dye  = "EGFP"
grid = { file = "labels.vdb" }
[[medium]]
dye  = "mCherry"
grid = { file = "labels.vdb" }
[[light]]
kind       = "uniform"
wavelength = "488 nm"
radiance   = "1 W/m2/sr"
[camera]
position   = ["2 um", "1.5 um", "-50 um"]
target     = ["2 um", "1.5 um", "1 um"]
up         = [0, -1, 0]
field      = "3 um"
resolution = [4, 3]
[film]
spectrum = { from = "500 nm", to = "520 nm", bins = 1 }
[stack]
along = [0, 0, 1]
start = "-0.5 um"
stop  = "0.5 um"
step  = "1 um"
)");
    const ProgramResult result =
        run({"render", "seen.toml", "-o", "seen.ome.tif", "--samples", "1", "--truth", "concentration"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    StackFile truth(folder() / "seen-concentration.ome.tif");
    std::vector<float> page(12);
    for (int plane = 0; plane < 2; ++plane) {
        for (int channel = 0; channel < 2; ++channel) {
            truth.read(plane, channel, page);
            for (std::size_t i = 0; i < page.size(); ++i) {
                const bool inside = labels[static_cast<std::size_t>(plane) * 12 + i] == channel + 1;
                EXPECT_EQ(page[i] > 1.5F, inside) << "plane " << plane << ", channel " << channel << ", pixel " << i;
            }
        }
    }
}

TEST_F(StackTest, TheErrorOfOneSamplePerPixelIsUnknown) {
    const auto json =
        nlohmann::json::parse(run({"render", "scene.toml", "-o", "j.ome.tif", "--samples", "1", "--json"}).out);
    EXPECT_TRUE(json.at("median_relative_error").is_null()) << json;
    EXPECT_TRUE(json.at("planes").at(3).at("bright_relative_error").is_null());
    expect_rows({{"of a stack",
                  {"render", "scene.toml", "-o", "s.ome.tif", "--samples", "1"},
                  0,
                  "median relative error unknown \\(one sample per pixel\\), in the brightest tenth unknown"},
                 {"with two it is known",
                  {"render", "scene.toml", "-o", "t.ome.tif", "--samples", "2"},
                  0,
                  "median relative error \\d.* %, in"}});
}

TEST_F(StackTest, BadInputIsNamedBeforeTheWorkBegins) {
    write_changed("step.toml", "\"10 um\"\n[render]", "\"0 um\"\n[render]");
    write_changed("stop.toml", "stop  = \"30 um\"", "stop  = \"-31 um\"");
    write_changed("miss.toml", "start = \"-30 um\"\nstop  = \"30 um\"", "start = \"60 um\"\nstop  = \"80 um\"");
    write_changed("dark.toml", "center = \"610 nm\"", "center = \"1200 nm\"");
    const std::size_t lights = kStackScene.find("[[light]]");
    write("uniform.toml", std::string(kStackScene)
                              .replace(lights, kStackScene.find("[camera]") - lights,
                                       "[[light]]\nkind = \"uniform\"\nwavelength = \"488 nm\"\n"
                                       "radiance = \"1 W/m2/sr\"\n"));
    write_changed("huge.toml", "[14, 12]", "[2048, 2048]");
    expect_rows({
        {"no step", {"render", "step.toml", "-o", "s.ome.tif"}, 3, "stack.step = \"0 um\" must be above 0"},
        {"backwards", {"render", "stop.toml", "-o", "s.ome.tif"}, 3, "stack.stop = \"-31 um\" must not be below start"},
        {"sheets beside the specimen, with the distance, once for those of both colours",
         {"render", "miss.toml", "-o", "miss.ome.tif"},
         0,
         "EGFP: the sheet misses it by 25 um in every plane[^\\n]*\\n(?![\\s\\S]*EGFP: the sheet)"},
        {"channel without light",
         {"render", "dark.toml", "-o", "dark.ome.tif"},
         0,
         "warning: channel \"red\": no dye emits and no light shines between 1175 and 1225 nm"},
        {"larger than the disk",
         {"render", "huge.toml", "-o", "huge.ome.tif", "--set", "stack.step=0.00061um"},
         5,
         "huge.ome.tif: the stack \\(98361 planes of 2048 x 2048 pixels, 2 channels\\) needs about \\S+ GB of disk "
         "and "
         "\\S+ GB are free",
         "",
         {},
         {"huge.ome.tif", "huge.ome.tif.planes"}},
        {"unknown layer", {"render", "scene.toml", "-o", "s.ome.tif", "--layer", "blue"}, 2, "total, elastic, fluor"},
        {"unknown type", {"render", "scene.toml", "-o", "s.ome.tif", "--type", "int8"}, 2, "float32 or uint16"},
        {"unknown format", {"render", "scene.toml", "-o", "s.ome.tif", "--format", "gif"}, 2, "--format is ome-tiff"},
        {"the ending says another format",
         {"render", "scene.toml", "-o", "s.ome.tif", "--format", "ome-zarr"},
         2,
         "--format ome-zarr contradicts -o s.ome.tif: end its name in .ome.zarr, or leave --format out",
         "",
         {},
         {"s.ome.tif", "s.ome.zarr"}},
        {"ImageJ's own is no OME-TIFF",
         {"render", "scene.toml", "-o", "s.ome.tif", "--format", "imagej"},
         2,
         "in .tif"},
        {"nor a stack a picture", {"render", "scene.toml", "-o", "s.png", "--format", "ome-tiff"}, 2, "in .ome.tif"},
        {"nor an image", {"render", "scene.toml", "-o", "s.exr", "--format", "ome-tiff"}, 2, "contradicts -o s.exr"},
        {"irradiance of light without a place",
         {"render", "uniform.toml", "-o", "u.ome.tif", "--truth", "irradiance"},
         2,
         "irradiance needs a \\[\\[light\\]\\] that has a place"},
        {"but all there is, of it",
         {"render", "uniform.toml", "-o", "u.ome.tif", "--truth", "all"},
         0,
         "warning: irradiance needs a",
         "u-photons.ome.tif",
         {},
         {"u-irradiance.ome.tif"}},
        {"unknown ending", {"render", "scene.toml", "-o", "s.jpg"}, 2, "also .ome.tif or .ome.zarr"},
    });
}

}  // namespace
}  // namespace fluovox::testing
