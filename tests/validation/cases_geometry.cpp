// Bodies, voxels and infinite media.

#include "fluovox/core/rng.h"

#include "scene_kit.h"
#include "validation/case.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace fluovox::validation {
namespace {

using testing::host;

/// The 60 mm cube of the MCX family of programs, in millimetres, which stop at 5 ns.
Case cube_case(const std::string& name, double index, Light light, double expected, double uncertainty) {
    SceneMedium cube = host(BoxRegion{{0, 0, 0}, {60, 60, 60}}, 1, 0.005, 0.01);
    if (index != 1) cube.refractive_index = index;
    Case result;
    result.name = "MCX " + name + ": absorbed";
    result.expected = expected;
    result.uncertainty = uncertainty;
    result.source = "MCX and umcx; several runs together";
    result.scene = scene_of({cube}, std::move(light));
    result.measure = absorbed_by(0);
    return result;
}

Light uniform_light() {
    Light light;
    light.shape = UniformLight{1};
    light.spectrum.lines = {{480, 1}};
    return light;
}

Case furnace_case(const std::string& name, SceneMedium body, double expected) {
    Case result;
    result.name = "mean path in uniform light: " + name;
    result.expected = expected;
    result.source = "4 V/S n^2; Blanco & Fournier 2003";
    result.scene = scene_of({std::move(body)}, uniform_light());
    result.measure = [](const FluenceResult& r) { return r.mean_path_um; };
    result.scale = 0;
    return result;
}

void add_furnaces(std::vector<Case>& cases) {
    const BoxRegion box{{0, 0, 0}, {1, 2, 3}};
    cases.push_back(furnace_case("box", host(box, 2, 0, 0.5), 4.0 * 6 / 22));
    SceneMedium glass = host(box, 4, 0, 0.5);
    glass.refractive_index = 1.37;
    cases.push_back(furnace_case("box of index 1.37", glass, 4.0 * 6 / 22 * 1.37 * 1.37));
    SceneMedium sphere = host(SphereRegion{{0, 0, 0}, 1}, 3, 0, 0.8);
    sphere.refractive_index = 1.33;
    cases.push_back(furnace_case("sphere of index 1.33", sphere, 4.0 / 3 * 1.33 * 1.33));
    Affine voxels;
    const auto noise = [](Voxel v) {
        Rng rng(7, static_cast<std::uint64_t>(v.x * 1000 + v.y), static_cast<std::uint64_t>(v.z));
        return 5 * std::pow(rng.uniform(), 3);
    };
    SceneMedium cloud = host(SparseGrid::from_function({0, 0, 0}, {12, 7, 9}, voxels, noise), 1, 0, 0.7);
    const Vec3 size = cloud.grid->bounds().size();
    cases.push_back(furnace_case("voxels of any scattering", std::move(cloud),
                                 2 * size.x * size.y * size.z / (size.x * size.y + size.y * size.z + size.z * size.x)));
}

/// The fluence rate around a point source, as what a thin shell absorbs.
Case point_case(const std::vector<std::string>& row) {
    constexpr double kHalfWidth = 0.01;
    const double scattering = std::stod(row[1]);
    const double absorption = std::stod(row[2]);
    const double r = std::stod(row[4]);
    std::vector<SceneMedium> media;
    const std::vector<Region> regions = {Everywhere{}, SphereRegion{{0, 0, 0}, (1 + kHalfWidth) * r},
                                         SphereRegion{{0, 0, 0}, (1 - kHalfWidth) * r}};
    for (std::size_t i = 0; i < regions.size(); ++i) {
        media.push_back(host(regions[i], scattering, absorption, std::stod(row[3])));
        for (std::size_t inner = i + 1; inner < regions.size(); ++inner)
            media.back().cut_by.push_back(static_cast<int>(inner));
    }
    const double volume =
        4.0 / 3 * std::numbers::pi * std::pow(r, 3) * (std::pow(1 + kHalfWidth, 3) - std::pow(1 - kHalfWidth, 3));
    const double factor = 1 / (absorption * volume);
    Case result;
    result.name =
        fmt::format("{} source: mu_s {}, mu_a {}, g {}: fluence at {}", row[0], row[1], row[2], row[3], row[4]);
    result.expected = std::stod(row[5]);
    result.uncertainty = std::stod(row[6]);
    result.source = row[7];
    result.scene = scene_of(std::move(media), testing::laser(PointLight{{0, 0, 0}}, 480, 1));
    result.measure = [factor](const FluenceResult& r_) {
        const Estimate& shell = r_.share.excitation.absorbed[1];
        return Estimate{factor * shell.value, factor * shell.standard_error};
    };
    result.scale = factor;
    result.aim = 1e-3 * result.expected;  // far below 3e-4 of the light launched
    return result;
}

}  // namespace

/// The van de Hulst slab as a wide grid of voxels. Its answer depends on the optical depth alone, which trilinear
/// voxels have exactly, so voxel size does not matter; 60 free paths of width are as good as infinite.
Case voxel_slab(const std::string& name, double angle, double majorant_factor, std::size_t measure) {
    constexpr double kThick = 0.25;
    constexpr double kWide = 0.5;
    Affine voxels;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    voxels.rows = {Vec3{kWide, 0, 0}, Vec3{0, c * kWide, -s * kThick}, Vec3{0, s * kWide, c * kThick}};
    SceneMedium slab =
        host(SparseGrid::from_function({-60, -60, 0}, {60, 60, 8}, voxels, [](Voxel) { return 1; }), 0.9, 0.1, 0.75);
    Case result;
    result.name = "van de Hulst slab in voxels, " + name;
    result.expected = measure == 0 ? 0.2416476612 : 0.0973946387;
    result.uncertainty = 1e-10;
    result.source = "as the slab";
    const Vec3 direction{0, -s, c};
    result.scene = scene_of({std::move(slab)}, normal_pencil(-2 * direction, direction));
    result.measure = measure == 0 ? absorbed_by(0) : leaves(4);
    result.settings.majorant_factor = majorant_factor;
    return result;
}

std::vector<Case> geometry_cases() {
    std::vector<Case> cases;
    cases.push_back(cube_case("cube60", 1, normal_pencil({29, 29, 0}), 0.177064, 0.000114));
    cases.push_back(cube_case("cube60b, index 1.37", 1.37, normal_pencil({29, 29, 1e-6}), 0.27225, 0.00019));
    cases.push_back(cube_case("cube60, isotropic source inside", 1, testing::laser(PointLight{{29, 29, 29}}, 480, 1),
                              0.885609, 0.000108));
    add_furnaces(cases);
    cases.push_back(voxel_slab("bounds as they are: A", 0, 1, 0));
    cases.push_back(voxel_slab("bounds 2 x too high: R", 0, 2, 1));
    cases.push_back(voxel_slab("bounds 10 x too high: A", 0, 10, 0));
    cases.push_back(voxel_slab("turned by 30 degrees: A", std::numbers::pi / 6, 1, 0));
    const auto rows = load_reference("point_sources.csv");
    for (std::size_t i = 1; i < rows.size(); ++i)
        cases.push_back(point_case(rows[i]));
    return cases;
}

}  // namespace fluovox::validation
