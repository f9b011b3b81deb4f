// The figure with which the model was published: spectra of cuvettes, thin and thick; and beads of known amount.

#include "fluovox/image/response.h"
#include "fluovox/medium/dye_library.h"
#include "fluovox/spectral/photons.h"
#include "fluovox/transport/render.h"

#include "scene_kit.h"
#include "validation/case.h"
#include "validation/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace fluovox::validation {

double launched_W(const Scene& scene) {
    double sum = 0;
    for (const Light& light : scene.lights)
        sum += light.power_W;
    return sum;
}

double share_on_sensor(const Scene& scene, double radiance) {
    const Camera& camera = scene.description.camera;
    const FilmSpec& film = scene.description.film;
    constexpr double kPerM2 = 1e12;
    const double area_m2 = camera.field_um * camera.field_um * camera.width / camera.height / kPerM2;
    const double bin_nm = (film.to_nm - film.from_nm) / static_cast<double>(film.channels.size());
    return radiance * area_m2 * std::numbers::pi * std::pow(camera.numerical_aperture, 2) * bin_nm / launched_W(scene);
}

Film picture(Scene scene, const std::string& estimator, std::int64_t samples, std::uint64_t seed) {
    scene.description.render.estimator = estimator;
    scene.description.render.samples = static_cast<int>(samples);
    scene.description.render.seed = seed;
    NoProgress progress;
    return render(scene, progress).film;
}

Scene specimen(const std::string& name, const std::vector<std::string>& overrides) {
    return build_scene(load_scene_description(FLUOVOX_SOURCE_DIR "/volumes/" + name + "/scene.toml", overrides));
}

