// The colour of fluorescence: the dye's own when thin, reddened by the dye itself when thick; lasers, bands and lamps.

#include "fluovox/medium/dye_library.h"
#include "fluovox/spectral/photons.h"

#include "path_kit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace fluovox {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kWide_um = 1e7;
constexpr double kFrom_nm = 480, kTo_nm = 720;
constexpr int kBins = 48;
constexpr double kWidth_nm = (kTo_nm - kFrom_nm) / kBins;

Dye library_dye(const char* name) {
    return find_dye(name)->dye;
}

double mu(const Scene& scene, double nm) {  // all dyes of these scenes fill the same slab
    double total = 0;
    for (const SceneMedium& medium : scene.media)
        total += medium.amount * absorption_per_um_per_uM(scene.dyes[static_cast<std::size_t>(medium.dye)], nm);
    return total;
}

// A slab of dyes under a wide beam, seen from where the light comes from.
Scene slab(const std::vector<std::pair<const char*, double>>& dyes, double thickness_um, double laser_nm) {
    Scene scene;
    for (const auto& [name, uM] : dyes) {
        scene.media.push_back(testing::dye_in(SlabRegion{2, 0, thickness_um}, static_cast<int>(scene.dyes.size()), uM));
        scene.dyes.push_back(library_dye(name));
    }
    scene.lights = {testing::wide_beam(laser_nm, 1, -10, kWide_um)};
    scene.description.camera = testing::one_pixel({0, 0, -5}, {0, 0, 0}, {0, 1, 0}, 1);
    scene.description.film = testing::spectrometer(kFrom_nm, kTo_nm, kBins);
    scene.description.render.samples = 30000;
    return scene;
}

// Photons s^-1 um^-2 sr^-1 nm^-1 that one dye of the slab sends back, for unit photon irradiance at one wavelength:
// Int em/(4 pi) yield mu_x exp(-(mu_x + mu_m) z) dz.
double returned(const Scene& scene, std::size_t dye, double excitation_nm, double emission_nm) {
    const Dye& it = scene.dyes[dye];
    const double thickness = std::get<SlabRegion>(scene.media[0].region).max;
    const double fall = mu(scene, excitation_nm) + mu(scene, emission_nm);
    const double depth = fall * thickness < 1e-9 ? thickness : -std::expm1(-fall * thickness) / fall;
    return it.quantum_yield * scene.media[dye].amount * absorption_per_um_per_uM(it, excitation_nm) *
           it.emission_per_nm(emission_nm) / (4 * kPi) * depth;
}

std::vector<double> mean_over_bins(const std::function<double(double)>& f) {
    std::vector<double> bins;
    for (int i = 0; i < kBins; ++i) {
        double sum = 0;
        for (int j = 0; j < 200; ++j)
            sum += f(kFrom_nm + kWidth_nm * (i + (j + 0.5) / 200)) / 200;
        bins.push_back(sum);
    }
    return bins;
}

// In W m^-2 sr^-1 nm^-1, from photons s^-1 um^-2 sr^-1 nm^-1.
std::vector<double> in_watts(const std::function<double(double)>& photons) {
    return mean_over_bins([&](double nm) { return 1e12 * photons(nm) * photon_energy_J(nm); });
}

struct Spectra {
    std::vector<double> value, error;
};

Spectra rendered(const Scene& scene, const std::string& layer) {
    NoProgress quiet;
    const Film film = render(scene, quiet).film;
    Spectra spectra;
    for (int c = 0; c < kBins; ++c) {
        spectra.value.push_back(film.mean(film.layer(layer), 0, c));
        spectra.error.push_back(std::sqrt(film.variance_of_mean(film.layer(layer), 0, c)));
    }
    return spectra;
}

// Sum of the differences after each was divided by its sum.
double distance(const std::vector<double>& a, const std::vector<double>& b) {
    double sum_a = 0;
    double sum_b = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum_a += a[i];
        sum_b += b[i];
    }
    double total = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        total += std::abs(a[i] / sum_a - b[i] / sum_b);
    return total;
}

