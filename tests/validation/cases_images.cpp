// What a camera sees: images against closed forms, and the two estimators against each other.

#include "fluovox/medium/dye_library.h"
#include "fluovox/spectral/photons.h"

#include "lit_specimen.h"
#include "photon_walk.h"
#include "scene_kit.h"
#include "validation/case.h"
#include "validation/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <utility>

namespace fluovox::validation {
namespace {

using testing::dye_in;
using testing::host;

constexpr double kPi = std::numbers::pi;
constexpr double kPerM2 = 1e12;  // of what is per um2

/// Clear fluorescent solution in a cell of 1 x 1 x 1, lit by a sheet along x and seen along y from beside: what a
/// window in the middle collects of parallel rays, over what it would without inner filters (Parker & Barnes 1957).
Case cell_case(const char* estimator, double absorbance_x, double absorbance_m) {
    constexpr double kYield = 0.9;
    constexpr double kWidth = 0.6;
    constexpr double kThick = 0.1;
    const double mx = std::numbers::ln10 * absorbance_x;
    const double mm = std::numbers::ln10 * absorbance_m;
    const BoxRegion cell{{0, 0, 0}, {1, 1, 1}};
    SceneMedium filter = host(cell, 0, 0);
    filter.absorption = Spectrum({480, 500}, {0, mm});
    SheetLight sheet;
    sheet.position = sheet.waist = {-0.1, 0.5, 0.5};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 1, 0};
    sheet.width_um = kWidth;
    sheet.thickness_um = kThick;
    sheet.profile = BeamProfile::Box;
    Scene scene = scene_of({dye_in(cell, 0, 1), filter}, testing::laser(sheet, 480, 1));
    scene.dyes = {testing::flat_dye(mx, 400, 490, 500, 600, kYield)};
    scene.description.camera = testing::one_pixel({0.5, -5, 0.5}, {0.5, 0.5, 0.5}, {0, 0, 1}, 0.2);
    scene.description.film = testing::spectrometer(500, 600, 1);
    scene.description.film.unit = FilmUnit::Photons;
    const double irradiance = photons_per_second(1, 480) / (kWidth * kThick);
    const double unfiltered = kYield * mx / (4 * kPi) * irradiance * kThick / 100 * kPerM2;
    Case result;
    result.name = fmt::format("90 degree cell, absorbance {} and {}, {}", absorbance_x, absorbance_m, estimator);
    result.expected = (std::exp(-0.4 * mx) - std::exp(-0.6 * mx)) / (0.2 * mx) *
                      (std::exp(-0.45 * mm) - std::exp(-0.55 * mm)) / (0.1 * mm);
    result.source = "Parker & Barnes 1957";
    result.estimate = [scene, estimator, unfiltered](std::int64_t samples, std::uint64_t seed) {
        const Film film = picture(scene, estimator, samples, seed);
        return Estimate{film.mean(2, 0, 0) / unfiltered, std::sqrt(film.variance_of_mean(2, 0, 0)) / unfiltered};
    };
    result.scale = 0;
    return result;
}

/// A clear slab of a real dye, a pencil of light through it, seen from behind.
struct Filtered {
    Scene scene;
    std::vector<double> expected;  // in each bin

