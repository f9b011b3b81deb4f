// Dyes: exact budgets with and without scattering.

#include "scene_kit.h"
#include "validation/case.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace fluovox::validation {
namespace {

using testing::dye_in;
using testing::flat_dye;
using testing::host;

constexpr double kExcitation_nm = 480;  // of every light here
constexpr double kEmitFrom_nm = 500, kEmitTo_nm = 600;
constexpr int kFront = 4, kBack = 5;

/// One value where the light is, another where the dye glows.
Coefficient two_colours(double excitation, double emission) {
    return Spectrum({kExcitation_nm, kEmitFrom_nm}, {excitation, emission});
}

/// A host and a dye that absorbs only the light of the lamp, in the same region.
struct Tissue {
    double absorption_x = 0, scattering_x = 0;  // the dye's part of the absorption included
    double absorption_m = 0, scattering_m = 0;
    double dye = 0, yield = 0, g = 0, index = 1;
};

Scene tissue_scene(const Tissue& tissue, const Region& region, Light light) {
    SceneMedium medium = host(region, 0, 0, tissue.g);
    medium.scattering = two_colours(tissue.scattering_x, tissue.scattering_m);
    medium.absorption = two_colours(tissue.absorption_x - tissue.dye, tissue.absorption_m);
    if (tissue.index != 1) medium.refractive_index = tissue.index;
    Scene scene = scene_of({medium, dye_in(region, 0, 1)}, std::move(light));
    scene.dyes = {flat_dye(tissue.dye, 400, 490, kEmitFrom_nm, kEmitTo_nm, tissue.yield)};
    return scene;
}

Case of(const std::string& name, double expected, double uncertainty, const std::string& source, Scene scene,
        std::function<Estimate(const FluenceResult&)> measure) {
    Case result;
    result.name = name;
    result.expected = expected;
    result.uncertainty = uncertainty;
    result.source = source;
    result.scene = std::move(scene);
    result.measure = std::move(measure);
    return result;
}

void add_clear_slabs(std::vector<Case>& cases) {
    const double ln10 = std::numbers::ln10;
    const auto slab = [&](double excitation, double emission, double depth) {
        Tissue tissue;
        tissue.absorption_x = tissue.dye = excitation;
        tissue.absorption_m = emission;
        tissue.yield = 0.9;
        return tissue_scene(tissue, SlabRegion{2, 0, depth}, normal_pencil({0, 0, -1e-3}));
    };
    const char* closed = "closed form with exponential integrals";
    cases.push_back(of("clear cuvette, absorbance 1 and 0.1: front", 0.32175761408, 1e-10, closed,
                       slab(ln10, 0.1 * ln10, 1), fluorescence_leaves(kFront)));
    cases.push_back(of("clear cuvette, absorbance 3 and 1: back", 0.02026230659, 1e-10, closed, slab(3 * ln10, ln10, 1),
                       fluorescence_leaves(kBack)));
    cases.push_back(of("clear half space, absorbance 2 and 0.5: front", 0.26893823485, 1e-10, closed,
                       slab(2 * ln10, 0.5 * ln10, 1e6), fluorescence_leaves(kFront)));
    cases.push_back(watts_case(true));
}

void add_tissues(std::vector<Case>& cases) {
    const char* source = "discrete ordinates; escape by reciprocity";
    const Tissue thin{0.2, 10, 0.05, 8, 0.1, 0.5, 0, 1};
    const auto slab = [&] { return tissue_scene(thin, SlabRegion{2, 0, 1}, normal_pencil({0, 0, -1e-4})); };
    cases.push_back(of("tissue slab: absorbed by the dye", 0.13860499156, 1e-8, source, slab(), absorbed_by(1)));
    cases.push_back(of("tissue slab: fluorescence out of the front", 0.04096438573, 1e-8, source, slab(),
                       fluorescence_leaves(kFront)));
    cases.push_back(of("tissue slab: fluorescence out of the back", 0.01926949922, 1e-8, source, slab(),
                       fluorescence_leaves(kBack)));
    const Tissue deep{0.5, 100, 0.1, 80, 0.4, 0.79, 0.9, 1.37};
    const auto half_space = [&] { return tissue_scene(deep, SlabRegion{2, 0}, normal_pencil({0, 0, -1e-5})); };
    cases.push_back(
        of("tissue of index 1.37: excitation reflected", 0.37141399075, 1e-8, source, half_space(), leaves(kFront)));
    cases.back().scene.description.render.fluorescence_orders = 0;  // which costs most
    cases.push_back(of("tissue of index 1.37: fluorescence out of the front", 0.19889451248, 1e-8, source, half_space(),
                       fluorescence_leaves(kFront)));
}

/// All emission in an infinite medium: what is absorbed of it is what was emitted, wherever it is absorbed.
Case infinite_integral_case() {
    const Tissue tissue{0.4, 6, 0.09, 5, 0.25, 0.6, 0.5, 1};
    Scene scene = tissue_scene(tissue, Everywhere{}, testing::laser(PointLight{{0, 0, 0}}, kExcitation_nm, 1));
    const double factor = 1 / tissue.absorption_m;
    Case result = of("point source in dyed tissue: emission fluence over all space",
                     tissue.yield * tissue.dye / (tissue.absorption_x * tissue.absorption_m), 0,
                     "yield x dye / (absorption x absorption)", std::move(scene), [factor](const FluenceResult& got) {
                         const Estimate& all = got.share.emission.absorbed[0];
                         return Estimate{factor * all.value, factor * all.standard_error};
                     });
    result.scale = factor;
    return result;
}

/// Emission fluence around a point source in an infinite medium, as what a thin shell absorbs of it.
Case infinite_case(double r, double expected) {
    constexpr double kHalfWidth = 0.02;
    const Tissue tissue{0.2, 10, 0.05, 8, 0.1, 0.5, 0, 1};
    Scene scene = tissue_scene(tissue, Everywhere{}, testing::laser(PointLight{{0, 0, 0}}, kExcitation_nm, 1));
    const SceneMedium all = scene.media[0];
    for (const double radius : {(1 + kHalfWidth) * r, (1 - kHalfWidth) * r}) {
        scene.media.push_back(all);
        scene.media.back().region = SphereRegion{{0, 0, 0}, radius};
    }
    scene.media[0].cut_by = {2, 3};
    scene.media[2].cut_by = {3};
    const double volume =
        4.0 / 3 * std::numbers::pi * std::pow(r, 3) * (std::pow(1 + kHalfWidth, 3) - std::pow(1 - kHalfWidth, 3));
    const double factor = 1 / (tissue.absorption_m * volume);
    Case result = of(fmt::format("point source in dyed tissue: emission fluence at {}", r), expected, 1e-8,
                     "Fourier integral of two exact kernels", std::move(scene), [factor](const FluenceResult& got) {
                         const Estimate& shell = got.share.emission.absorbed[2];
                         return Estimate{factor * shell.value, factor * shell.standard_error};
                     });
    result.scale = factor;
    result.aim = 1.5e-3 * expected;
    return result;
}

}  // namespace

