#include "unit/scene/scene_fixture.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

namespace fluovox::testing {
namespace {

/// One mistake: `from` of the valid scene becomes `to`; the complaint stands at `at` (a piece of the new text) and
/// reads `message`.
struct Mistake {
    std::string from, to, at, message;
};

class SceneComplaints : public SceneTest {
protected:
    void expect(const std::vector<Mistake>& mistakes) const {
        for (const Mistake& mistake : mistakes) {
            const std::string text = with(kScene, mistake.from, mistake.to);
            const std::size_t at = text.find(mistake.at);
            ASSERT_NE(at, std::string::npos) << mistake.at;
            const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
            const std::size_t begin = text.rfind('\n', at) + 1;  // npos + 1 is 0
            const std::string place = fmt::format("3 scene.toml:{}:{}: error: ", line, at - begin + 1);
            const std::string said = complaint(text);
            EXPECT_EQ(said.substr(0, place.size()), place) << mistake.to << "\n" << said;
            EXPECT_NE(said.find(mistake.message), std::string::npos) << "wanted: " << mistake.message << "\n" << said;
        }
    }
};

TEST_F(SceneComplaints, UnitsAreNeededAndMustFit) {
    EXPECT_EQ(complaint("title = \"t\"\n[camera]\nposition = [\"0 um\", \"0 um\", \"1 mm\"]\n"
                        "target = [\"0 um\", \"0 um\", \"0 um\"]\nfocus = 6.5\n"),
              "3 scene.toml:5:9: error: camera.focus = 6.5 needs a unit, for example \"6.5 um\"");
    expect({
        {"field      = \"500 um\"", "field = 500", "500\n", "camera.field = 500 needs a unit, for example \"500 um\""},
        {"field      = \"500 um\"", "field = \"500\"", "\"500\"", "camera.field = 500 needs a unit"},
        {"field      = \"500 um\"", "field = \"1 mW\"", "\"1 mW\"\nres", "is a power, not a length (its units: um"},
        {"field      = \"500 um\"", "field = true", "true", "camera.field = true must be a length with its unit"},
        {"field      = \"500 um\"", "field = \"wide\"", "\"wide\"", "camera.field = \"wide\" is not a length"},
        {"\"488 nm\"", "488", "488", "light.0.wavelength = 488 needs a unit, for example \"488 nm\""},
        {"\"488 nm\"", "\"488 um\"", "\"488 um\"", "must lie from 100 nm to 20000 nm"},
        {"\"10 uM\"", "\"10 um\"", "\"10 um\"", "is a length, not a concentration"},
        {"\"20 /mm\"", "20", "20\nabs", "medium.2.scattering = 20 needs a unit, for example \"20 /mm\""},
        {"\"1 mW\"", "\"-1 mW\"", "\"-1 mW\"", "light.0.power = \"-1 mW\" must be above 0"},
        {"[\"-1 mm\", \"250 um\"", "[\"-1 mm\", 250", "250, ", "light.0.position.1 = 250 needs a unit"},
        {"unit = \"nM\"", "unit = \"nm\"", "\"nm\"", "medium.0.grid.unit = \"nm\" must be a unit of concentration"},
        {"\"8 nm\"", "\"8 uM\"", "\"8 uM\"", "must be a unit of length, for example \"um\""},
    });
}

TEST_F(SceneComplaints, MisspeltKeysNameTheOneMeant) {
    expect({
        {"field      =", "feild      =", "feild", "unknown key \"camera.feild\"; did you mean \"field\"?"},
        {"thickness  =", "thicknes   =", "thicknes ", "unknown key \"light.0.thicknes\"; did you mean \"thickness\"?"},
        {"[[light]]", "[[lights]]", "lights", "unknown key \"lights\"; did you mean \"light\"?"},
        {"samples   = 64", "sampels = 64", "sampels", "did you mean \"samples\"?"},
        {"bins = 28", "bin = 28", "bin ", "did you mean \"bins\"?"},
        {"scale = 2", "sclae = 2", "sclae", "unknown key \"medium.0.grid.sclae\"; did you mean \"scale\"?"},
        {"step  = \"2 um\"", "qqq = 1\nstep = \"2 um\"", "qqq",
         "unknown key \"stack.qqq\"; the keys here: along, start"},
        {"\"telecentric\"", "\"telecentrik\"", "\"telecentrik\"",
         "must be \"telecentric\" or \"perspective\"; did you mean"},
        {"\"sheet\"", "\"sheat\"", "\"sheat\"", "did you mean \"sheet\"?"},
        {"estimator = \"auto\"", "estimator = \"paht\"", "\"paht\"", "did you mean \"path\"?"},
    });
}

TEST_F(SceneComplaints, MissingKeysAreNamedAtTheirTable) {
    expect({
        {"field      = \"500 um\"\n", "", "[camera]", "camera.field is missing"},
        {"thickness  = \"5 um\"\n", "", "[[light]]", "light.0.thickness is missing"},
        {"power      = \"1 mW\"\n", "", "[[light]]", "light.0.power is missing"},
        {"kind       = \"sheet\"\n", "", "[[light]]", "light.0.kind is missing: sheet, beam"},
        {"wavelength = \"488 nm\"\n", "", "[[light]]", "light.0 needs either wavelength"},
        {"concentration = \"10 uM\"\n", "", "[[medium]]\ndye           ", "medium.1.concentration is missing"},
        {"region     = \"everywhere\"", "", "[[medium]]\nscat", "medium.2.region is missing"},
        {", bins = 28", "", "{ from = \"480", "film.spectrum.bins is missing"},
        {"spectrum = {", "per_dye = true\n# {", "[film]", "film needs either spectrum"},
    });
    EXPECT_NE(complaint("").find("camera is missing"), std::string::npos);
}

TEST_F(SceneComplaints, ValuesOutOfRangeNameTheRange) {
    expect({
        {"anisotropy = 0.9", "anisotropy = 1.2", "1.2", "it must lie from -1 to 1 (these not included)"},
        {"anisotropy = 0.9", "anisotropy = -1", "-1\nreg", "medium.2.anisotropy = -1 is out of range"},
        {"anisotropy = 0.9", "anisotropy = nan", "nan", "must be a finite number"},
        {"anisotropy = 0.9", "anisotropy = \"0.9\"", "\"0.9\"", "must be a plain number, without quotes"},
        {"\"10 uM\"", "\"-10 uM\"", "\"-10 uM\"", "medium.1.concentration = \"-10 uM\" must be 0 or more"},
        {"\"20 /mm\"", "\"-20 /mm\"", "\"-20 /mm\"", "medium.2.scattering = \"-20 /mm\" must be 0 or more"},
        {"\"0.02 /mm\"", "\"-1 /mm\"", "\"-1 /mm\"", "must be 0 or more"},
        {"scale = 2", "scale = -2", "-2 }", "medium.0.grid.scale = -2 must be 0 or more"},
        {"from = \"480 nm\"", "from = \"680 nm\"", "\"620 nm\"", "must be above film.spectrum.from = \"680 nm\""},
        {"bins = 28", "bins = 0", "0 }", "film.spectrum.bins = 0 must be 1 or more"},
        {"bins = 28", "bins = 100000000", "100000000", "must be 4096 or less"},
        {"bins = 28", "bins = 2.5", "2.5", "must be a whole number"},
        {"[256, 128]", "[-256, 128]", "-256", "camera.resolution.0 = -256 must be 1 or more"},
        {"[256, 128]", "[256, 0]", "0]\nnum", "camera.resolution.1 = 0 must be 1 or more"},
        {"[256, 128]", "[256]", "[256]", "must be a list of 2, for example [256, 256]"},
        {"[256, 128]", "[1000000, 1000000]", "[1000000", "larger than the memory"},
        {"samples   = 64", "samples = 0", "0\n", "render.samples = 0 must be 1 or more"},
        {"samples   = 64", "seed = -1", "-1\n", "render.seed = -1 must be 0 or more"},
        {"samples   = 64", "fluorescence_orders = -1", "-1\n", "must be 0 or more"},
        {"samples   = 64", "fluorescence_orders = \"al\"", "\"al\"", "must be a number or \"all\""},
        {"samples   = 64", "max_scatterings = -1", "-1\n", "must be 0 or more"},
        {"samples   = 64", "photons = 0", "0\n", "render.photons = 0 is out of range"},
        {"samples   = 64", "cache_voxel = \"0 um\"", "\"0 um\"", "must be above 0"},
        {"step  = \"2 um\"", "step = \"0 um\"", "\"0 um\"", "stack.step = \"0 um\" must be above 0"},
        {"step  = \"2 um\"", "step = \"1e-9 um\"", "\"1e-9 um\"", "at most 100000"},
        {"stop  = \"20 um\"", "stop = \"-30 um\"", "\"-30 um\"", "stack.stop = \"-30 um\" must not be below start"},
        {"numerical_aperture = 0.3", "numerical_aperture = 1.2", "1.2",
         "must be below 1, the highest refractive index"},
        {"numerical_aperture = 0.3", "numerical_aperture = -1", "-1\n", "must be 0 or more"},
        {"field      = \"500 um\"", "field = \"0 um\"", "\"0 um\"", "camera.field = \"0 um\" must be above 0"},
    });
}

TEST_F(SceneComplaints, GeometryMustMakeSense) {
    expect({
        {"direction  = [2, 0, 0]", "direction = [0, 0, 0]", "[0, 0, 0]",
         "light.0.direction = [0, 0, 0] has no direction"},
        {"normal     = [1, 0, 1]", "normal = [3, 0, 0]", "[3, 0, 0]", "must not be parallel to direction"},
        {"normal     = [1, 0, 1]", "normal = [\"1 um\", 0, 0]", "\"1 um\", 0",
         "light.0.normal.0 = \"1 um\" must be a plain number"},
        {"up         = [0, 1, 0]", "up = [0, 0, 1]", "[0, 0, 1]\nfield", "must not be parallel to the view"},
        {"target     = [\"250 um\", \"250 um\", \"250 um\"]", "target = [\"250 um\", \"250 um\", \"2 mm\"]",
         "[\"250 um\", \"250 um\", \"2 mm\"]\nup", "must differ from position"},
        {"max = [\"5 mm\"", "max = [\"-5 mm\"", "[\"-5 mm\", \"15 mm\"", "must be above min along x"},
        {"\"everywhere\"", "\"nowhere\"", "\"nowhere\"", "must be \"everywhere\" or one of"},
        {"\"everywhere\"", "{}", "{}", "must be \"everywhere\" or one of"},
        {"\"everywhere\"", "{ bx = {} }", "bx", "unknown key \"medium.2.region.bx\"; did you mean \"box\"?"},
        {"\"everywhere\"", "{ slab = { axis = \"z\" } }", "{ axis", "needs min or max"},
        {"\"everywhere\"", "{ slab = { axis = \"z\", min = \"1 um\", max = \"0 um\" } }", "\"0 um\"",
         "must be above min"},
        {"\"everywhere\"", "{ slab = { axis = \"w\", min = \"1 um\" } }", "\"w\"", "must be \"x\", \"y\" or \"z\""},
        {"\"everywhere\"", "{ sphere = { center = [\"0 um\", \"0 um\", \"0 um\"], radius = \"0 um\" } }",
         "\"0 um\" } }", "medium.2.region.sphere.radius = \"0 um\" must be above 0"},
        {"\"everywhere\"",
         "{ cylinder = { from = [\"0 um\", \"0 um\", \"0 um\"], to = [\"0 um\", \"0 um\", \"0 um\"], radius = \"1 um\" "
         "} }",
         "[\"0 um\", \"0 um\", \"0 um\"], radius", "must differ from from"},
    });
}

TEST_F(SceneComplaints, KeysThatExcludeEachOtherAreTold) {
    expect({
        {"anisotropy = 0.9", "concentration = \"1 uM\"", "\"1 uM\"", "does not belong to a host"},
        {"anisotropy = 0.9", "grid = { file = \"a.vdb\" }", "\"everywhere\"", "and grid exclude each other"},
        {"scattering = \"20 /mm\"\nabsorption = \"0.02 /mm\"\n", "", "[[medium]]\naniso",
         "is neither a dye nor a host"},
        {"region     = \"everywhere\"", "grid = { file = \"a.vdb\", unit = \"uM\" }", "\"uM\" }",
         "does not belong here"},
        {"region     = \"everywhere\"", "grid = { file = \"a.vdb\" }\nexclusive = true", "true",
         "property of a region"},
        {"region     = \"everywhere\"", "grid = \"a.vdb\"", "\"a.vdb\"",
         "must be a table, for example grid = { file = \"a.vdb\" }"},
        {"concentration = \"10 uM\"", "concentration = \"10 uM\"\nscattering = \"1 /mm\"", "\"1 /mm\"",
         "does not belong to a dye"},
        {"wavelength = \"488 nm\"", "wavelength = \"488 nm\"\nspectrum = { from = \"1 nm\", to = \"2 nm\" }",
         "[[light]]", "needs either wavelength"},
        {"thickness  = \"5 um\"", "thickness = \"5 um\"\nradius = \"1 um\"", "radius",
         "unknown key \"light.0.radius\""},
        {"thickness  = \"5 um\"", "thickness = \"5 um\"\nwaist = [\"1 um\", \"0 um\", \"0 um\"]", "[\"1 um\"",
         "does nothing to a collimated"},
        {"thickness  = \"5 um\"", "thickness = \"5 um\"\nprofile = \"box\"\nnumerical_aperture = 0.1", "\"box\"",
         "does not go with numerical_aperture"},
        {"field      = \"500 um\"", "field = \"500 um\"\nfov_deg = 30", "30", "belongs to a perspective camera"},
        {"[[light]]", "[light]", "[light]", "must be a list of tables, each written [[light]]"},
        {"spectrum = {", "channel = []\nspectrum = {", "[film]", "film needs either"},
        {"samples   = 64", "filter = {}", "{}", "needs either pass"},
        {"samples   = 64", "filter = { pass = [] }", "[] }", "needs a band or more"},
    });
    EXPECT_NE(complaint(with(kScene, "kind       = \"sheet\"", "kind = \"uniform\"")).find("it has radiance instead"),
              std::string::npos);
    EXPECT_NE(complaint(with(with(kScene, "anisotropy = 0.9", "name = \"a\""),
                             "concentration =", "name = \"a\"\nconcentration ="))
                  .find("is the name of an earlier medium"),
              std::string::npos);
}

TEST_F(SceneComplaints, UnknownDyesNameTheClosest) {
    expect({{"dye  = \"EGFP\"", "dye = \"EGPF\"", "\"EGPF\"", "EGFP"},
            {"dye  = \"EGFP\"", "dye = \"no such thing\"", "\"no such thing\"", "fluovox dyes"}});
    EXPECT_EQ(complaint(with(kScene, "dye  = \"EGFP\"", "dye = \"my.toml\"")).substr(0, 23), "4 scene.toml:3:7: mediu");
}

TEST_F(SceneComplaints, RegionsOfDifferentIndexMustNotOverlapInPart) {
    const auto two = [&](const std::string& second) {
        return complaint(
            with(kScene, "region     = \"everywhere\"",
                 "refractive_index = 1.4\nregion = { sphere = { center = [\"0 um\", \"0 um\", \"0 um\"], "
                 "radius = \"10 um\" } }\n[[medium]]\nrefractive_index = 1.5\nregion = { sphere = { center = "
                 "[\"0 um\", \"0 um\", \"0 um\"], " +
                     second + " } }"));
    };
    EXPECT_EQ(two("radius = \"5 um\""), "no complaint");
    EXPECT_NE(two("radius = \"10 um\"").find("\"host1\" and \"host2\" fill the same space, with different"),
              std::string::npos)
        << "which of the two holds?";
    EXPECT_EQ(
        complaint(with(kScene, "region     = \"everywhere\"",
                       "refractive_index = 1.4\nregion = { slab = { axis = \"z\", min = \"0 um\", max = \"10 um\" "
                       "} }\n[[medium]]\nrefractive_index = 1.5\nregion = { slab = { axis = \"z\", min = \"5 um\" } "
                       "}")),
        "3 scene.toml:17:1: error: \"host1\" and \"host2\" overlap in part, with different refractive indices (1.4 "
        "and 1.5); put one wholly inside the other, or let them only touch");
}

TEST_F(SceneComplaints, PhaseFunctionsThatAreNoneAreTold) {
    const auto phase = [&](const std::string& value) {
        return complaint(with(kScene, "anisotropy = 0.9", "phase_function = " + value));
    };
    const auto table = [&](const std::string& text) {
        write("phase.csv", text);
        return phase("{ file = \"phase.csv\" }");
    };
    const auto expect_says = [](const std::string& message, const std::string& what) {
        EXPECT_EQ(message.substr(0, 2), "3 ") << message;
        EXPECT_NE(message.find(what), std::string::npos) << message;
    };
    expect_says(phase("\"mie\""), "must be \"isotropic\", \"rayleigh\", { kind");
    expect_says(phase("{ kind = \"rayleih\" }"), "did you mean \"rayleigh\"?");
    expect_says(phase("{ kind = \"henyey-greenstein\", g = 1 }"), "it must lie from -1 to 1");
    expect_says(phase("{ kind = \"two-term-henyey-greenstein\", g1 = 0.9, g2 = -0.5, weight = 2 }"), "weight = 2");
    expect_says(phase("\"rayleigh\"\nanisotropy = 0.5"), "anisotropy = 0.5 does not go with phase_function");
    expect_says(table("angle_deg,value\n0,1\n90,-1\n180,1\n"), "phase.csv:3:1: error: the value -1 is negative");
    expect_says(table("angle_deg,value\n0,0\n180,0\n"), "cannot be normalised");
    expect_says(table("angle_deg,value\n5,1\n180,1\n"), "reaches from 5 to 180");
    expect_says(table("cosine,value\n-1,1\n0.5,1\n"), "reaches from -1 to 0.5");
    expect_says(table("cosine,value\n-1,1\n0.5,1\n0.4,1\n1,1\n"), "0.4 comes after 0.5");
    expect_says(table("angle_deg,value\n0,1\n200,1\n"), "200 must lie from 0 to 180 degrees");
    expect_says(table("0,1\n180,1\n"), "needs a first line that names the columns");
    expect_says(table("angle_deg,value\n0,1\n90,inf\n180,1\n"), "phase.csv:3");
    EXPECT_EQ(phase("{ file = \"missing.csv\" }").substr(0, 2), "4 ");
    EXPECT_EQ(table("angle_deg,value\n0,3\n60,1\n180,1\n"), "no complaint");
    EXPECT_EQ(phase("{ kind = \"two-term-henyey-greenstein\", g1 = 0.9, g2 = -0.5, weight = 0.9 }"), "no complaint");
    EXPECT_EQ(phase("\"rayleigh\""), "no complaint");
}

TEST_F(SceneComplaints, TablesPointAtTheirOwnLine) {
    const std::string scene =
        with(kScene, "wavelength = \"488 nm\"", "spectrum = { file = \"lamp.csv\", table_is = \"energy\" }");
    const std::string missing = complaint(scene);
    EXPECT_EQ(missing.substr(0, 2), "4 ");
    EXPECT_NE(missing.find("scene.toml:19:21: light.0.spectrum.file: lamp.csv"), std::string::npos) << missing;
    const auto said = [&](const std::string& csv) {
        write("lamp.csv", csv);
        return complaint(scene);
    };
    EXPECT_EQ(said("nm,power\n400,1\n500,-1\n"), "3 lamp.csv:3:1: error: the value -1 must be 0 or more");
    EXPECT_NE(said("nm,power\n500,1\n400,1\n").find("lamp.csv:3:1: error: the wavelength 400 comes after 500"),
              std::string::npos);
    EXPECT_NE(said("um,power\n0.5,1\n0.6,1\n").find("is not in nanometres"), std::string::npos);
    EXPECT_NE(said("400,1\n500,x\n").find("lamp.csv:2:5"), std::string::npos);
    EXPECT_NE(said("400,1,2\n500,1,2\n").find("3 columns where two are needed"), std::string::npos);
    EXPECT_NE(said("400,1\n").find("two rows or more"), std::string::npos);
    EXPECT_NE(said("400,0\n500,0\n").find("has no light in it"), std::string::npos);
    EXPECT_NE(said("").find("lamp.csv"), std::string::npos);
    write("lamp.csv", "400,1\n500,1\n");
    EXPECT_NE(complaint(with(scene, ", table_is = \"energy\"", "")).find("light.0.spectrum.table_is is missing"),
              std::string::npos);
}

TEST_F(SceneComplaints, ChannelsNeedAResponse) {
    write("filter.csv", "500,0\n520,100\n540,0\n");
    const auto said = [&](const std::string& channel) {
        return complaint(with(kScene, "spectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 }",
                              "[[film.channel]]\n" + channel));
    };
    EXPECT_NE(
        said("name = \"a\"\nfilter = \"filter.csv\"").find("filter.csv:2:1: error: the value 100 must lie from 0 to 1"),
        std::string::npos);
    EXPECT_NE(said("name = \"a\"").find("film.channel.0 needs either band"), std::string::npos);
    EXPECT_NE(said("band = { center = \"500 nm\", width = \"10 nm\" }").find("film.channel.0.name is missing"),
              std::string::npos);
    EXPECT_NE(said("name = \"a\"\nband = { center = \"500 nm\", from = \"450 nm\" }")
                  .find("does not go with center and width"),
              std::string::npos);
    write("qe.csv", "700,1\n800,1\n");
    EXPECT_NE(said("name = \"a\"\nefficiency = \"qe.csv\"\nband = { center = \"500 nm\", width = \"10 nm\" }")
                  .find("lets no light through"),
              std::string::npos);
}

TEST_F(SceneComplaints, OverridesAreNamedInsteadOfALine) {
    EXPECT_EQ(complaint(kScene, {"camera.focus=6.5"}),
              "3 --set camera.focus=6.5: error: camera.focus = 6.5 needs a unit, for example \"6.5 um\"");
    EXPECT_EQ(complaint(kScene, {"camera.feild=\"1 um\""}),
              "3 --set camera.feild=\"1 um\": error: unknown key \"camera.feild\"; did you mean \"field\"?");
    EXPECT_EQ(complaint(kScene, {"medium.7.scattering=1"}),
              "3 --set medium.7.scattering=1: error: \"7\" should be a number from 0 to 2: there are 3 entries");
    EXPECT_EQ(complaint(kScene, {"camera.kind.x=1"}),
              "3 --set camera.kind.x=1: error: nothing can be set at \"x\": what is before it is a plain value");
    EXPECT_EQ(complaint(kScene, {"camera.resolution=[64"}).substr(0, 34), "3 --set camera.resolution=[64: err");
    EXPECT_EQ(complaint(kScene, {"camera"}).substr(0, 23), "2 --set takes KEY=VALUE");
    EXPECT_EQ(complaint(kScene, {"=3"}).substr(0, 23), "2 --set takes KEY=VALUE");
}

TEST_F(SceneComplaints, WhatIsNoSceneIsSaidSo) {
    EXPECT_EQ(complaint(kScene.substr(0, kScene.find("bins"))).substr(0, 11), "3 scene.tom") << "cut off in a table";
    EXPECT_NE(complaint("field = 6.5 um\n").find("scene.toml:1:13: error: not a scene: "), std::string::npos);
    EXPECT_NE(complaint("field = 6.5 um\n").find("need quotes"), std::string::npos);
    EXPECT_NE(complaint("a = 1\na = 2\n")
                  .find("scene.toml:2:5: error: not a scene: error while parsing key-value pair: "
                        "cannot redefine existing integer 'a'"),
              std::string::npos);
    EXPECT_EQ(complaint(std::string("\x7f\x45\x4c\x46\x02\0\0\xff", 8)).substr(0, 13), "3 scene.toml:");
    EXPECT_EQ(complaint("x = " + std::string(100'000, '[')).substr(0, 13), "3 scene.toml:");
    EXPECT_EQ(complaint(std::string((std::size_t{16} << 20) + 1, '#')),
              "3 scene.toml: error: is larger than 16 MiB, not a scene");
    EXPECT_THROW(load_scene_description(folder() / "absent.toml"), InputError);
    EXPECT_THROW(load_scene_description(folder()), InputError);
}

TEST_F(SceneComplaints, PhaseFunctionsInTheSceneItselfAreCheckedLikeThoseOfFiles) {
    const auto said = [&](const std::string& numbers) {
        return complaint(with(kScene, "anisotropy = 0.9", "phase_function = { kind = \"table\", " + numbers + " }"));
    };
    EXPECT_EQ(said("cosine = [-1, 0, 1], value = [0.1, 0.1, 1]"), "no complaint");
    EXPECT_NE(said("cosine = [-1, 1], value = [1]").find("has 1 values for 2 cosines"), std::string::npos);
    EXPECT_NE(said("cosine = [-0.5, 1], value = [1, 1]").find("is no phase function: it must reach from"),
              std::string::npos);
    EXPECT_NE(said("cosine = [-1, 1], value = [1, -1]").find("must be 0 or more"), std::string::npos);
}

}  // namespace
}  // namespace fluovox::testing