    Filtered(const char* dye_name, double laser_nm, double uM, double from_nm, double to_nm) {
        constexpr double kDepth_um = 1e4;
        constexpr double kField_um = 1e3;
        const Dye dye = find_dye(dye_name)->dye;
        BeamLight beam;
        beam.position = beam.waist = {0, 0, -1};
        beam.direction = {0, 0, 1};
        scene = scene_of({dye_in(SlabRegion{2, 0, kDepth_um}, 0, uM)}, testing::laser(beam, laser_nm, 1));
        scene.dyes = {dye};
        scene.description.camera = testing::one_pixel({0, 0, 2e4}, {0, 0, 0}, {0, 1, 0}, kField_um);
        const int bins = static_cast<int>(std::lround((to_nm - from_nm) / 2));
        scene.description.film = testing::spectrometer(from_nm, to_nm, bins);
        scene.description.film.unit = FilmUnit::Photons;
        const double mx = uM * absorption_per_um_per_uM(dye, laser_nm);
        const double photons = photons_per_second(1, laser_nm) / (kField_um * kField_um) * kPerM2;
        for (int bin = 0; bin < bins; ++bin) {
            constexpr int kSteps = 200;
            double sum = 0;
            for (int i = 0; i < kSteps; ++i) {
                const double nm = from_nm + 2 * (bin + (i + 0.5) / kSteps);
                const double mm = uM * absorption_per_um_per_uM(dye, nm);
                // Int mx exp(-mx z) exp(-mm (d - z)) dz
                const double k = (mx - mm) * kDepth_um;
                const double depth = std::abs(k) < 1e-9 ? kDepth_um : -std::expm1(-k) / (mx - mm);
                sum += dye.emission_per_nm(nm) * mx * std::exp(-mm * kDepth_um) * depth / kSteps;
            }
            expected.push_back(photons * dye.quantum_yield / (4 * kPi) * sum);
        }
    }
};

/// Photons of the estimator `light` have one wavelength each, so bins are independent.
Case histogram_case(const char* dye, double laser_nm, double uM, double from_nm, double to_nm) {
    const Filtered filtered(dye, laser_nm, uM, from_nm, to_nm);
    Case result;
    result.name = fmt::format("spectrum of {}, {} uM through 1 cm (chi-squared as a deviation)", dye, uM);
    result.source = uM < 0.1 ? "the dye's emission" : "emission and reabsorption by quadrature";
    result.fixed = 2000000;
    result.many = true;
    result.estimate = [filtered](std::int64_t samples, std::uint64_t seed) {
        const Film film = picture(filtered.scene, "light", samples, seed);
        double squares = 0;
        for (int bin = 0; bin < film.channels(); ++bin) {
            const double expected = filtered.expected[static_cast<std::size_t>(bin)];
            const double got = film.mean(2, 0, bin);
            if (!(got > 0)) continue;
            // The variance of counts, which is in proportion to the mean, for the mean that is expected.
            squares += std::pow(got - expected, 2) / (film.variance_of_mean(2, 0, bin) * expected / got);
        }
        return deviation_of(squares, film.channels());
    };
    return result;
}

/// Mean wavelength of a spectrum of bins of 2 nm.
double mean_nm(const std::vector<double>& bins, double from_nm) {
    double sum = 0;
    double all = 0;
    for (std::size_t i = 0; i < bins.size(); ++i) {
        sum += bins[i] * (from_nm + 2 * static_cast<double>(i) + 1);
        all += bins[i];
    }
    return sum / all;
}

Case red_shift_case() {
    constexpr double kFrom = 490;
    constexpr double kTo = 650;
    const Filtered thin("EGFP", 480, 1e-3, kFrom, kTo);
    const Filtered thick("EGFP", 480, 20, kFrom, kTo);
    const double thin_nm = mean_nm(thin.expected, kFrom);
    Case result;
    result.name = "red-shift by reabsorption in 1 cm of 20 uM EGFP, nm";
    result.expected = mean_nm(thick.expected, kFrom) - thin_nm;
    result.source = "quadrature";
    result.fixed = 40000;
    result.scale = 0;
    result.estimate = [thick, thin_nm](std::int64_t samples, std::uint64_t seed) {
        Scene scene = thick.scene;  // a path cannot meet a pencil: a beam wider than the picture
        auto& beam = std::get<BeamLight>(scene.lights[0].shape);
        beam.radius_um = 2e3;
        beam.profile = BeamProfile::Box;
        return mean_of_runs(20, seed, [&](std::uint64_t run) {
            const Film film = picture(scene, "path", samples, run);
            std::vector<double> bins;
            for (int bin = 0; bin < film.channels(); ++bin)
                bins.push_back(film.mean(2, 0, bin));
            return mean_nm(bins, kFrom) - thin_nm;
        });
    };
    return result;
}

/// Two dyes in the same voxels, told apart by the spectra that each has alone.
Case unmix_case(bool second) {
    constexpr std::array<double, 2> kConcentration = {0.3, 0.2};
    const auto scene_with = [](double first_uM, double second_uM) {
        const auto cube = [](double uM) {
            return SparseGrid::from_function({-10, -10, -10}, {10, 10, 10}, {}, [uM](Voxel) { return uM; });
        };
        SheetLight sheet;
        sheet.position = sheet.waist = {-50, 0, 0};
        sheet.direction = {1, 0, 0};
        sheet.normal = {0, 0, 1};
        sheet.width_um = sheet.thickness_um = 60;
        sheet.profile = BeamProfile::Box;
        Scene scene = scene_of({dye_in(cube(first_uM), 0), dye_in(cube(second_uM), 1)}, testing::laser(sheet, 488, 1));
        scene.dyes = {find_dye("alexa488")->dye, find_dye("alexa546")->dye};
        scene.description.camera = testing::one_pixel({0, 0, 100}, {0, 0, 0}, {0, 1, 0}, 30);
        scene.description.film = testing::spectrometer(500, 700, 50);
        return scene;
    };
    const auto spectrum = [](const Scene& scene, std::int64_t samples, std::uint64_t seed) {
        const Film film = picture(scene, "path", samples, seed);
        std::vector<double> bins;
        for (int bin = 0; bin < film.channels(); ++bin)
            bins.push_back(film.mean(2, 0, bin));
        return bins;
    };
    Case result;
    result.name = fmt::format("two dyes in each voxel, unmixed: uM of the {}", second ? "second" : "first");
    result.expected = kConcentration.at(second ? 1 : 0);
    result.uncertainty = 1e-4 * result.expected;  // thin to that, as are the spectra alone
    result.source = "what was put in";
    result.fixed = 40000;
    result.scale = 0;
    result.estimate = [=](std::int64_t samples, std::uint64_t seed) {
        const Scene scene = scene_with(kConcentration[0], kConcentration[1]);
        // Each run has spectra alone of its own, so that what these are off by is in the spread of the runs; and of the
        // same paths, most of whose noise then falls out.
        return mean_of_runs(20, seed, [&](std::uint64_t run) {
            const std::vector<double> mixed = spectrum(scene, samples, run);
            const std::vector<double> first_alone = spectrum(scene_with(1e-3, 0), samples, run);
            const std::vector<double> second_alone = spectrum(scene_with(0, 1e-3), samples, run);
            // Least squares for two unknowns.
            const auto product = [](const std::vector<double>& u, const std::vector<double>& v) {
                return std::inner_product(u.begin(), u.end(), v.begin(), 0.0);
            };
            const double aa = product(first_alone, first_alone);
            const double ab = product(first_alone, second_alone);
            const double bb = product(second_alone, second_alone);
            const double am = product(first_alone, mixed);
            const double bm = product(second_alone, mixed);
            const double det = aa * bb - ab * ab;
            return 1e-3 * (second ? aa * bm - ab * am : bb * am - ab * bm) / det;
        });
    };
    return result;
}

/// A milky cube with a dyed ball, a thick sheet and a small aperture, in 32 x 32 pixels.
Scene lit_cube() {
    const BoxRegion box{{0, 0, 0}, {100, 100, 100}};
    SheetLight sheet;
    sheet.position = sheet.waist = {-10, 50, 50};
    sheet.direction = {1, 0, 0};
    sheet.normal = {0, 0, 1};
    sheet.width_um = 80;
    sheet.thickness_um = 40;
    Scene scene = scene_of({host(box, 0.02, 0.002, 0.6), dye_in(SphereRegion{{50, 50, 50}, 40}, 0, 1)},
                           testing::laser(sheet, 488, 1e-3));
    scene.dyes = {testing::flat_dye(0.01, 400, 530, 510, 610, 0.8)};
    scene.description.camera = testing::one_pixel({50, 50, 200}, {50, 50, 60}, {0, 1, 0}, 90, 0.2);
    scene.description.camera.width = scene.description.camera.height = 32;
    scene.description.film = testing::spectrometer(470, 630, 1);
    return scene;
}

/// The mean of a layer's variances over the 5 x 5 pixels around each: a pixel's own goes with its mean where samples
/// are far from normal, and would make dark ones seem sure of it.
std::vector<double> smooth_variance(const Film& film, int layer) {
    std::vector<double> smooth;
    for (int y = 0; y < film.height(); ++y) {
        for (int x = 0; x < film.width(); ++x) {
            double sum = 0;
            int count = 0;
            for (int j = std::max(0, y - 2); j <= std::min(film.height() - 1, y + 2); ++j) {
                for (int i = std::max(0, x - 2); i <= std::min(film.width() - 1, x + 2); ++i, ++count)
                    sum += film.variance_of_mean(layer, j * film.width() + i, 0);
            }
            smooth.push_back(sum / count);
        }
    }
    return smooth;
}

/// All pixels by their chi-squared, or the worst of them corrected for their number. With fewer samples paths are too
/// far from a normal distribution.
Case pixels_case(int layer, bool worst) {
    Case result;
    result.name = fmt::format("path against light in 32 x 32 pixels, {} ({} as a deviation)",
                              layer == 1 ? "elastic" : "fluorescence", worst ? "largest z" : "chi-squared");
    result.source = "the other estimator";
    result.fixed = 1200;
    result.many = true;
    result.estimate = [=](std::int64_t samples, std::uint64_t seed) {
        const Film path = picture(lit_cube(), "path", samples, seed);
        const Film light = picture(lit_cube(), "light", 6 * samples, seed + 500);
        const std::vector<double> of_path = smooth_variance(path, layer);
        const std::vector<double> of_light = smooth_variance(light, layer);
        double squares = 0;
        double largest = 0;
        for (int pixel = 0; pixel < path.pixels(); ++pixel) {
            const auto i = static_cast<std::size_t>(pixel);
            const double variance = of_path[i] + of_light[i];
            const double square = std::pow(path.mean(layer, pixel, 0) - light.mean(layer, pixel, 0), 2) / variance;
            squares += square;
            largest = std::max(largest, std::sqrt(square));
        }
        constexpr double kNormal = 1e6;  // degrees of freedom
        if (worst) return deviation_of_largest(largest, path.pixels(), kNormal);
        return deviation_of(squares, path.pixels());
    };
    return result;
}

/// All light of one layer in a picture, over what the estimator `light` finds.
Case total_case(const std::string& name, const Scene& scene, const std::string& layer, std::int64_t samples,
                double light_factor) {
    const auto total = [scene, layer](const char* estimator, std::int64_t count, std::uint64_t seed) {
        return mean_of_runs(16, seed, [&](std::uint64_t run) {
            const Film film = picture(scene, estimator, count, run);
            double sum = 0;
            for (int pixel = 0; pixel < film.pixels(); ++pixel)
                sum += film.mean_of_all(film.layer(layer), pixel);
            return sum / film.pixels();
        });
    };
    Case result;
    result.name =
        fmt::format("path over light: all {}light in the picture of {}", layer == kTotalLayer ? "" : layer + " ", name);
    result.expected = 1;
    result.source = "the other estimator";
    result.fixed = samples;
    const auto reaches = std::make_shared<double>(0);
    result.reaches_sensor = reaches;
    result.estimate = [=](std::int64_t count, std::uint64_t seed) {
        const Estimate path = total("path", count, seed);
        const auto photons = static_cast<std::int64_t>(light_factor * static_cast<double>(count));
        const Estimate light = total("light", photons, seed + 50);
        *reaches = share_on_sensor(scene, path.value);
        const double ratio = path.value / light.value;
        return Estimate{ratio,
                        ratio * std::hypot(path.standard_error / path.value, light.standard_error / light.value)};
    };
    return result;
}

/// With an aperture, where the scene has none: a sensor sees nothing through none.
Case specimen_case(const std::string& name, int width, int height, std::int64_t samples, double light_factor) {
    const std::vector<std::string> keys = {fmt::format("camera.resolution=[{},{}]", width, height),
                                           "camera.numerical_aperture=0.1", "film.unit=watts"};
    return total_case("volumes/" + name, specimen(name, keys), kFluorescenceLayer, samples, light_factor);
}

Case cube_total_case(const char* layer) {
    Scene scene = lit_cube();
    scene.description.camera.width = scene.description.camera.height = 8;
    return total_case("the milky cube", scene, layer, 5000, 4);
}

/// Elastic light of a thick specimen in voxels, lit from the side: guessed shadows and a weight window serve `path`.
Case thick_specimen_case() {
    Scene scene = testing::lit_specimen(2);
    scene.lights = {testing::laser(testing::slanting_light({32, 32, 32}, 140), 488, 1e-3)};
    scene.description.camera.width = scene.description.camera.height = 8;
    scene.description.camera.numerical_aperture = 0.2;
    return total_case("a thick specimen", scene, kTotalLayer, 6000, 6);
}

/// All fluorescence in the picture of the milky cube, over that of photons which are followed one by one by the plain
/// probabilities of nature until some of them happen to fly into the camera: code that shares nothing with the program.
Case plain_photons_case() {
    constexpr int kRuns = 24;
    constexpr double kLaser_nm = 488;
    constexpr double kBall_um = 300;
    constexpr double kMost_per_um = 0.033;
    Scene scene = lit_cube();
    scene.description.camera.width = scene.description.camera.height = 2;
    scene.description.film.unit = FilmUnit::Photons;
    const auto launch = [](reference::Dice& dice) {
        std::uniform_real_distribution<double> across(10, 90);
        std::normal_distribution<double> thick(50, 10);
        const double y = across(dice);
        return Ray{{-10, y, thick(dice)}, {1, 0, 0}};
    };
    const double film_nm = scene.description.film.to_nm - scene.description.film.from_nm;
    const double photons_per_s = photons_per_second(launched_W(scene), kLaser_nm);
    Case result;
    result.name = "path over plain photons: all fluorescence light in the picture of the milky cube";
    result.expected = 1;
    result.source = "photon by photon (tests/reference)";
    result.fixed = 12000000;
    const auto reaches = std::make_shared<double>(0);
    result.reaches_sensor = reaches;
    result.estimate = [=](std::int64_t photons, std::uint64_t seed) {
        const Estimate plain = mean_of_runs_at_once(kRuns, seed, [&](std::uint64_t run) {
            reference::WalkSettings settings{kLaser_nm, kBall_um, kMost_per_um, 1, photons / kRuns};
            settings.seed = run;
            const reference::WalkCounts counts = reference::walk(scene, launch, settings);
            double hits = 0;
            for (const double pixel : counts.glow_in_pixel)
                hits += pixel;
            return counts.radiance(scene.description.camera, hits).value / 4;  // of four pixels
        });
        const Film film = picture(scene, "path", photons / 12, seed);
        double sum = 0;
        double variance = 0;
        for (int pixel = 0; pixel < 4; ++pixel) {
            sum += film.mean(2, pixel, 0) / 4;
            variance += film.variance_of_mean(2, pixel, 0) / 16;
        }
        const double unit = film_nm / (photons_per_s * kPerM2);
        const double ratio = unit * sum / plain.value;
        *reaches = share_on_sensor(scene, plain.value * kPerM2 / film_nm) * launched_W(scene);
        return Estimate{ratio, ratio * std::hypot(plain.standard_error / plain.value, std::sqrt(variance) / sum)};
    };
    return result;
}

}  // namespace

