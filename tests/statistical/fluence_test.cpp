#include "fluovox/transport/fluence.h"

#include "fluovox/transport/photon_source.h"

#include "scene_kit.h"
#include "statistics.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

// All lengths in units of the mean free path or of the slab, taken as micrometres.
constexpr double kBlue = 480, kGreen = 520;

Light pencil(Vec3 position, Vec3 direction) {
    BeamLight beam;
    beam.position = beam.waist = position;
    beam.direction = direction;
    return laser(beam, kBlue, 1);
}

Scene scene_of(std::vector<SceneMedium> media, Light light) {
    Scene scene;
    scene.media = std::move(media);
    scene.lights = {std::move(light)};
    return scene;
}

FluenceResult trace(const Scene& scene, std::int64_t photons, std::uint64_t seed = 1) {
    FluenceSettings settings;
    settings.photons = photons;
    settings.seed = seed;
    NoProgress progress;
    return trace_fluence(scene, settings, progress);
}

double z(const Estimate& got, double expected) {
    return (got.value - expected) / got.standard_error;
}

// A slab of optical thickness 2 and albedo 0.9 under normal light (van de Hulst, Multiple Light Scattering, 1980,
// table 35), to more digits by adding-doubling.
struct SlabTable {
    double reflected = 0.0973946387, transmitted = 0.6609577002, absorbed = 0.2416476612;
};

FluenceResult van_de_hulst_slab(double g, double scattering) {
    return trace(scene_of({host(SlabRegion{2, 0, 2}, scattering, 0.1, g)}, pencil({0, 0, -1}, {0, 0, 1})), 200000);
}

Estimate scattered_back(const FluenceResult& result) {
    return result.share.excitation.escaped[4][2];
}
Estimate absorbed(const FluenceResult& result) {
    return result.share.excitation.absorbed[0];
}

TEST(Fluence, VanDeHulstSlabReflectsAbsorbsAndTransmitsAsTabulated) {
    const SlabTable table;
    const FluenceResult result = van_de_hulst_slab(0.75, 0.9);
    EXPECT_LT(std::abs(z(scattered_back(result), table.reflected)), 5);
    EXPECT_LT(std::abs(z(absorbed(result), table.absorbed)), 5);
    const LightBudget& budget = result.share.excitation;
    EXPECT_LT(std::abs(z(budget.escaped[5][1], std::exp(-2))), 5);
    EXPECT_LT(std::abs(z(budget.escaped[5][2], table.transmitted - std::exp(-2))), 5);
}

TEST(Fluence, TheSlabTestFailsForAnisotropyOrScatteringThatIsOff) {
    const SlabTable table;
    EXPECT_GT(std::abs(z(scattered_back(van_de_hulst_slab(0.73, 0.9)), table.reflected)), 5);
    EXPECT_GT(std::abs(z(absorbed(van_de_hulst_slab(0.75, 0.95)), table.absorbed)), 5);
}

TEST(Fluence, PartsAddUpToWhatWasLaunched) {
    Scene scene = scene_of({host(BoxRegion{{0, 0, 0}, {3, 3, 3}}, 1, 0.02, 0.5), dye_in(Everywhere{}, 0, 1)},
                           pencil({1, 1, -1}, {0, 0, 1}));
    scene.media[1].region = SphereRegion{{1.5, 1.5, 1.5}, 1.2};
    scene.dyes = {flat_dye(0.5, 400, 550, 500, 600, 0.7)};
    scene.description.render.fluorescence_orders.reset();
    const FluenceResult result = trace(scene, 20000);
    EXPECT_NEAR(result.share.excitation.total.value, 1, 1e-12);
    EXPECT_NEAR(result.share.emission.total.value, result.share.emission.launched.value, 1e-12);
    EXPECT_NEAR(result.share.excitation.reemitted[0].value + result.share.emission.reemitted[0].value,
                result.share.emission.launched.value, 1e-12);
    EXPECT_NEAR(result.watts.excitation.total.value, 1, 1e-12);
}

