// Books of photons and of energy: what a dye sends out is its yield of what it takes in, photon by photon; in watts the
// ratio of the wavelengths comes in (Stokes).

#include "fluovox/spectral/photons.h"
#include "fluovox/transport/film_response.h"

#include "path_kit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::host;

constexpr double kPi = std::numbers::pi;
constexpr double kBall_um = 60;
constexpr double kYield = 0.6;

// Straight lines through the ball around the origin, evenly over all lines: the mean radiance that leaves along them,
// times pi and the ball's surface, is all that comes out of it.
Ray any_line(Rng& rng) {
    const Vec3 from = kBall_um * sample_isotropic(rng.uniform(), rng.uniform());
    const double mu = std::sqrt(rng.uniform());
    return {from, turned((-1 / kBall_um) * from, mu, rng.uniform())};
}

std::vector<std::pair<std::string, std::vector<SceneMedium>>> specimens() {
    const auto grid = [] {
        Affine map;
        map.rows = {Vec3{2, 0.5, 0}, Vec3{-0.5, 2, 0}, Vec3{0, 0, 2}};
        return SparseGrid::from_function({-12, -12, -12}, {12, 12, 12}, map,
                                         [](Voxel v) { return ((v.x + v.y + v.z) & 1) != 0 ? 6.0 : 2.0; });
    };
    std::vector<std::pair<std::string, std::vector<SceneMedium>>> all;
    all.push_back({"clear ball", {dye_in(SphereRegion{{5, 0, 0}, 40}, 0, 5)}});
    all.push_back(
        {"dye in a scattering ball",
         {dye_in(BoxRegion{{-20, -30, -10}, {30, 20, 25}}, 0, 8), host(SphereRegion{{0, 0, 0}, 55}, 0.02, 0, 0.7)}});
    all.push_back({"voxels of dye in a scattering box",
                   {dye_in(grid(), 0), host(BoxRegion{{-30, -30, -30}, {30, 30, 30}}, 0.03, 0, 0.3)}});
    return all;
}

TEST(Accounts, PhotonsSentOutAreTheYieldOfThoseTakenIn) {
    for (auto& [name, media] : specimens()) {
        Scene scene;
        scene.dyes = {testing::flat_dye(0.004, 440, 460, 500, 600, kYield)};
        scene.media = std::move(media);
        for (SceneMedium& medium : scene.media) {  // other colours scatter otherwise
            if (medium.dye < 0) medium.scattering = PowerLaw{500, std::get<double>(medium.scattering), -2};
        }
        scene.lights = {testing::laser(UniformLight{1}, 450, 0)};
        const double incoming = testing::photons_of(scene.lights[0]);
        const auto unconverted = testing::line_radiance(scene, any_line, 450, {300000, 91, 0});
        const auto glow =
            testing::spectral_radiance(scene, any_line, testing::wavelengths_in(500, 600, 4), {300000, 92})
                .mean_converted;
        const double taken = incoming - unconverted.mean;
        const double sent = 100 * glow.mean;
        const double error = std::hypot(kYield * unconverted.standard_error(), 100 * glow.standard_error());
        std::printf("  %-34s taken in %.3f, sent out over taken in %.4f +- %.4f\n", name.c_str(), taken / incoming,
                    sent / taken, error / taken);
        EXPECT_GT(taken, 0.02 * incoming) << name;
        EXPECT_LT(std::abs(sent - kYield * taken), 5 * error) << name;
        EXPECT_GT(std::abs(sent - 1.1 * kYield * taken), 5 * error) << name;
    }
}