double mean_wavelength(const std::vector<double>& bins) {
    double sum = 0;
    double first = 0;
    for (std::size_t i = 0; i < bins.size(); ++i) {
        sum += bins[i];
        first += bins[i] * (kFrom_nm + kWidth_nm * (static_cast<double>(i) + 0.5));
    }
    return first / sum;
}

// Every bin, and the sum; a truth that is `share` brighter must be found out.
void expect_spectrum(const Spectra& seen, const std::vector<double>& truth, double share, const std::string& what) {
    double sum = 0;
    double truth_sum = 0;
    double variance = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        EXPECT_LE(std::abs(seen.value[i] - truth[i]), 5 * seen.error[i] + 1e-9 * truth_sum) << what << ", bin " << i;
        sum += seen.value[i];
        truth_sum += truth[i];
        variance += seen.error[i] * seen.error[i];
    }
    const double error = std::sqrt(3 * variance);  // bins of a sample hang together a little
    EXPECT_LT(std::abs(sum - truth_sum), 5 * error) << what;
    EXPECT_GT(std::abs(sum - (1 + share) * truth_sum), 5 * error) << what;
}

TEST(ThinDye, HasTheSpectrumOfItsEmission) {
    for (const auto& [name, laser_nm] : {std::pair{"EGFP", 488.0}, std::pair{"DsRed", 532.0}}) {
        Scene scene = slab({{name, 0.1}}, 10, laser_nm);
        scene.description.render.samples = 150000;
        const Dye dye = library_dye(name);
        const Spectra seen = rendered(scene, kFluorescenceLayer);
        const auto energy = mean_over_bins([&](double nm) { return dye.emission_per_nm(nm) / nm; });
        EXPECT_LT(distance(seen.value, energy), 0.01) << name;
        // The twin: photons are not watts.
        EXPECT_GT(distance(seen.value, mean_over_bins([&](double nm) { return dye.emission_per_nm(nm); })), 0.01);
        const double irradiance = testing::photons_of(scene.lights[0]) / (kPi * kWide_um * kWide_um);
        const auto truth =
            in_watts([&, laser = laser_nm](double nm) { return irradiance * returned(scene, 0, laser, nm); });
        expect_spectrum(seen, truth, 0.02, name);
    }
}

TEST(ThickDye, IsReddenedByItselfAsAnIntegralOverDepthSays) {
    for (const auto& [name, laser_nm] : {std::pair{"EGFP", 488.0}, std::pair{"DsRed", 532.0}}) {
        Scene scene = slab({{name, 500}}, 1000, laser_nm);
        scene.description.render.samples = 500000;
        const double irradiance = testing::photons_of(scene.lights[0]) / (kPi * kWide_um * kWide_um);
        const Spectra seen = rendered(scene, kFluorescenceLayer);
        const auto truth =
            in_watts([&, laser = laser_nm](double nm) { return irradiance * returned(scene, 0, laser, nm); });
        expect_spectrum(seen, truth, 0.05, name);
        EXPECT_LT(distance(seen.value, truth), 0.01) << name;
        const Dye dye = library_dye(name);
        const auto thin = mean_over_bins([&](double nm) { return dye.emission_per_nm(nm) / nm; });
        EXPECT_GT(mean_wavelength(truth) - mean_wavelength(thin), 2) << name;
        EXPECT_NEAR(mean_wavelength(seen.value), mean_wavelength(truth), 0.3) << name;
        EXPECT_GT(distance(seen.value, thin), 0.05) << name;  // the twin: without the dye's own absorption
    }
}

