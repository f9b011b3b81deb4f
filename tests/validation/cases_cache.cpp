// What keeping excitation by voxels costs: pictures with a cache against those without, over the size of the voxels.

#include "fluovox/volume/sparse_grid.h"

#include "scene_kit.h"
#include "validation/case.h"
#include "validation/picture.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <utility>

namespace fluovox::validation {
namespace {

using testing::dye_in;
using testing::host;

constexpr int kFluorescenceLayer = 2;
constexpr double kRadius_um = 36;
constexpr Vec3 kCenter{50, 50, 50};

/// A ball of dye that is dense in some places and thin in others, in voxels of `h` um.
SparseGrid ball(double h) {
    Affine world_from_index;
    for (Vec3& row : world_from_index.rows)
        row = h * row;
    world_from_index.offset = kCenter;
    const int reach = static_cast<int>(std::ceil(kRadius_um / h)) + 1;
    return SparseGrid::from_function(
        {-reach, -reach, -reach}, {reach + 1, reach + 1, reach + 1}, world_from_index, [h](Voxel v) {
            const Vec3 p = h * Vec3{1.0 * v.x, 1.0 * v.y, 1.0 * v.z};
            return length(p) < kRadius_um ? 1 + 0.9 * std::sin(p.x / 4) * std::cos(p.y / 3) : 0.0;
        });
}

/// That dye in forward-scattering tissue under a sheet of 20 um, seen from above in one pixel.
Scene in_tissue(SceneMedium dye) {
    SheetLight sheet;
    sheet.position = sheet.waist = {-10, 50, 50};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 80;
    sheet.thickness_um = 20;
    Scene scene = scene_of({host(BoxRegion{{0, 0, 0}, {100, 100, 100}}, 0.04, 0.001, 0.8), std::move(dye)},
                           testing::laser(sheet, 488, 1e-3));
    scene.dyes = {testing::flat_dye(0.01, 400, 500, 520, 600, 0.8)};
    scene.description.camera = testing::one_pixel({50, 50, 200}, {50, 50, 60}, {0, 1, 0}, 90, 0.2);
    scene.description.film = testing::spectrometer(510, 610, 1);
    return scene;
}

Estimate brightness(const Scene& scene, const char* estimator, std::int64_t samples, std::uint64_t seed) {
    return mean_of_runs(16, seed, [&](std::uint64_t run) {
        return picture(scene, estimator, samples / 16, run).mean_of_all(kFluorescenceLayer, 0);
    });
}

Estimate ratio(const Estimate& a, const Estimate& b) {
    const double value = a.value / b.value;
    return {value, value * std::hypot(a.standard_error / a.value, b.standard_error / b.value)};
}

/// Where a dye has voxels, the cache has the same; how large they are should not matter.
Case own_voxels_case(double h) {
    Case result;
    result.name = fmt::format("cached over light: dye in voxels of {} um", h);
    result.expected = 1;
    result.source = "the estimator without a cache";
    result.fixed = 8000000;
    result.reaches_sensor = std::make_shared<double>(0);
    result.estimate = [h, reaches = result.reaches_sensor](std::int64_t samples, std::uint64_t seed) {
        const Scene scene = in_tissue(dye_in(ball(h), 0));
        const Estimate light = brightness(scene, "light", samples, seed);
        *reaches = share_on_sensor(scene, light.value);
        return ratio(brightness(scene, "cached", samples / 8, seed + 50), light);
    };
    return result;
}

/// A dye in a region has voxels of the cache only: the error against their size is plotted; the case is the smallest.
Case region_case(const std::shared_ptr<PlotBook>& plots) {
    Case result;
    result.name = "cached over light: ball of dye as a region, cache voxels of 1 um";
    result.expected = 1;
    result.source = "the estimator without a cache";
    result.fixed = 8000000;
    result.reaches_sensor = std::make_shared<double>(0);
    result.estimate = [plots, reaches = result.reaches_sensor](std::int64_t samples, std::uint64_t seed) {
        Scene scene = in_tissue(dye_in(SphereRegion{kCenter, kRadius_um}, 0, 1));
        const Estimate light = brightness(scene, "light", samples, seed);
        *reaches = share_on_sensor(scene, light.value);
        PlotCurve curve{"total, relative to no cache", {}, {}, {}, {0.1, 0.35, 0.7}};
        Estimate last;
        for (const double h : {36.0, 24.0, 12.0, 6.0, 3.0, 1.0}) {
            scene.description.render.cache_voxel_um = h;
            last = ratio(brightness(scene, "cached", samples / 8, seed + 50 + static_cast<std::uint64_t>(h)), light);
            curve.x.push_back(h);
            curve.y.push_back(100 * (last.value - 1));
            curve.error.push_back(100 * last.standard_error);
        }
        Plot plot;
        plot.title = "What the voxels of a cache cost";
        plot.subtitle = "all light of a ball of dye (radius 36 um) in forward-scattering tissue under a sheet of 20 um";
        plot.x_label = "cache voxel, um";
        plot.y_label = "error of the total, %";
        plot.curves = {curve};
        plots->push_back({"cache-voxel", plot});
        return last;
    };
    return result;
}

}  // namespace

std::vector<Case> cache_cases(const std::shared_ptr<PlotBook>& plots) {
    return {own_voxels_case(8), own_voxels_case(2), region_case(plots)};
}

}  // namespace fluovox::validation