TEST(Fluence, SameSeedGivesTheSameNumbersForAnyNumberOfThreads) {
    const Scene scene = scene_of({host(SlabRegion{2, 0, 2}, 0.9, 0.1, 0.75)}, pencil({0, 0, -1}, {0, 0, 1}));
    const auto with_threads = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return scattered_back(trace(scene, 5000));
    };
    const Estimate one = with_threads(1);
    const Estimate three = with_threads(3);
    EXPECT_EQ(one.value, three.value);
    EXPECT_EQ(one.standard_error, three.standard_error);
    EXPECT_NE(one.value, scattered_back(trace(scene, 5000, 2)).value);
}

// Without absorption, in uniform light, the mean path in a body of index n is 4 V/S n^2 whatever it scatters.
// Blanco & Fournier, Europhys. Lett. 61 (2003) 168.
FluenceResult furnace(double index, double factor = 1) {
    Light light;
    light.shape = UniformLight{1};
    light.spectrum.lines = {{kBlue, 1}};
    SceneMedium body = host(BoxRegion{{0, 0, 0}, {1, 2, 3}}, 2 * factor, 0, 0.5);
    body.refractive_index = index;
    return trace(scene_of({body}, light), 100000);
}

TEST(Fluence, MeanPathInUniformLightDependsOnShapeAndIndexAlone) {
    const double expected = 4.0 * 6 / 22;
    EXPECT_LT(std::abs(z(furnace(1).mean_path_um, expected)), 5);
    EXPECT_LT(std::abs(z(furnace(1, 3).mean_path_um, expected)), 5);
    EXPECT_LT(std::abs(z(furnace(1.37).mean_path_um, expected * 1.37 * 1.37)), 5);
    EXPECT_GT(std::abs(z(furnace(1.37).mean_path_um, expected * 1.39 * 1.39)), 5);
}

// A ball in its box of air: photons that miss it count for nothing, those it reflects for one each.
TEST(Fluence, MeanPathIsThatInMediaOfPhotonsThatMetOne) {
    Light light;
    light.shape = UniformLight{1};
    light.spectrum.lines = {{kBlue, 1}};
    for (const double index : {1.0, 1.4}) {
        SceneMedium ball = host(SphereRegion{{5, 6, 7}, 2}, 1, 0, 0.5);
        if (index != 1) ball.refractive_index = index;
        const Estimate path = trace(scene_of({ball}, light), 100000).mean_path_um;
        EXPECT_LT(std::abs(z(path, 4.0 / 3 * 2 * index * index)), 5) << index;
        EXPECT_LT(path.standard_error, 0.01 * path.value) << index;
        EXPECT_GT(std::abs(z(path, 4.0 / 3 * 2.1 * index * index)), 5) << index;
    }
}