TEST(Accounts, InWattsThePhotonsAreLongerAndCarryLess) {
    // The same photons written in watts and counted: each bin by the energy of its photons, and the whole by yield
    // times the ratio of the wavelengths.
    FilmSpec watts = testing::spectrometer(500, 600, 50);
    FilmSpec photons = watts;
    photons.unit = FilmUnit::Photons;
    const FilmResponse in_watts(watts, {});
    const FilmResponse counted(photons, {});
    std::vector<double> w(50, 0);
    std::vector<double> n(50, 0);
    constexpr int kSteps = 5000;
    for (int i = 0; i < kSteps; ++i) {  // one photon per s, um^2 and sr, evenly over 500 to 600 nm
        const double nm = 500 + 100 * (i + 0.5) / kSteps;
        in_watts.add(nm, 1.0 / kSteps, w);
        counted.add(nm, 1.0 / kSteps, n);
    }
    double sum_w = 0;
    double sum_n = 0;
    for (std::size_t i = 0; i < 50; ++i) {
        const double center = 501 + 2 * static_cast<double>(i);
        EXPECT_NEAR(w[i] / n[i] / photon_energy_J(center), 1, 1e-5);
        sum_w += 2 * w[i];
        sum_n += 2 * n[i];
    }
    EXPECT_NEAR(sum_n, 1e12, 1);  // per m^2
    // Mean of 1/lambda over the band: ln(600/500)/100.
    const double stokes = 450 * std::log(600.0 / 500.0) / 100;
    EXPECT_NEAR(sum_w / (1e12 * photon_energy_J(450)), stokes, 1e-6);
    EXPECT_LT(stokes, 0.83);
}

// Clear slab of 1 cm, absorbance 3 at the laser and 1 at the glow, yield 0.9, isotropic emission, no re-emission:
// photons that leave each face per photon that enters. Closed form with exponential integrals (E2).
TEST(Accounts, RenderedFacesOfAClearSlabSendOutWhatTheClosedFormSays) {
    constexpr double kThick_um = 1e4;
    constexpr double kWide_um = 1e8;
    Scene scene;
    const double mu_x = 3 * std::log(10.0) / kThick_um;
    const double mu_m = 1 * std::log(10.0) / kThick_um;
    scene.dyes = {testing::flat_dye(mu_x, 440, 460, 500, 600, 0.9)};
    scene.media = {dye_in(SlabRegion{2, 0, kThick_um}, 0, 1), host(SlabRegion{2, 0, kThick_um}, 0, 0)};
    scene.media[1].absorption = Spectrum({460, 500}, {0, mu_m});
    scene.lights = {testing::wide_beam(450, 1, -10, kWide_um)};
    scene.description.film = testing::spectrometer(500, 600, 10);
    scene.description.render.samples = 60000;
    NoProgress quiet;
    const double area = kPi * kWide_um * kWide_um;
    for (const bool front : {true, false}) {
        // An aperture of one is the whole hemisphere: pi times the radiance is the power per area.
        const double z = front ? -1 : kThick_um + 1;
        scene.description.camera = testing::one_pixel({0, 0, z}, {0, 0, front ? 0 : kThick_um}, {0, 1, 0}, 1, 1);
        const double truth = front ? 0.24204778413835362 : 0.020262306592295113;
        for (const FilmUnit unit : {FilmUnit::Photons, FilmUnit::Watts}) {
            scene.description.film.unit = unit;
            const Film film = render(scene, quiet).film;
            double sum = 0;
            double variance = 0;
            for (int c = 0; c < 10; ++c) {
                sum += 10 * film.mean(film.layer(kFluorescenceLayer), 0, c);
                variance += 100 * film.variance_of_mean(film.layer(kFluorescenceLayer), 0, c);
            }
            const double incoming = unit == FilmUnit::Photons ? testing::photons_of(scene.lights[0]) : 1.0;
            const double stokes = unit == FilmUnit::Photons ? 1 : 450 * std::log(600.0 / 500.0) / 100;
            const double share = kPi * sum * 1e-12 * area / incoming;
            const double error =
                kPi * std::sqrt(10 * variance) * 1e-12 * area / incoming;  // bins of a sample go together
            EXPECT_NEAR(share / (stokes * truth), 1, 0.02);
            EXPECT_LT(std::abs(share - stokes * truth), 5 * error);
            EXPECT_GT(std::abs(share - 1.1 * stokes * truth), 5 * error);
        }
    }
}

}  // namespace
}  // namespace fluovox