std::vector<Case> image_cases(const std::shared_ptr<PlotBook>& plots) {
    std::vector<Case> cases;
    cases.push_back(cell_case("path", 1, 0.1));
    cases.push_back(cell_case("path", 3, 1));
    cases.push_back(cell_case("light", 0.1, 0.01));
    cases.push_back(histogram_case("EGFP", 480, 1e-3, 490, 650));
    cases.push_back(histogram_case("EGFP", 480, 20, 490, 650));
    cases.push_back(histogram_case("mCherry", 561, 1e-3, 570, 750));
    cases.push_back(red_shift_case());
    cases.push_back(unmix_case(false));
    cases.push_back(unmix_case(true));
    for (const bool worst : {false, true}) {
        cases.push_back(pixels_case(1, worst));
        cases.push_back(pixels_case(2, worst));
    }
    cases.push_back(cube_total_case(kElasticLayer));
    cases.push_back(cube_total_case(kFluorescenceLayer));
    cases.push_back(specimen_case("neuron", 6, 8, 40000, 1));
    cases.push_back(specimen_case("beads", 8, 8, 3000, 3));
    cases.push_back(specimen_case("cuvette-gfp", 3, 8, 6000, 1));
    cases.push_back(specimen_case("cuvette-rfp", 3, 8, 6000, 1));
    for (Case& figure : figure_cases(plots))
        cases.push_back(std::move(figure));
    cases.push_back(plain_photons_case());
    cases.push_back(thick_specimen_case());
    return cases;
}

}  // namespace fluovox::validation