// Two cells with dyes on lattices of their own: each dye's absorbed power lies on its own voxels.
TEST(Fluence, EachDyesGridKeepsItsOwnVoxels) {
    Affine turned;
    turned.rows = {Vec3{0.8, -0.6, 0}, Vec3{0.6, 0.8, 0}, Vec3{0, 0, 1}};
    turned.offset = {3, 0, 0};
    const auto cell = [](const Affine& map) {
        return SparseGrid::from_function({0, 0, 0}, {6, 6, 6}, map, [](Voxel) { return 1; });
    };
    Light light;
    light.shape = UniformLight{1};
    light.spectrum.lines = {{kBlue, 1}};
    Scene scene = scene_of({dye_in(cell({}), 0), dye_in(cell(turned), 1), dye_in(cell({}), 1)}, light);
    const std::array<std::string, 3> names = {"one", "two", "three"};
    for (std::size_t m = 0; m < 3; ++m)
        scene.media[m].name = names[m];
    scene.dyes = {flat_dye(0.05, 400, 490, 500, 510, 0.5), flat_dye(0.02, 400, 490, 500, 510, 0.5)};
    FluenceSettings settings;
    settings.photons = 100000;
    settings.grids = true;
    NoProgress progress;
    const FluenceResult result = trace_fluence(scene, settings, progress);
    std::vector<std::string> found;
    for (const BrickField& grid : result.grids) {
        found.push_back(grid.name);
        for (std::size_t m = 0; m < 3; ++m) {
            if (grid.name != "absorbed." + names[m]) continue;
            EXPECT_EQ(grid.world_from_index.rows[0].x, m == 1 ? 0.8 : 1);
            double watts = 0;
            for (const float value : grid.values)
                watts += static_cast<double>(value) * 1e-9;  // W/mm3 in a voxel of 1 um3
            const Estimate& budget = result.watts.excitation.absorbed[m];
            EXPECT_NEAR(watts / budget.value, 1, 1e-5) << names[m];
        }
    }
    const std::vector<std::string> expected = {"fluence.excitation",   "fluence.emission", "fluence.excitation.two",
                                               "fluence.emission.two", "absorbed.one",     "absorbed.two",
                                               "absorbed.three"};
    EXPECT_EQ(found, expected);
}

// Numerical aperture is n sin(theta): where a focused light starts in glass, its rays are steeper.
TEST(Fluence, NumericalApertureIsThatOfTheMediumWhereTheLightStarts) {
    constexpr double kAperture = 0.6;
    for (const double index : {1.0, 1.5}) {
        BeamLight beam;
        beam.direction = {0, 0, 1};
        beam.radius_um = 2;
        beam.waist = {0, 0, 50};
        beam.numerical_aperture = kAperture;
        SceneMedium glass = host(BoxRegion{{-100, -100, -100}, {100, 100, 100}}, 0, 0);
        if (index != 1) glass.refractive_index = index;
        const Scene scene = scene_of({glass}, laser(beam, kBlue, 1));
        const PhotonSpace space(scene);
        const PhotonSource source(scene, space);
        RunningMean squared_slope;
        RunningMean squared_waist;
        for (int n = 0; n < 50000; ++n) {
            Rng rng(4, static_cast<std::uint64_t>(n), 0);
            const Ray ray = source.launch(rng).ray;
            squared_slope.add(std::pow(ray.direction.x / ray.direction.z, 2));
            squared_waist.add(std::pow(ray.at((50 - ray.origin.z) / ray.direction.z).y, 2));
        }
        const double sine = kAperture / index;
        const double slope = 0.5 * sine / std::sqrt(1 - sine * sine);  // one sigma; the aperture is at 1/e^2, two
        EXPECT_LT(std::abs(z_score(squared_slope, slope * slope)), 5) << index;
        EXPECT_GT(std::abs(z_score(squared_slope, 1.05 * slope * slope)), 5) << index;
        EXPECT_LT(std::abs(z_score(squared_waist, 1)), 5) << index << ": radius 2 at 1/e^2";
    }
}

// Half space of index 1.5, isotropic, albedo 0.9: 4 % specular and 0.2199186 diffuse. Giovanelli, Opt. Acta 2 (1955)
// 153; more digits by adding-doubling.
TEST(Fluence, GiovanelliHalfSpaceKeepsSpecularApart) {
    SceneMedium medium = host(SlabRegion{2, 0}, 0.9, 0.1);
    medium.refractive_index = 1.5;
    const FluenceResult result = trace(scene_of({medium}, pencil({0, 0, -1}, {0, 0, 1})), 200000);
    const auto& front = result.share.excitation.escaped[4];
    EXPECT_LT(std::abs(z(front[0], 0.04)), 5);
    EXPECT_LT(std::abs(z(front[2], 0.2199185699)), 5);
    EXPECT_GT(std::abs(z(front[2], 0.26)), 5) << "the published value includes the specular part";
}