/// Equal optics at both wavelengths: fluorescence is extra albedo.
Case cascade_case(double scattering, double dye, double yield, std::optional<int> orders, double expected) {
    Scene scene = scene_of({host(SlabRegion{2, 0}, scattering, 1 - scattering - dye), dye_in(SlabRegion{2, 0}, 0, 1)},
                           normal_pencil({0, 0, -1e-3}));
    scene.dyes = {flat_dye(dye, 400, 700, kEmitFrom_nm, kEmitTo_nm, yield)};
    scene.description.render.fluorescence_orders = orders;
    return of(fmt::format("cascade in a half space, albedo {}, dye {}, yield {}: {}", scattering, dye, yield,
                          !orders        ? "all generations"
                          : *orders == 1 ? "first generation"
                                         : "first two generations"),
              expected, 1e-9, "H-function: fluorescence is extra albedo", std::move(scene),
              fluorescence_leaves(kFront));
}

Case watts_case(bool with_stokes) {
    Tissue tissue;
    tissue.absorption_x = tissue.dye = std::numbers::ln10;
    tissue.yield = 0.9;
    const double photons = 0.9 * (1 - std::exp(-std::numbers::ln10));
    const double stokes = kExcitation_nm * std::log(kEmitTo_nm / kEmitFrom_nm) / (kEmitTo_nm - kEmitFrom_nm);
    return of("clear cuvette: watts of fluorescence (Stokes)", photons * stokes, 0, "closed form",
              tissue_scene(tissue, SlabRegion{2, 0, 1}, normal_pencil({0, 0, -1e-3})),
              [with_stokes](const FluenceResult& r) {
                  // Without it, photons would be counted as if they kept their energy.
                  return with_stokes ? r.watts.emission.launched : r.share.emission.launched;
              });
}

std::vector<Case> fluorescence_cases() {
    std::vector<Case> cases;
    add_clear_slabs(cases);
    cases.push_back(cascade_case(0.9, 0.08, 0.9, 1, 0.1313406881));
    cases.push_back(cascade_case(0.9, 0.08, 0.9, std::nullopt, 0.6248877375 - 0.4149474791));
    cases.push_back(cascade_case(0.5, 0.4, 0.5, 1, 0.0709439884));
    cases.push_back(cascade_case(0.5, 0.4, 0.5, std::nullopt, 0.2086799521 - 0.1152258777));
    cases.push_back(cascade_case(0.3, 0.6, 0.95, 2, 0.2028508));
    add_tissues(cases);
    cases.push_back(infinite_case(0.5, 0.34906490202));
    cases.push_back(infinite_integral_case());
    return cases;
}

}  // namespace fluovox::validation
