// Bodies of any shape: what holds whatever they scatter.

#include "fluovox/core/rng.h"
#include "fluovox/volume/grid_info.h"

#include "scene_kit.h"
#include "validation/case.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>

namespace fluovox::validation {
namespace {

using testing::dye_in;
using testing::host;

Light uniform_light() {
    Light light;
    light.shape = UniformLight{1};
    light.spectrum.lines = {{480, 1}};
    return light;
}

/// The neuron of volumes/neuron as a body that only scatters, strongly where its dye is dense.
Scene neuron_in_uniform_light() {
    const auto units = [](const GridMetadata&) { return GridScale{}; };
    SparseGrid cell = SparseGrid::load(FLUOVOX_SOURCE_DIR "/volumes/neuron/neuron.vdb", "EGFP", units);
    const double most = cell.max();
    return scene_of({host(std::move(cell), 0.5 / most, 0, 0.8)}, uniform_light());
}

/// Fluence over 4 pi L in cubes of 10 um, one number each.
std::vector<double> fluence_in_voxels(const Scene& scene, std::int64_t photons, std::uint64_t seed) {
    FluenceSettings settings;
    settings.photons = photons;
    settings.seed = seed;
    settings.grids = true;
    settings.voxel_um = 10;
    NoProgress progress;
    const BrickField grid = trace_fluence(scene, settings, progress).grids[0];
    // 1 W/m2/sr is 1e-6 W/mm2/sr.
    const double everywhere = 4 * std::numbers::pi * 1e-6;
    const Vec3 size = scene.media[0].grid->bounds().size();
    std::vector<double> values;
    for (std::size_t i = 0; i < grid.values.size(); ++i) {
        const Voxel brick = grid.bricks[i / 512];
        const auto in = static_cast<int>(i % 512);
        const Vec3 end =
            10.0 * Vec3{brick.x + (in >> 6) + 1.0, brick.y + ((in >> 3) & 7) + 1.0, brick.z + (in & 7) + 1.0};
        if (end.x > size.x || end.y > size.y || end.z > size.z) continue;  // reaches out of the box
        values.push_back(static_cast<double>(grid.values[i]) / everywhere);
    }
    return values;
}

/// Runs with other seeds tell how much each voxel scatters about one.
Case neuron_fluence(bool worst_voxel) {
    Case result;
    result.name = worst_voxel ? "uniform light in a neuron: the voxel furthest from 4 pi L (as a deviation)"
                              : "uniform light in a neuron: fluence over 4 pi L, mean of all voxels";
    result.expected = worst_voxel ? 0 : 1;
    result.source = "invariance: the radiance is that of the surround everywhere";
    result.fixed = worst_voxel ? 500000 : 100000;
    result.many = worst_voxel;
    result.estimate = [worst_voxel](std::int64_t photons, std::uint64_t seed) {
        constexpr int kRuns = 24;
        const Scene scene = neuron_in_uniform_light();
        std::vector<double> sum;
        std::vector<double> squares;
        std::size_t voxels = 0;
        const Estimate mean = mean_of_runs(kRuns, seed, [&](std::uint64_t run) {
            const std::vector<double> values = fluence_in_voxels(scene, photons, run);
            voxels = values.size();
            sum.resize(voxels, 0);
            squares.resize(voxels, 0);
            double all = 0;
            for (std::size_t i = 0; i < voxels; ++i) {
                sum[i] += values[i];
                squares[i] += values[i] * values[i];
                all += values[i];
            }
            return all / static_cast<double>(voxels);
        });
        if (!worst_voxel) return mean;
        double worst = 0;
        for (std::size_t i = 0; i < voxels; ++i) {
            const double average = sum[i] / kRuns;
            const double variance = (squares[i] / kRuns - average * average) / (kRuns - 1);
            worst = std::max(worst, std::abs(average - 1) / std::sqrt(variance));
        }
        return deviation_of_largest(worst, static_cast<double>(voxels), kRuns - 1);
    };
    return result;
}

Case neuron_path() {
    Case result;
    result.name = "uniform light in a neuron: mean path";
    result.scene = neuron_in_uniform_light();
    const Vec3 size = result.scene.media[0].grid->bounds().size();
    result.expected = 2 * size.x * size.y * size.z / (size.x * size.y + size.y * size.z + size.z * size.x);
    result.source = "4 V/S; Blanco & Fournier 2003";
    result.scale = 0;
    result.measure = [](const FluenceResult& r) { return r.mean_path_um; };
    return result;
}

/// The same within a box of another index, which scatters a little everywhere: what is totally reflected must get out.
Case neuron_in_index_path() {
    constexpr double kIndex = 1.33;
    Case result;
    result.name = "uniform light in a neuron in a box of index 1.33: mean path";
    result.scene = neuron_in_uniform_light();
    const Bounds cell = result.scene.media[0].grid->bounds();
    const BoxRegion box{cell.min - Vec3{5, 5, 5}, cell.max + Vec3{5, 5, 5}};
    SceneMedium around = host(box, 0.02, 0, 0.5);
    around.refractive_index = kIndex;
    result.scene.media.push_back(around);
    const Vec3 size = box.max - box.min;
    result.expected =
        2 * size.x * size.y * size.z / (size.x * size.y + size.y * size.z + size.z * size.x) * kIndex * kIndex;
    result.source = "4 V/S n^2; Blanco & Fournier 2003; Martelli et al. 2021";
    result.scale = 0;
    result.measure = [](const FluenceResult& r) { return r.mean_path_um; };
    return result;
}

/// Over the whole of the lower or upper face of the box below, whose voxels reach half a voxel out.
Light face_light(bool from_below) {
    RectangleLight light;
    light.center = {4, 4, from_below ? -0.5 : 8.5};
    light.normal = {0, 0, from_below ? 1.0 : -1.0};
    light.up = {0, 1, 0};
    light.width_um = light.height_um = 9;
    return testing::laser(light, 480, 1);
}

/// A cube of noise, denser to one side, between two faces; with `dye`, fluorescence instead of the light itself, and
/// `swapped` exchanges what the medium does at the two wavelengths.
Scene lopsided(bool from_below, bool dye, bool swapped) {
    const auto noise = [](std::uint64_t key, bool steep) {
        return [key, steep](Voxel v) {
            Rng rng(key, static_cast<std::uint64_t>(v.x * 100 + v.y), static_cast<std::uint64_t>(v.z));
            return rng.uniform() * (steep ? 0.1 + 0.3 * v.z : 1.0);
        };
    };
    Affine half;  // centres at 0.5, 1.5 ... 7.5
    half.offset = {0.5, 0.5, 0.5};
    const auto grid = [&](std::uint64_t key, bool steep) {
        return SparseGrid::from_function({0, 0, 0}, {8, 8, 8}, half, noise(key, steep));
    };
    std::array<double, 2> scattering = {0.6, 0.25};
    std::array<double, 2> absorption = {0.012, 0.025};
    if (swapped) {
        std::swap(scattering[0], scattering[1]);
        std::swap(absorption[0], absorption[1]);
    }
    SceneMedium body = host(grid(1, true), 0, 0, 0.6);
    body.scattering = Spectrum({480, 500}, {scattering[0], scattering[1]});
    body.absorption = Spectrum({480, 500}, {absorption[0], absorption[1]});
    Scene scene = scene_of({body}, face_light(from_below));
    if (!dye) return scene;
    scene.media.push_back(dye_in(grid(2, false), 0));
    // Weak, so that absorbing only the light of the lamp does not break the symmetry.
    scene.dyes = {testing::flat_dye(1e-6, 400, 490, 500, 600, 1)};
    return scene;
}

/// What comes out of the other face for light from one, less that for light from the other; of a dye's light, as a
/// share of what the dye gives back.
Case reciprocity_case(bool dye) {
    constexpr int kBottom = 4;
    constexpr int kTop = 5;
    Case result;
    result.name = dye ? "reciprocity: fluorescence through a lopsided body less that from behind, wavelengths exchanged"
                      : "reciprocity: light through a lopsided body less that from behind";
    result.source = "the same, source and detector swapped";
    const auto trace = [](const Scene& scene, std::int64_t photons, std::uint64_t seed) {
        FluenceSettings settings;
        settings.photons = photons;
        settings.seed = seed;
        NoProgress progress;
        return trace_fluence(scene, settings, progress).share;
    };
    result.fixed = dye ? 8000000 : 4000000;
    result.estimate = [trace, dye](std::int64_t photons, std::uint64_t seed) {
        const EnergyBudget up = trace(lopsided(true, dye, false), photons, seed);
        const EnergyBudget down = trace(lopsided(false, dye, dye), photons, seed + 50);
        const Estimate there = (dye ? up.emission : up.excitation).not_specular[kTop];
        const Estimate back = (dye ? down.emission : down.excitation).not_specular[kBottom];
        const double unit = dye ? up.emission.launched.value : 1;
        return Estimate{(there.value - back.value) / unit,
                        std::hypot(there.standard_error, back.standard_error) / unit};
    };
    return result;
}

/// Exponential integral E2(x) = Int_0^1 exp(-x/t) dt by the midpoint rule.
double e2(double x) {
    constexpr int kSteps = 20000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        sum += std::exp(-x * kSteps / (i + 0.5));
    return sum / kSteps;
}

/// Light out of the front of a clear slab of dye, over its concentration: straight, then saturating.
Case brightness_case(double concentration) {
    constexpr double kYield = 0.8;
    constexpr double kAbsorbsItself = 0.1;
    Scene scene = scene_of({dye_in(SlabRegion{2, 0, 1}, 0, concentration)}, normal_pencil({0, 0, -1e-3}));
    Dye dye = testing::flat_dye(1, 400, 490, 500, 600, kYield);
    const double peak = dye.molar_absorption_per_M_cm.max();
    dye.molar_absorption_per_M_cm =
        Spectrum({400, 490, 491, 700}, {peak, peak, kAbsorbsItself * peak, kAbsorbsItself * peak});
    scene.dyes = {dye};
    double sum = 0;
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps; ++i) {
        const double z = (i + 0.5) / kSteps;
        sum += std::exp(-concentration * z) * e2(kAbsorbsItself * concentration * z) / kSteps;
    }
    Case result;
    result.name =
        fmt::format("clear slab of dye, {} absorption lengths deep: front, over its concentration", concentration);
    result.expected = 0.5 * kYield * sum;
    result.uncertainty = 3e-6;
    result.source = "integral of exp and E2";
    result.scene = std::move(scene);
    result.scale = 1 / concentration;
    result.measure = [concentration](const FluenceResult& r) {
        const Estimate& front = r.share.emission.not_specular[4];
        return Estimate{front.value / concentration, front.standard_error / concentration};
    };
    result.finer = concentration < 0.1 ? 10 : 1;
    return result;
}

}  // namespace

std::vector<Case> body_cases() {
    std::vector<Case> cases;
    cases.push_back(neuron_path());
    cases.push_back(neuron_in_index_path());
    cases.push_back(neuron_fluence(false));
    cases.push_back(neuron_fluence(true));
    cases.push_back(reciprocity_case(false));
    cases.push_back(reciprocity_case(true));
    for (const double concentration : {0.01, 0.3, 3.0, 30.0})
        cases.push_back(brightness_case(concentration));
    return cases;
}

}  // namespace fluovox::validation