namespace {

/// The whole picture as one pixel: each photon of `light` is one sample of one wavelength, so bins are independent.
Scene cuvette(const std::string& name, const std::string& concentration) {
    return specimen(name, {"medium.0.concentration=" + concentration, "camera.resolution=[1,1]"});
}

struct Response {
    std::vector<double> nm, value, error, emission;  // normalised to unit area
    double deviation = 0;                            // of the shapes, chi-squared
    int bins = 0;
};

Response response_of(const Scene& scene, std::int64_t photons, std::uint64_t seed) {
    const Film film = picture(scene, "light", photons, seed);
    const FilmSpec& spec = scene.description.film;
    const double width = (spec.to_nm - spec.from_nm) / film.channels();
    const std::vector<double> emission = emission_on_film(scene.dyes[0].emission_per_nm, spec);
    Response response;
    std::vector<double> value;
    for (int bin = 0; bin < film.channels(); ++bin)
        value.push_back(film.mean(2, 0, bin));
    double area = 0;
    for (const double v : value)
        area += v * width;
    response.value = normalized(value, width);
    response.emission = normalized(emission, width);
    const double brightest = *std::max_element(response.emission.begin(), response.emission.end());
    // The scale is fitted, weighted by the errors.
    double over = 0;
    double under = 0;
    for (int bin = 0; bin < film.channels(); ++bin) {
        const auto i = static_cast<std::size_t>(bin);
        const double variance = film.variance_of_mean(2, 0, bin);
        response.nm.push_back(spec.from_nm + (bin + 0.5) * width);
        response.error.push_back(std::sqrt(variance) / area);
        if (!(variance > 0) || response.emission[i] < 0.02 * brightest) continue;
        over += value[i] * response.emission[i] / variance;
        under += response.emission[i] * response.emission[i] / variance;
    }
    for (int bin = 0; bin < film.channels(); ++bin) {
        const auto i = static_cast<std::size_t>(bin);
        const double variance = film.variance_of_mean(2, 0, bin);
        // Bins with few photons are no normal distribution.
        constexpr double kFew = 0.02;
        const double expected = over / under * response.emission[i];
        if (!(variance > 0) || response.emission[i] < kFew * brightest) continue;
        response.deviation += std::pow(value[i] - expected, 2) / (variance * expected / value[i]);
        ++response.bins;
    }
    return response;
}

Plot plot_of(const Response& response, const std::string& title) {
    Plot plot;
    plot.title = title;
    plot.subtitle = "highly scattering cuvette; unit area; red: response minus emission, with its standard error";
    plot.x_label = "wavelength, nm";
    plot.y_label = "per nm";
    plot.x_is_wavelength = true;
    plot.curves.push_back({"emission of the dye", response.nm, response.emission, {}, {0.4, 0.4, 0.4}, true});
    plot.curves.push_back({"response", response.nm, response.value, response.error, {0.1, 0.35, 0.7}});
    PlotCurve residual{"difference", response.nm, {}, response.error, {0.8, 0.1, 0.1}};
    for (std::size_t i = 0; i < response.nm.size(); ++i)
        residual.y.push_back(response.value[i] - response.emission[i]);
    plot.curves.push_back(residual);
    return plot;
}

Case thin_case(const std::string& name, const std::string& dye, const std::shared_ptr<PlotBook>& plots) {
    Case result;
    result.name = fmt::format("published cuvette of {}, 0.02 uM: response against emission (deviation)", dye);
    result.source = "thin, the response is the emission whatever scatters";
    result.fixed = 1000000;  // with fewer, the bins are too far from a normal distribution
    result.many = true;
    result.estimate = [=](std::int64_t photons, std::uint64_t seed) {
        const Response response = response_of(cuvette(name, "0.02 uM"), photons, seed);
        plots->push_back({name + "-thin", plot_of(response, dye + ", 0.02 uM: thin")});
        return deviation_of(response.deviation, response.bins - 1);
    };
    return result;
}

double mean_nm(const Film& film, const FilmSpec& spec) {
    double sum = 0;
    double all = 0;
    for (int bin = 0; bin < film.channels(); ++bin) {
        const double value = film.mean(2, 0, bin);
        sum += value * spec.channels[static_cast<std::size_t>(bin)].center_nm;
        all += value;
    }
    return sum / all;
}

/// Thick, there is no closed form: the mean wavelength by one estimator against the other's.
Case thick_case(const std::string& name, const std::string& dye, const std::shared_ptr<PlotBook>& plots) {
    Case result;
    result.name = fmt::format("published cuvette of {}, 20 uM: mean wavelength, path less light, nm", dye);
    result.source = "the other estimator";
    result.fixed = 60000;
    result.scale = 0;
    result.size = 510;  // about the wavelengths themselves
    result.estimate = [=](std::int64_t samples, std::uint64_t seed) {
        const Scene scene = cuvette(name, "20 uM");
        plots->push_back(
            {name + "-thick", plot_of(response_of(scene, 12 * samples, seed + 1), dye + ", 20 uM: thick")});
        const auto with = [&](const char* estimator, std::uint64_t key) {
            return mean_of_runs(12, key, [&](std::uint64_t run) {
                return mean_nm(picture(scene, estimator, samples, run), scene.description.film);
            });
        };
        const Estimate path = with("path", seed);
        const Estimate light = with("light", seed + 20);
        return Estimate{path.value - light.value, std::hypot(path.standard_error, light.standard_error)};
    };
    return result;
}

/// Balls of dye beside each other under even light, one in each pixel: photons over what their amount of dye gives.
struct Beads {
    static constexpr int kBeads = 6;
    static constexpr double kApart_um = 20, kRadius_um = 5;
    Scene scene;
    std::array<double, kBeads> amount_uM_um3{};
    double photons_per_amount = 0;

