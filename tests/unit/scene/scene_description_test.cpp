#include "fluovox/scene/scene_description.h"

#include "unit/scene/scene_fixture.h"

#include <cmath>
#include <numbers>
#include <variant>

namespace fluovox::testing {
namespace {

class SceneDescriptionTest : public SceneTest {};

template <class T>
const T& as(const auto& variant) {
    EXPECT_TRUE(std::holds_alternative<T>(variant));
    return std::get<T>(variant);
}

TEST_F(SceneDescriptionTest, DyePerVoxelTakesItsGridWithUnits) {
    const SceneDescription scene = load(kScene);
    ASSERT_EQ(scene.media.size(), 3U);
    const MediumDescription& medium = scene.media[0];
    ASSERT_TRUE(medium.dye && medium.grid);
    EXPECT_EQ(medium.dye->name, "EGFP");
    EXPECT_EQ(medium.name, "EGFP");
    EXPECT_EQ(medium.where.line, 2);
    EXPECT_EQ(medium.grid->file, folder() / "neuron.vdb");
    EXPECT_EQ(medium.grid->written, "neuron.vdb");
    EXPECT_EQ(medium.grid->name, "EGFP");
    EXPECT_DOUBLE_EQ(medium.grid->uM_per_value.value(), 1e-3);
    EXPECT_DOUBLE_EQ(medium.grid->um_per_length.value(), 8e-3);
    EXPECT_EQ(medium.grid->scale, 2);
    EXPECT_EQ(medium.grid->where.line, 4);
    const SceneDescription plain =
        load(with(kScene, ", name = \"EGFP\", unit = \"nM\", length_unit = \"8 nm\", scale = 2", ""));
    EXPECT_FALSE(plain.media[0].grid->uM_per_value || plain.media[0].grid->um_per_length);
    EXPECT_EQ(plain.media[0].grid->scale, 1);
    EXPECT_EQ(plain.media[0].grid->name, "");
}

TEST_F(SceneDescriptionTest, DyeInARegionTakesItsConcentration) {
    const MediumDescription medium = load(kScene).media[1];
    EXPECT_DOUBLE_EQ(medium.concentration_uM, 10);
    EXPECT_FALSE(medium.grid);
    EXPECT_EQ(as<BoxRegion>(medium.region).min, (Vec3{-5000, -15000, -5000}));
    EXPECT_EQ(as<BoxRegion>(medium.region).max, (Vec3{5000, 15000, 5000}));
}

TEST_F(SceneDescriptionTest, HostTakesItsCoefficientsNameAndIndex) {
    MediumDescription host = load(kScene).media[2];
    EXPECT_EQ(host.name, "host1");
    EXPECT_FALSE(host.dye || host.grid || host.refractive_index || host.exclusive);
    EXPECT_DOUBLE_EQ(std::get<double>(host.scattering), 0.02);
    EXPECT_DOUBLE_EQ(std::get<double>(host.absorption), 2e-5);
    EXPECT_EQ(as<HenyeyGreenstein>(host.phase).g, 0.9);
    as<Everywhere>(host.region);
    host =
        load(with(kScene, "anisotropy = 0.9", "name = \"tissue\"\nrefractive_index = 1.36\nexclusive = true")).media[2];
    EXPECT_EQ(host.name, "tissue");
    EXPECT_EQ(host.refractive_index, 1.36);
    EXPECT_TRUE(host.exclusive);
    EXPECT_EQ(mean_cosine(host.phase), 0);
}

TEST_F(SceneDescriptionTest, CoefficientsMayBeAPowerLawOrATable) {
    write("mu_s.csv", "wavelength_nm,mu_s\n400,30\n600,20\n");
    const MediumDescription host =
        load(with(with(kScene, "\"20 /mm\"", "{ at = \"0.5 um\", value = \"24.2 /cm\", exponent = -1.6 }"),
                  "\"0.02 /mm\"", "{ file = \"mu_s.csv\", unit = \"/cm\" }"))
            .media[2];
    EXPECT_NEAR(coefficient_per_um(host.scattering, 500), 24.2e-4, 1e-15);
    EXPECT_NEAR(coefficient_per_um(host.scattering, 1000), 24.2e-4 * std::pow(2, -1.6), 1e-15);
    EXPECT_NEAR(coefficient_per_um(host.absorption, 500), 25e-4, 1e-15);
    EXPECT_NEAR(coefficient_per_um(host.absorption, 900), 20e-4, 1e-15) << "a table holds its end values";
}

TEST_F(SceneDescriptionTest, RegionsHaveEveryShape) {
    const auto region = [&](const std::string& text) {
        return load(with(kScene, "\"everywhere\"", text)).media[2].region;
    };
    const Region sphere = region(R"({ sphere = { center = ["1 um", "2 um", "3 um"], radius = "1 mm" } })");
    EXPECT_EQ(as<SphereRegion>(sphere).center, (Vec3{1, 2, 3}));
    EXPECT_EQ(as<SphereRegion>(sphere).radius, 1000);
    const Region cylinder =
        region(R"({ cylinder = { from = ["0 um", "0 um", "0 um"], to = ["0 um", "0 um", "1 mm"], radius = "5 mm" } })");
    EXPECT_EQ(as<CylinderRegion>(cylinder).to, (Vec3{0, 0, 1000}));
    EXPECT_EQ(as<CylinderRegion>(cylinder).radius, 5000);
    const Region slab = region(R"({ slab = { axis = "y", min = "0 um", max = "200 um" } })");
    EXPECT_EQ(as<SlabRegion>(slab).axis, 1);
    EXPECT_EQ(as<SlabRegion>(slab).max, 200);
    const Region half = region(R"({ slab = { axis = "z", min = "-1 um" } })");
    EXPECT_EQ(as<SlabRegion>(half).min, -1);
    EXPECT_TRUE(std::isinf(as<SlabRegion>(half).max));
}

TEST_F(SceneDescriptionTest, HostMayHaveAGridOfDensity) {
    const MediumDescription host =
        load(with(kScene, "region     = \"everywhere\"", "grid = { file = \"t.vdb\" }")).media[2];
    ASSERT_TRUE(host.grid);
    EXPECT_EQ(host.grid->written, "t.vdb");
    EXPECT_EQ(host.grid->scale, 1);
}

TEST_F(SceneDescriptionTest, SheetIsMadeOrthogonal) {
    const Light light = load(kScene).lights.at(0).light;
    const auto& sheet = as<SheetLight>(light.shape);
    EXPECT_EQ(sheet.position, (Vec3{-1000, 250, 250}));
    EXPECT_EQ(sheet.direction, (Vec3{1, 0, 0}));
    EXPECT_EQ(sheet.normal, (Vec3{0, 0, 1})) << "its part along the direction is taken away";
    EXPECT_EQ(sheet.width_um, 600);
    EXPECT_EQ(sheet.thickness_um, 5);
    EXPECT_EQ(sheet.profile, BeamProfile::Gaussian);
    EXPECT_FALSE(sheet.two_sided);
    EXPECT_EQ(sheet.numerical_aperture, 0);
    EXPECT_EQ(sheet.waist, sheet.position);
    EXPECT_DOUBLE_EQ(light.power_W, 1e-3);
    ASSERT_EQ(light.spectrum.lines.size(), 1U);
    EXPECT_EQ(light.spectrum.lines[0].wavelength_nm, 488);
    EXPECT_EQ(light.spectrum.lines[0].share, 1);
    EXPECT_TRUE(light.spectrum.energy_per_nm.empty());

    const Light focused = load(with(kScene, "thickness  = \"5 um\"",
                                    "thickness = \"5 um\"\ntwo_sided = true\nnumerical_aperture = 0.05\n"
                                    "waist = [\"1 um\", \"2 um\", \"3 um\"]"))
                              .lights.at(0)
                              .light;
    EXPECT_TRUE(as<SheetLight>(focused.shape).two_sided);
    EXPECT_EQ(as<SheetLight>(focused.shape).numerical_aperture, 0.05);
    EXPECT_EQ(as<SheetLight>(focused.shape).waist, (Vec3{1, 2, 3}));
    const Light box =
        load(with(kScene, "thickness  = \"5 um\"", "thickness = \"5 um\"\nprofile = \"box\"")).lights.at(0).light;
    EXPECT_EQ(as<SheetLight>(box.shape).profile, BeamProfile::Box);
}

std::string scene_with_light(const std::string& light) {
    const std::size_t begin = kScene.find("[[light]]");
    const std::size_t end = kScene.find("[camera]");
    return kScene.substr(0, begin) + "[[light]]\n" + light + '\n' + kScene.substr(end);
}

TEST_F(SceneDescriptionTest, BeamPointRectangleAndUniformHaveTheirKeys) {
    const Light beam = load(scene_with_light("kind = \"beam\"\nwavelength = \"488 nm\"\npower = \"2 uW\"\n"
                                             "position = [\"0 um\", \"0 um\", \"1 um\"]\ndirection = [0, 3, 0]\n"
                                             "radius = \"0 um\"\nprofile = \"box\""))
                           .lights.at(0)
                           .light;
    EXPECT_EQ(as<BeamLight>(beam.shape).direction, (Vec3{0, 1, 0}));
    EXPECT_EQ(as<BeamLight>(beam.shape).radius_um, 0);
    EXPECT_EQ(as<BeamLight>(beam.shape).profile, BeamProfile::Box);
    EXPECT_DOUBLE_EQ(beam.power_W, 2e-6);

    const Light point = load(scene_with_light("kind = \"point\"\nwavelength = \"488 nm\"\npower = \"1 W\"\n"
                                              "position = [\"0 um\", \"0 um\", \"1 um\"]"))
                            .lights.at(0)
                            .light;
    EXPECT_EQ(as<PointLight>(point.shape).position, (Vec3{0, 0, 1}));

    const Light rectangle =
        load(scene_with_light("kind = \"rectangle\"\nwavelength = \"488 nm\"\npower = \"1 W\"\n"
                              "center = [\"0 um\", \"0 um\", \"1 um\"]\nnormal = [0, 0, -2]\nup = [0, 1, 1]\n"
                              "size = [\"1 mm\", \"2 mm\"]"))
            .lights.at(0)
            .light;
    EXPECT_EQ(as<RectangleLight>(rectangle.shape).center, (Vec3{0, 0, 1}));
    EXPECT_EQ(as<RectangleLight>(rectangle.shape).normal, (Vec3{0, 0, -1}));
    EXPECT_EQ(as<RectangleLight>(rectangle.shape).up, (Vec3{0, 1, 0}));
    EXPECT_EQ(as<RectangleLight>(rectangle.shape).width_um, 1000);
    EXPECT_EQ(as<RectangleLight>(rectangle.shape).height_um, 2000);

    const Light uniform =
        load(scene_with_light("kind = \"uniform\"\nwavelength = \"488 nm\"\nradiance = \"3 W/m2/sr\""))
            .lights.at(0)
            .light;
    EXPECT_EQ(as<UniformLight>(uniform.shape).radiance_W_per_m2_sr, 3);
    EXPECT_EQ(uniform.power_W, 0);
}

TEST_F(SceneDescriptionTest, SpectraOfLightsAreSharesThatAddUpToOne) {
    const auto spectrum = [&](const std::string& text) {
        return load(with(kScene, "wavelength = \"488 nm\"", "spectrum = " + text)).lights.at(0).light.spectrum;
    };
    const LightSpectrum band = spectrum(R"({ from = "450 nm", to = "490 nm" })");
    EXPECT_TRUE(band.lines.empty());
    EXPECT_NEAR(band.energy_per_nm(470), 1.0 / 40, 1e-15);
    EXPECT_NEAR(band.energy_per_nm.integral(), 1, 1e-12);
    EXPECT_EQ(spectrum(R"({ center = "470 nm", width = "40 nm" })").energy_per_nm.first_nm(), 450);

    write("lamp.csv", "wavelength_nm,power\n400,1\n800,1\n");
    const LightSpectrum energy = spectrum(R"({ file = "lamp.csv", table_is = "energy" })");
    EXPECT_NEAR(energy.energy_per_nm(400) / energy.energy_per_nm(800), 1, 1e-12);
    EXPECT_NEAR(energy.energy_per_nm.integral(), 1, 1e-12);
    const LightSpectrum photons = spectrum(R"({ file = "lamp.csv", table_is = "photons" })");
    EXPECT_NEAR(photons.energy_per_nm(400) / photons.energy_per_nm(800), 2, 1e-12) << "a blue photon carries more";
    EXPECT_NEAR(photons.energy_per_nm.integral(), 1, 1e-12);
    write("said.csv", "# table_is = \"photons\"\n400,1\n800,1\n");
    const LightSpectrum said = spectrum(R"({ file = "said.csv" })");
    EXPECT_NEAR(said.energy_per_nm(400) / said.energy_per_nm(800), 2, 1e-12);
}

TEST_F(SceneDescriptionTest, CameraTakesItsKeysAndFocusesOnItsTarget) {
    const Camera camera = load(kScene).camera;
    EXPECT_EQ(camera.kind, Camera::Kind::Telecentric);
    EXPECT_EQ(camera.position, (Vec3{250, 250, 2000}));
    EXPECT_EQ(camera.target, (Vec3{250, 250, 250}));
    EXPECT_EQ(camera.up, (Vec3{0, 1, 0}));
    EXPECT_EQ(camera.focus_um, 1750);
    EXPECT_EQ(camera.field_um, 500);
    EXPECT_EQ(camera.width, 256);
    EXPECT_EQ(camera.height, 128);
    EXPECT_EQ(camera.numerical_aperture, 0.3);
    const Camera other =
        load(with(with(with(kScene, "\"telecentric\"", "\"perspective\""), "field      = \"500 um\"", "fov_deg = 30"),
                  "numerical_aperture = 0.3", "focus = \"1 mm\""))
            .camera;
    EXPECT_EQ(other.kind, Camera::Kind::Perspective);
    EXPECT_DOUBLE_EQ(other.fov_rad, std::numbers::pi / 6);
    EXPECT_EQ(other.focus_um, 1000);
    EXPECT_EQ(other.numerical_aperture, 0);
}

TEST_F(SceneDescriptionTest, FilmIsASpectrometer) {
    const FilmSpec film = load(kScene).film;
    EXPECT_TRUE(film.is_spectral);
    EXPECT_EQ(film.from_nm, 480);
    EXPECT_EQ(film.to_nm, 620);
    EXPECT_EQ(film.unit, FilmUnit::Watts);
    EXPECT_FALSE(film.per_dye);
    ASSERT_EQ(film.channels.size(), 28U);
    EXPECT_EQ(film.channels[14].name, "552,500nm");
    EXPECT_DOUBLE_EQ(film.channels[14].center_nm, 552.5);
    EXPECT_NEAR(film.channels[14].response.integral(), 1, 1e-12) << "a bin reads the mean per nm";
    EXPECT_EQ(film.channels[27].response.last_nm(), 620);
}

TEST_F(SceneDescriptionTest, FilmHasDetectorChannels) {
    write("filter.csv", "500,0\n520,1\n540,0\n");
    write("qe.csv", "400,0.5\n600,0.5\n");
    const FilmSpec film =
        load(with(kScene, "spectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 }",
                  "unit = \"photons\"\nper_dye = true\n"
                  "[[film.channel]]\nname = \"green\"\nband = { center = \"525 nm\", width = \"50 nm\" }\n"
                  "[[film.channel]]\nname = \"red\"\nfilter = \"filter.csv\"\nefficiency = \"qe.csv\"\n"))
            .film;
    EXPECT_FALSE(film.is_spectral);
    EXPECT_EQ(film.unit, FilmUnit::Photons);
    EXPECT_TRUE(film.per_dye);
    ASSERT_EQ(film.channels.size(), 2U);
    EXPECT_EQ(film.channels[0].name, "green");
    EXPECT_DOUBLE_EQ(film.channels[0].center_nm, 525);
    EXPECT_DOUBLE_EQ(film.channels[0].response.integral(), 50);
    EXPECT_FALSE(film.channels[0].counts_photons);
    EXPECT_DOUBLE_EQ(film.channels[1].response.integral(), 10);
    EXPECT_NEAR(film.channels[1].center_nm, 520, 1e-9);
    EXPECT_TRUE(film.channels[1].counts_photons);
}

TEST_F(SceneDescriptionTest, StackAndRenderHaveTheirKeys) {
    const SceneDescription scene = load(kScene);
    ASSERT_TRUE(scene.stack);
    EXPECT_EQ(scene.stack->along, (Vec3{0, 0, 1}));
    EXPECT_EQ(scene.stack->start_um, -20);
    EXPECT_EQ(scene.stack->stop_um, 20);
    EXPECT_EQ(scene.stack->step_um, 2);
    EXPECT_EQ(scene.render.samples, 64);
    EXPECT_EQ(scene.render.seed, 1U);
    EXPECT_EQ(scene.render.fluorescence_orders, 1);
    EXPECT_FALSE(scene.render.max_scatterings || scene.render.filter || scene.render.photons ||
                 scene.render.cache_voxel_um);

    const RenderDescription render =
        load(with(kScene, "samples   = 64",
                  "samples = 8\nseed = 9\nfluorescence_orders = \"all\"\nmax_scatterings = 0\nphotons = 1e6\n"
                  "cache_voxel = \"2 um\"\nfilter = { block = [{ from = \"480 nm\", to = \"490 nm\" }] }"))
            .render;
    EXPECT_EQ(render.estimator, "auto");
    EXPECT_EQ(render.samples, 8);
    EXPECT_EQ(render.seed, 9U);
    EXPECT_FALSE(render.fluorescence_orders);
    EXPECT_EQ(render.max_scatterings, 0);
    EXPECT_EQ(render.photons, 1e6);
    EXPECT_EQ(render.cache_voxel_um, 2);
    ASSERT_TRUE(render.filter);
    EXPECT_FALSE(render.filter->passes);
    EXPECT_EQ(render.filter->bands.at(0).to_nm, 490);
    const auto pass =
        load(with(kScene, "samples   = 64", "filter = { pass = [\"500 nm\", \"550 nm\"] }")).render.filter;
    ASSERT_TRUE(pass);
    EXPECT_TRUE(pass->passes);
    EXPECT_EQ(pass->bands.at(0).from_nm, 500);
}

TEST_F(SceneDescriptionTest, DefaultsHoldWhereTheSceneIsSilent) {
    const SceneDescription scene = load(
        "[camera]\nposition = [\"0 um\", \"0 um\", \"1 mm\"]\ntarget = [\"0 um\", \"0 um\", \"0 um\"]\n"
        "field = \"1 mm\"\nresolution = [4, 4]\n[film]\nspectrum = { from = \"500 nm\", to = \"510 nm\", bins = 1 }\n");
    EXPECT_EQ(scene.title, "");
    EXPECT_EQ(scene.camera.kind, Camera::Kind::Telecentric);
    EXPECT_EQ(scene.camera.up, (Vec3{0, 1, 0}));
    EXPECT_EQ(scene.render.estimator, "auto");
    EXPECT_EQ(scene.render.samples, 64);
    EXPECT_FALSE(scene.stack);
    EXPECT_EQ(scene.warnings.size(), 2U) << "neither lights nor media";
}

TEST_F(SceneDescriptionTest, NamesThatStandForAnotherDyeAreSaid) {
    const SceneDescription scene = load(with(kScene, "dye  = \"EGFP\"", "dye = \"GFP\""));
    EXPECT_EQ(scene.media[0].dye->name, "EGFP");
    ASSERT_EQ(scene.remarks.size(), 1U);
    EXPECT_NE(scene.remarks[0].find("medium.0.dye"), std::string::npos);
}

TEST_F(SceneDescriptionTest, AbsurdConcentrationIsAWarning) {
    EXPECT_TRUE(load(kScene).warnings.empty());
    const SceneDescription scene = load(with(kScene, "\"10 uM\"", "\"0.2 M\""));
    ASSERT_EQ(scene.warnings.size(), 1U);
    EXPECT_NE(scene.warnings[0].find("0.1 mol/L"), std::string::npos);
}

TEST_F(SceneDescriptionTest, OverridesReplaceAndAddKeys) {
    const SceneDescription scene =
        load(kScene, {"camera.resolution=[64,32]", "render.estimator=path", "medium.2.scattering=10 /mm",
                      "render.seed=5", "medium.1.region=everywhere", "camera.position.2=\"3 mm\"", "title=a=b",
                      "render.samples=1", "render.samples=2"});
    EXPECT_EQ(scene.camera.width, 64);
    EXPECT_EQ(scene.camera.height, 32);
    EXPECT_EQ(scene.render.estimator, "path");
    EXPECT_EQ(scene.render.seed, 5U);
    EXPECT_EQ(scene.render.samples, 2) << "the last one wins";
    EXPECT_DOUBLE_EQ(std::get<double>(scene.media[2].scattering), 0.01);
    as<Everywhere>(scene.media[1].region);
    EXPECT_EQ(scene.camera.position.z, 3000);
    EXPECT_EQ(scene.title, "a=b");
    const std::string without_render = kScene.substr(0, kScene.find("[render]"));
    EXPECT_EQ(load(without_render, {"render.samples=3"}).render.samples, 3) << "missing tables are made";
}

TEST_F(SceneDescriptionTest, JsonIsTheSameForTheSameSceneAndTellsEveryDefault) {
    const std::string json = to_json(load(kScene));
    EXPECT_EQ(json, to_json(load(kScene)));
    for (const char* part :
         {"\"focus\": \"1750 um\"", "\"seed\": 1", "\"profile\": \"gaussian\"", "\"scale\": 2",
          "\"concentration\": \"10 uM\"", "\"resolution\": [256,128]", "\"per_dye\": false", "\"file\": \"neuron.vdb\"",
          "\"region\": \"everywhere\"", "\"bins\": 28", "\"fluorescence_orders\": 1", "\"quantum_yield\":"}) {
        EXPECT_NE(json.find(part), std::string::npos) << part << " is not in\n" << json;
    }
    EXPECT_EQ(json.find(folder().string()), std::string::npos) << "nothing in it depends on where the scene lies";
    EXPECT_NE(json, to_json(load(kScene, {"camera.focus=\"1 mm\""})));
}

// The list of all keys that people copy from: it loads, and no key is absent.
TEST_F(SceneDescriptionTest, ReferenceFileLoadsAndHasEveryKey) {
    const std::filesystem::path file = std::filesystem::path(FLUOVOX_SOURCE_DIR) / "volumes/reference/reference.toml";
    const SceneDescription scene = load_scene_description(file);
    EXPECT_EQ(scene.media.size(), 8U);
    EXPECT_EQ(scene.lights.size(), 5U);
    EXPECT_TRUE(scene.warnings.empty());
    std::ifstream in(file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    for (const char* key : {"title",
                            "dye",
                            "grid",
                            "file",
                            "name",
                            "unit",
                            "length_unit",
                            "scale",
                            "concentration",
                            "region",
                            "box",
                            "sphere",
                            "cylinder",
                            "slab",
                            "everywhere",
                            "scattering",
                            "absorption",
                            "at",
                            "value",
                            "exponent",
                            "anisotropy",
                            "phase_function",
                            "refractive_index",
                            "exclusive",
                            "kind",
                            "wavelength",
                            "spectrum",
                            "table_is",
                            "from",
                            "to",
                            "center",
                            "width",
                            "power",
                            "position",
                            "direction",
                            "normal",
                            "thickness",
                            "profile",
                            "two_sided",
                            "numerical_aperture",
                            "waist",
                            "radius",
                            "up",
                            "size",
                            "radiance",
                            "target",
                            "focus",
                            "field",
                            "fov_deg",
                            "resolution",
                            "bins",
                            "channel",
                            "band",
                            "filter",
                            "efficiency",
                            "per_dye",
                            "along",
                            "start",
                            "stop",
                            "step",
                            "views",
                            "exposure",
                            "blur",
                            "immersion_index",
                            "pixel_size",
                            "magnification",
                            "sensor_pixel",
                            "rayleigh_range",
                            "diffraction",
                            "pivot_deg",
                            "scan",
                            "estimator",
                            "samples",
                            "seed",
                            "fluorescence_orders",
                            "max_scatterings",
                            "pass",
                            "block",
                            "photons",
                            "cache_voxel"}) {
        EXPECT_NE(text.find(key), std::string::npos) << key;
    }
    // The alternatives that stand in comments are valid too.
    EXPECT_NO_THROW(
        load_scene_description(file, {"film={ spectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 } }",
                                      "render.filter.block=[\"480 nm\", \"490 nm\"]", "medium.0.dye=GFP",
                                      "light.1.spectrum={ center = \"470 nm\", width = \"40 nm\" }"}));
}

// What check --print writes, and what is in every image.
TEST_F(SceneDescriptionTest, ItsJsonIsAScene) {
    const std::string pencil =
        "[[light]]\nkind = \"beam\"\nwavelength = \"561 nm\"\npower = \"1 mW\"\nradius = \"9 um\"\n"
        "numerical_aperture = 0.1\nposition = [\"0 um\", \"0 um\", \"-1 mm\"]\ndirection = [0, 0, 1]\n"
        "[[light]]\nkind = \"uniform\"\nwavelength = \"488 nm\"\nradiance = \"1 W/m2/sr\"\n";
    const std::string bands =
        "[film]\nunit = \"photons\"\n[[film.channel]]\nname = \"a \\\"b\\\" \u00b5\"\nband = { center = \"525 nm\", "
        "width = \"50 nm\" }\n";
    const std::vector<std::string> scenes = {
        kScene,
        with(kScene, "[camera]", pencil + "[camera]"),
        with(kScene, "[film]\nspectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 }\n", bands),
        with(kScene, "thickness  = \"5 um\"",
             "thickness = \"5 um\"\ndiffraction = true\ntwo_sided = true\n"
             "waist = [\"0 um\", \"250 um\", \"250 um\"]\npivot_deg = [-2, 0, 2]"),
        with(kScene, "anisotropy = 0.9",
             "phase_function = { kind = \"two-term-henyey-greenstein\", g1 = 0.9, g2 = -0.3, weight = 0.9 }\n"
             "refractive_index = 1.36"),
        with(kScene, "numerical_aperture = 0.3",
             "numerical_aperture = 0.8\nimmersion_index = 1.33\nexposure = \"20 ms\"\nblur = \"diffraction\""),
        with(kScene, "samples   = 64",
             "samples = 64\nfluorescence_orders = \"all\"\nphotons = 1e6\nmax_scatterings = 3\n"
             "filter = { block = [{ from = \"483 nm\", to = \"493 nm\" }] }")};
    for (const std::string& text : scenes) {
        const std::string json = to_json(load(text));
        EXPECT_EQ(to_json(load(json)), json);
    }
    // Tables of files are in it, so that it needs none of them.
    write("lamp.csv", "480,1\n500,3\n520,0.3\n");
    write("filter.csv", "500,0\n520,1\n540,0.2\n");
    write("qe.csv", "400,0.8\n700,0.5\n");
    write("mu.csv", "480,17\n500,13\n620,7.7\n");
    const std::string tables = to_json(
        load(with(with(with(kScene, "scattering = \"20 /mm\"", "scattering = { file = \"mu.csv\", unit = \"/cm\" }"),
                       "wavelength = \"488 nm\"", "spectrum = { file = \"lamp.csv\", table_is = \"photons\" }"),
                  "[film]\nspectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 }\n",
                  "[[film.channel]]\nname = \"a\"\nfilter = \"filter.csv\"\nefficiency = \"qe.csv\"\n")));
    for (const char* name : {"lamp.csv", "filter.csv", "qe.csv", "mu.csv"})
        std::filesystem::remove(folder() / name);
    EXPECT_EQ(to_json(load(tables)), tables);
    const SceneDescription scene = load(tables);
    EXPECT_TRUE(scene.film.channels[0].counts_photons);
    EXPECT_NEAR(scene.film.channels[0].response(520), 0.68, 1e-12);
    EXPECT_NEAR(std::get<Spectrum>(scene.media[2].scattering)(500), 13e-4, 1e-15);
    EXPECT_NE(complaint(with(kScene, "scattering = \"20 /mm\"",
                             "scattering = { unit = \"/mm\", table = { wavelength_nm = [500, 400], value = [1, 2] } }"))
                  .find("wavelength_nm = [500, 400] must increase"),
              std::string::npos);
    EXPECT_EQ(complaint("{ \"title\": "), "3 scene.toml:1:1: error: begins like JSON, and is not");
    EXPECT_NE(complaint("{ \"medium\": 3 }").find("no scene as check --print writes it"), std::string::npos);
}

TEST_F(SceneDescriptionTest, ItsJsonTellsAGreyFilterFromABand) {
    write("grey.csv", "500,0.5\n550,0.5\n");
    const std::string json =
        to_json(load(with(kScene, "[film]\nspectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 }\n",
                          "[[film.channel]]\nname = \"a\"\nfilter = \"grey.csv\"\n")));
    EXPECT_EQ(json.find("\"band\""), std::string::npos);
    EXPECT_NE(json.find("[0.5,0.5]"), std::string::npos) << json;
}

}  // namespace
}  // namespace fluovox::testing