// A host and a dye with the same optics at both wavelengths, all isotropic: fluorescence is extra albedo. Half space,
// scattering 0.9, dye 0.08, yield 0.9, by the H-function.
FluenceResult cascade(double yield, std::optional<int> orders) {
    Scene scene =
        scene_of({host(SlabRegion{2, 0}, 0.9, 0.02), dye_in(SlabRegion{2, 0}, 0, 1)}, pencil({0, 0, -1}, {0, 0, 1}));
    scene.dyes = {flat_dye(0.08, 400, 700, 500, 600, yield)};
    scene.description.render.fluorescence_orders = orders;
    return trace(scene, 60000);
}

double z_of_emission(const FluenceResult& result, double expected) {
    const auto& front = result.share.emission.escaped[4];
    const double value = front[1].value + front[2].value;
    return (value - expected) / std::hypot(front[1].standard_error, front[2].standard_error);
}

// A half space in a half space, both of which are infinite: the inner index holds, in whatever order they are written.
TEST(Fluence, OfNestedHalfSpacesTheInnerIndexHolds) {
    const auto fresnel = [](double a, double b) { return std::pow((b - a) / (b + a), 2); };
    const double outer = fresnel(1, 1.1);
    const double inner = fresnel(1.1, 3);
    const double there_and_back = std::exp(-2 * 0.5);
    const double expected = (1 - outer) * (1 - outer) * inner * there_and_back / (1 - outer * inner * there_and_back);
    SceneMedium thin = host(SlabRegion{2, 0}, 0, 0.5);
    SceneMedium dense = host(SlabRegion{2, 1}, 0, 5);
    thin.refractive_index = 1.1;
    dense.refractive_index = 3;
    for (const bool inner_first : {false, true}) {
        const std::vector<SceneMedium> media =
            inner_first ? std::vector<SceneMedium>{dense, thin} : std::vector<SceneMedium>{thin, dense};
        const FluenceResult result = trace(scene_of(media, pencil({0, 0, -1}, {0, 0, 1})), 100000);
        EXPECT_LT(std::abs(z(result.share.excitation.escaped[4][1], expected)), 5) << inner_first;
    }
}

TEST(Fluence, CascadeOfFluorescenceIsExtraAlbedo) {
    const double excitation = 0.4149474791;
    const FluenceResult all = cascade(0.9, std::nullopt);
    EXPECT_LT(std::abs(z(all.share.excitation.escaped[4][2], excitation)), 5);
    EXPECT_LT(std::abs(z_of_emission(all, 0.6248877375 - excitation)), 5);
    EXPECT_LT(std::abs(z_of_emission(cascade(0.9, 1), 0.1313406881)), 5);
    EXPECT_GT(std::abs(z_of_emission(cascade(0.95, std::nullopt), 0.6248877375 - excitation)), 5);
}

// A clear slab of dye: what it absorbs, and what leaves through its front, in closed form (exponential integrals).
TEST(Fluence, ClearDyeGlowsAsItsAbsorptionSays) {
    const double mu = 1.3;
    const double depth = 1.7;
    Scene scene = scene_of({dye_in(SlabRegion{2, 0, depth}, 0, 1)}, pencil({0, 0, -1}, {0, 0, 1}));
    scene.dyes = {flat_dye(mu, 400, 490, kGreen, kGreen + 10, 0.8)};
    const FluenceResult result = trace(scene, 100000);
    const double taken = 1 - std::exp(-mu * depth);
    EXPECT_NEAR(result.share.excitation.absorbed[0].value, taken, 1e-12);
    EXPECT_NEAR(result.share.emission.launched.value, 0.8 * taken, 1e-12);
    EXPECT_LT(std::abs(z(result.share.emission.escaped[4][1], 0.4 * taken)), 5) << "half of it leaves each way";
    const double watts = result.watts.emission.launched.value;
    EXPECT_NEAR(watts / (0.8 * taken), kBlue / (kGreen + 5), 1e-3) << "each photon loses energy (Stokes)";
}

}  // namespace
}  // namespace fluovox::testing