    Beads() {
        const auto concentration = [](int bead) { return 0.02 * std::pow(1.8, bead); };
        Affine half;
        half.rows = {Vec3{0.5, 0, 0}, Vec3{0, 0.5, 0}, Vec3{0, 0, 0.5}};
        const auto value = [&](Voxel v) {
            const Vec3 p{0.5 * v.x, 0.5 * v.y, 0.5 * v.z};
            const int bead = static_cast<int>(std::floor(p.x / kApart_um));
            if (bead < 0 || bead >= kBeads) return 0.0;
            const Vec3 center{(bead + 0.5) * kApart_um, 0, 0};
            return length(p - center) < kRadius_um ? concentration(bead) : 0.0;
        };
        SparseGrid grid = SparseGrid::from_function({0, -12, -12}, {2 * 20 * kBeads, 13, 13}, half, value);
        for (int x = 0; x < 2 * 20 * kBeads; ++x) {
            for (int y = -12; y < 13; ++y) {
                for (int z = -12; z < 13; ++z)
                    amount_uM_um3.at(static_cast<std::size_t>(x / 40)) +=
                        static_cast<double>(grid.value({x, y, z})) * 0.125;
            }
        }
        SheetLight sheet;
        sheet.position = sheet.waist = {0.5 * kApart_um * kBeads, 0, -50};
        sheet.direction = {0, 0, 1};
        sheet.normal = {1, 0, 0};
        sheet.width_um = 40;
        sheet.thickness_um = 200;
        sheet.profile = BeamProfile::Box;
        scene = scene_of({dye_in_grid(std::move(grid))}, testing::laser(sheet, 488, 1e-3));
        scene.dyes = {find_dye("EGFP")->dye};
        Camera camera = testing::one_pixel({0.5 * kApart_um * kBeads, -100, 0}, {0.5 * kApart_um * kBeads, 0, 0},
                                           {0, 0, 1}, kApart_um);
        camera.width = kBeads;
        scene.description.camera = camera;
        scene.description.film = testing::spectrometer(480, 680, 1);
        scene.description.film.unit = FilmUnit::Photons;
        const Dye& dye = scene.dyes[0];
        const double irradiance = photons_per_second(1e-3, 488) / (40.0 * 200);
        photons_per_amount = irradiance * absorption_per_um_per_uM(dye, 488) * dye.quantum_yield *
                             dye.emission_per_nm.integral(480, 680) / 200 / (4 * std::numbers::pi) /
                             (kApart_um * kApart_um) * 1e12;
    }
    static SceneMedium dye_in_grid(SparseGrid grid) { return testing::dye_in(std::move(grid), 0); }
};

Case beads_case(bool straight, const std::shared_ptr<PlotBook>& plots) {
    Case result;
    result.name = straight ? "beads: photons against amounts lie on a straight line (chi-squared as a deviation)"
                           : "beads: photons over what the amount of dye gives";
    result.expected = straight ? 0 : 1;
    result.uncertainty = straight ? 0 : 3e-5;  // the light that beads take from themselves
    result.source = "what was put in";
    result.fixed = 1800000;
    result.many = straight;
    result.scale = 0;
    result.estimate = [=](std::int64_t samples, std::uint64_t seed) {
        const Beads beads;
        const Film film = picture(beads.scene, "path", samples, seed);
        PlotCurve line{"what was put in", {}, {}, {}, {0.4, 0.4, 0.4}, true};
        PlotCurve got{"measured", {}, {}, {}, {0.1, 0.35, 0.7}};
        double over = 0;
        double under = 0;
        const auto z_of = [&](int bead, double slope) {
            const auto i = static_cast<std::size_t>(bead);
            const double expected = beads.amount_uM_um3.at(i) * beads.photons_per_amount;
            return (film.mean(2, bead, 0) - slope * expected) / std::sqrt(film.variance_of_mean(2, bead, 0));
        };
        for (int bead = 0; bead < Beads::kBeads; ++bead) {
            const auto i = static_cast<std::size_t>(bead);
            const double expected = beads.amount_uM_um3.at(i) * beads.photons_per_amount;
            const double variance = film.variance_of_mean(2, bead, 0);
            over += film.mean(2, bead, 0) * expected / variance;
            under += expected * expected / variance;
            constexpr double kMol = 1e-6 * 1e-15;  // of 1 uM um3
            line.x.push_back(1e18 * kMol * beads.amount_uM_um3.at(i));
            got.x = line.x;
            line.y.push_back(1e-15 * expected);
            got.y.push_back(1e-15 * film.mean(2, bead, 0));
        }
        const double slope = over / under;
        if (!straight) return Estimate{slope, 1 / std::sqrt(under)};
        Plot plot;
        plot.title = "Photons of six beads against the dye in them";
        plot.x_label = "dye, amol";
        plot.y_label = "1e15 photons / s / m2 / sr / nm";
        plot.curves = {line, got};
        plots->push_back({"beads", plot});
        double squares = 0;
        for (int bead = 0; bead < Beads::kBeads; ++bead)
            squares += std::pow(z_of(bead, slope), 2);
        return deviation_of(squares, Beads::kBeads - 1);
    };
    return result;
}

/// A ball as a region, or in voxels of size h that hold the share of them that is inside.
Estimate absorbed_in_ball(double h, std::int64_t photons, std::uint64_t seed) {
    constexpr double kRadius_um = 4;
    constexpr double kScattering = 0.5;
    constexpr double kAbsorption = 0.1;
    SceneMedium ball = testing::host(SphereRegion{{0, 0, 0}, kRadius_um}, kScattering, kAbsorption, 0.5);
    if (h > 0) {
        Affine map;
        map.rows = {Vec3{h, 0, 0}, Vec3{0, h, 0}, Vec3{0, 0, h}};
        const auto share_inside = [h](Voxel v) {
            constexpr int kFine = 8;
            int inside = 0;
            for (int i = 0; i < kFine * kFine * kFine; ++i) {
                const int row = i / kFine;
                const int layer = row / kFine;
                const Vec3 at{(i % kFine + 0.5) / kFine - 0.5, (row % kFine + 0.5) / kFine - 0.5,
                              (layer + 0.5) / kFine - 0.5};
                inside += length(h * (Vec3{1.0 * v.x, 1.0 * v.y, 1.0 * v.z} + at)) < kRadius_um ? 1 : 0;
            }
            return 1.0 * inside / (kFine * kFine * kFine);
        };
        const int far = static_cast<int>(std::ceil(kRadius_um / h)) + 1;
        ball =
            testing::host(SparseGrid::from_function({-far, -far, -far}, {far + 1, far + 1, far + 1}, map, share_inside),
                          kScattering, kAbsorption, 0.5);
    }
    BeamLight beam;
    beam.position = beam.waist = {0, 0, -20};
    beam.direction = {0, 0, 1};
    beam.radius_um = 6;
    beam.profile = BeamProfile::Box;
    FluenceSettings settings;
    settings.photons = photons;
    settings.seed = seed;
    NoProgress progress;
    return trace_fluence(scene_of({ball}, testing::laser(beam, 480, 1)), settings, progress)
        .share.excitation.absorbed[0];
}

/// A finite body in voxels is not the body; how the difference goes to zero with their size is plotted, and what is
/// left at none, by a parabola through the three smallest sizes, is the case.
Case ball_case(const std::shared_ptr<PlotBook>& plots) {
    Case result;
    result.name = "ball in voxels, their size going to zero: absorbed, less that of the ball";
    result.source = "the ball as a region";
    result.uncertainty = 1e-4;  // of the parabola, at the edge where chords vanish
    result.fixed = 9000000;
    result.estimate = [=](std::int64_t photons, std::uint64_t seed) {
        const Estimate exact = absorbed_in_ball(0, photons, seed);
        PlotCurve curve{"", {}, {}, {}, {0.1, 0.35, 0.7}};
        // Through 4, 2 and 1 to 0; the largest voxels are for the plot only.
        constexpr std::array kSizes = {2.0, 1.0, 0.5, 0.25};
        constexpr std::array kWeights = {0.0, 1.0 / 3, -2.0, 8.0 / 3};
        double at_zero = 0;
        double variance = std::pow(exact.standard_error, 2);
        for (std::size_t i = 0; i < kSizes.size(); ++i) {
            const double h = kSizes.at(i);
            const std::int64_t count = kWeights.at(i) == 0 ? photons / 10 : photons;
            const Estimate one = absorbed_in_ball(h, count, seed + static_cast<std::uint64_t>(100 * h));
            curve.x.push_back(h);
            curve.y.push_back(one.value - exact.value);
            curve.error.push_back(std::hypot(one.standard_error, exact.standard_error));
            at_zero += kWeights.at(i) * curve.y[i];
            variance += std::pow(kWeights.at(i) * one.standard_error, 2);
        }
        Plot plot;
        plot.title = "A ball in voxels absorbs more, the larger they are";
        plot.x_label = "voxel size, um (radius 4 um)";
        plot.y_label = "absorbed, less that of the ball";
        plot.curves = {curve};
        plots->push_back({"voxel-size", plot});
        return Estimate{at_zero, std::sqrt(variance)};
    };
    return result;
}

}  // namespace

std::vector<Case> figure_cases(const std::shared_ptr<PlotBook>& plots) {
    std::vector<Case> cases;
    cases.push_back(thin_case("cuvette-gfp", "GFP", plots));
    cases.push_back(thin_case("cuvette-rfp", "RFP", plots));
    cases.push_back(thick_case("cuvette-gfp", "GFP", plots));
    cases.push_back(thick_case("cuvette-rfp", "RFP", plots));
    cases.push_back(beads_case(false, plots));
    cases.push_back(beads_case(true, plots));
    cases.push_back(ball_case(plots));
    return cases;
}

}  // namespace fluovox::validation