TEST(ThickDye, SeenFromTheSideHasLostWhatCrossesIt) {
    // Laser along +z, camera along +x: the light made 100 um behind the front face crosses up to 2 mm of dye.
    Scene scene = slab({{"EGFP", 300}}, 2e4, 488);
    scene.media[0].region = BoxRegion{{0, -1e5, 0}, {2000, 1e5, 2e4}};
    scene.description.camera = testing::one_pixel({-5, 0, 100}, {0, 0, 100}, {0, 1, 0}, 0.01);
    const double irradiance = testing::photons_of(scene.lights[0]) / (kPi * kWide_um * kWide_um);
    const Dye& dye = scene.dyes[0];
    const double mu_x = mu(scene, 488);
    const auto truth = in_watts([&](double nm) {
        const double mu_m = mu(scene, nm);
        const double depth = mu_m * 2000 < 1e-9 ? 2000 : -std::expm1(-mu_m * 2000) / mu_m;
        return irradiance * std::exp(-mu_x * 100) * dye.quantum_yield * mu_x * dye.emission_per_nm(nm) / (4 * kPi) *
               depth;
    });
    scene.description.render.samples = 120000;
    const Spectra seen = rendered(scene, kFluorescenceLayer);
    expect_spectrum(seen, truth, 0.05, "side");
    EXPECT_LT(distance(seen.value, truth), 0.01);
}

TEST(TwoDyes, UnderTwoLasersEachHasItsShare) {
    Scene scene = slab({{"EGFP", 20}, {"DsRed", 30}}, 300, 488);
    scene.lights.push_back(testing::wide_beam(561, 0.5, -10, kWide_um));
    scene.description.film.per_dye = true;
    scene.description.render.samples = 60000;
    const double area = kPi * kWide_um * kWide_um;
    std::vector<double> both(kBins, 0);
    for (std::size_t d = 0; d < 2; ++d) {
        const auto truth = in_watts([&](double nm) {
            return testing::photons_of(scene.lights[0]) / area * returned(scene, d, 488, nm) +
                   testing::photons_of(scene.lights[1]) / area * returned(scene, d, 561, nm);
        });
        expect_spectrum(rendered(scene, scene.dyes[d].name), truth, 0.05, scene.dyes[d].name);
        for (std::size_t i = 0; i < both.size(); ++i)
            both[i] += truth[i];
    }
    expect_spectrum(rendered(scene, kFluorescenceLayer), both, 0.05, "both");
}

TEST(Excitation, ByABandAndByALampIsTheIntegralOverTheirSpectra) {
    Spectrum lamp({400, 440, 470, 500, 560}, {0, 3, 1, 2, 0});
    lamp = lamp.scaled(1 / lamp.integral());
    const double area = kPi * kWide_um * kWide_um;
    for (const Spectrum& spectrum : {Spectrum::box(465, 495, 1.0 / 30), lamp}) {
        Scene scene = slab({{"EGFP", 60}, {"DsRed", 20}}, 300, 488);
        scene.lights[0].spectrum.lines.clear();
        scene.lights[0].spectrum.energy_per_nm = spectrum;
        scene.description.render.samples = 60000;
        const auto truth = in_watts([&](double nm) {
            double total = 0;
            constexpr double kStep_nm = 0.5;
            for (double x = spectrum.first_nm() + 0.5 * kStep_nm; x < spectrum.last_nm(); x += kStep_nm) {
                const double photons = spectrum(x) / photon_energy_J(x) / area * kStep_nm;
                total += photons * (returned(scene, 0, x, nm) + returned(scene, 1, x, nm));
            }
            return total;
        });
        expect_spectrum(rendered(scene, kFluorescenceLayer), truth, 0.05, "continuous light");
    }
}

TEST(Excitation, ByALineAndABandTogetherIsTheirSum) {
    // Half of the power in a laser line, half in a band, in one light.
    const double area = kPi * kWide_um * kWide_um;
    Scene scene = slab({{"EGFP", 60}}, 300, 488);
    scene.lights[0].spectrum.lines = {{488, 0.5}};
    scene.lights[0].spectrum.energy_per_nm = Spectrum::box(440, 470, 0.5 / 30);
    const auto truth = in_watts([&](double nm) {
        double total = 0.5 / photon_energy_J(488) / area * returned(scene, 0, 488, nm);
        for (double x = 440.25; x < 470; x += 0.5)
            total += 0.5 / 30 / photon_energy_J(x) / area * 0.5 * returned(scene, 0, x, nm);
        return total;
    });
    expect_spectrum(rendered(scene, kFluorescenceLayer), truth, 0.05, "line and band");
}

}  // namespace
}  // namespace fluovox
