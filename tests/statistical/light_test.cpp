// Lights: the power that leaves them passes every surface around them, and what draws from them is the density it says.

#include "fluovox/medium/phase_function.h"
#include "fluovox/optics/light_sampling.h"

#include "scene_kit.h"
#include "statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace fluovox {
namespace {

using testing::chi_squared_p;
using testing::kFiveSigma;
using testing::laser;
using testing::RunningMean;
using testing::z_score;

const Vec3 kAlong = normalized({0.8, 0.3, -0.4});
const Vec3 kNormal = normalized(cross(kAlong, {0.1, 0.2, 0.9}));

SheetLight sheet(BeamProfile profile, double numerical_aperture) {
    SheetLight light;
    light.position = {-200, 10, 30};
    light.direction = kAlong;
    light.normal = kNormal;
    light.width_um = 80;
    light.thickness_um = 6;
    light.profile = profile;
    light.numerical_aperture = numerical_aperture;
    light.waist = light.position + 150 * kAlong;
    return light;
}

BeamLight beam(BeamProfile profile, double numerical_aperture) {
    BeamLight light;
    light.position = {-200, 10, 30};
    light.direction = kAlong;
    light.radius_um = 7;
    light.profile = profile;
    light.numerical_aperture = numerical_aperture;
    light.waist = light.position + 150 * kAlong;
    return light;
}

std::vector<Light> shafts() {
    return {laser(sheet(BeamProfile::Gaussian, 0), 488, 1),    laser(sheet(BeamProfile::Box, 0), 488, 1),
            laser(sheet(BeamProfile::Gaussian, 0.15), 488, 1), laser(beam(BeamProfile::Gaussian, 0), 488, 1),
            laser(beam(BeamProfile::Box, 0), 488, 1),          laser(beam(BeamProfile::Gaussian, 0.3), 488, 1)};
}

Light rectangle() {
    RectangleLight light;
    light.center = {5, -3, 2};
    light.normal = kAlong;
    light.up = kNormal;
    light.width_um = 30;
    light.height_um = 12;
    return laser(light, 488, 1);
}

// Power through a piece of a surface, in many batches of stratified points: `place(u, v)` on it, `normal(u, v)` out of
// it, each with the area of the whole piece.
RunningMean flux(const Light& light, double area, const std::function<Vec3(double, double)>& place,
                 const std::function<Vec3(double, double)>& normal) {
    constexpr int kSide = 300;
    RunningMean batches;
    for (std::uint64_t b = 0; b < 16; ++b) {
        Rng rng(21, b, 0);
        double sum = 0;
        for (int i = 0; i < kSide; ++i) {
            for (int j = 0; j < kSide; ++j) {
                const double u = (i + rng.uniform()) / kSide;
                const double v = (j + rng.uniform()) / kSide;
                const double u1 = rng.uniform();
                const auto sample = sample_light(light, place(u, v), u1, rng.uniform());
                if (sample) sum -= sample->fluence_per_um2 * dot(sample->to_light, normal(u, v));
            }
        }
        batches.add(sum / (kSide * kSide) * area);
    }
    return batches;
}

RunningMean flux_through_plane(const Light& light, Vec3 center, Vec3 normal, double size) {
    const Frame axes = Frame::around(normal);
    return flux(
        light, size * size,
        [&](double u, double v) { return center + (size * (u - 0.5)) * axes.x + (size * (v - 0.5)) * axes.y; },
        [&](double, double) { return normal; });
}

RunningMean flux_through_sphere(const Light& light, Vec3 center, double radius) {
    const auto outward = [](double u, double v) { return sample_isotropic(u, v); };
    return flux(
        light, 4 * std::numbers::pi * radius * radius,
        [&](double u, double v) { return center + radius * outward(u, v); }, outward);
}

void expect_power(const RunningMean& power, const char* what, std::size_t number) {
    EXPECT_LT(std::abs(z_score(power, 1)), 5) << what << " of light " << number << ": " << power.mean;
    EXPECT_GT(std::abs(z_score(power, 1.02)), 5) << what << " of light " << number;
    EXPECT_NEAR(power.mean, 1, 0.01) << what << " of light " << number;
}

TEST(Lights, AllPowerOfASheetOrBeamPassesEveryPlaneAcrossIt) {
    const auto lights = shafts();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const Vec3 start{-200, 10, 30};
        expect_power(flux_through_plane(lights[i], start + 20.0 * kAlong, kAlong, 200), "near plane", i);
        expect_power(flux_through_plane(lights[i], start + 150.0 * kAlong, kAlong, 100), "waist", i);
        // A tilted plane; the fluence is larger than the flux where rays spread, and must still add up.
        const Vec3 tilted = normalized(kAlong + 0.7 * kNormal);
        expect_power(flux_through_plane(lights[i], start + 260.0 * kAlong, tilted, 260), "tilted plane", i);
    }
}

TEST(Lights, NoneShinesBehindWhereItStarts) {
    for (const Light& light : shafts())
        EXPECT_FALSE(sample_light(light, Vec3{-200, 10, 30} - 1.0 * kAlong, 0.3, 0.6));
    EXPECT_FALSE(sample_light(rectangle(), Vec3{5, -3, 2} - 1.0 * kAlong, 0.3, 0.6));
    EXPECT_FALSE(sample_light(laser(UniformLight{}, 488, 1), {0, 0, 0}, 0.3, 0.6));
}

TEST(Lights, AllPowerOfAPointPassesASphereThatHoldsIt) {
    PointLight point;
    point.position = {3, 4, 5};
    expect_power(flux_through_sphere(laser(point, 488, 1), {1, 2, 10}, 11), "sphere", 0);
    const RunningMean outside = flux_through_sphere(laser(point, 488, 1), {40, 2, 10}, 11);
    EXPECT_LT(std::abs(outside.mean), 0.001);
}

TEST(Lights, AllPowerOfARectanglePassesASphereThatHoldsIt) {
    expect_power(flux_through_sphere(rectangle(), {5, -3, 2}, 30), "sphere", 0);
}

TEST(Lights, RectangleDirectionsHaveTheDensityTheySay) {
    const Light light = rectangle();
    const auto& shape = std::get<RectangleLight>(light.shape);
    const Vec3 from = shape.center + 20.0 * kAlong + 9.0 * kNormal;
    Rng rng(22, 0, 0);
    RunningMean seen;     // density over all directions that hit it: one
    RunningMean fluence;  // radiance times solid angle, by hitting it
    for (int n = 0; n < 2000000; ++n) {
        const Ray ray{from, sample_isotropic(rng.uniform(), rng.uniform())};
        const auto t = hit_rectangle(shape, ray);
        seen.add(t ? 4 * std::numbers::pi * rectangle_pdf(shape, ray.direction, *t) : 0);
        fluence.add(t ? 4 * std::numbers::pi * rectangle_radiance(shape) : 0);
    }
    EXPECT_LT(std::abs(z_score(seen, 1)), 5);
    EXPECT_GT(std::abs(z_score(seen, 1.02)), 5);
    RunningMean sampled;
    for (int n = 0; n < 200000; ++n) {
        const double u1 = rng.uniform();
        const auto sample = sample_light(light, from, u1, rng.uniform());
        ASSERT_TRUE(sample);
        sampled.add(sample->fluence_per_um2);
        if (n % 1000 != 0) continue;
        EXPECT_NEAR(sample->pdf_per_sr, rectangle_pdf(shape, sample->to_light, sample->distance_um), 1e-9);
        const auto t = hit_rectangle(shape, {from, sample->to_light});
        ASSERT_TRUE(t);
        EXPECT_NEAR(*t, sample->distance_um, 1e-9);
    }
    EXPECT_LT(std::abs(z_score(fluence, sampled.mean)), 5);
    EXPECT_GT(std::abs(z_score(fluence, 1.02 * sampled.mean)), 5);
}

// The mean direction of a focused beam is that of its geometry: behind the waist the rays run apart.
TEST(Lights, FocusedRaysPointAwayFromTheWaist) {
    const Light light = laser(beam(BeamProfile::Gaussian, 0.3), 488, 1);
    const auto& shape = std::get<BeamLight>(light.shape);
    const Frame axes = Frame::around(kAlong);
    Rng rng(23, 0, 0);
    const double z = 120;
    const double x = 15;
    RunningMean slope;
    for (int n = 0; n < 100000; ++n) {
        const double u1 = rng.uniform();
        const auto sample = sample_light(light, shape.waist + z * kAlong + x * axes.x, u1, rng.uniform());
        ASSERT_TRUE(sample);
        const Vec3 flight = axes.to_local(-sample->to_light);
        slope.add(flight.x / flight.z);
        // Followed back it starts in the plane through the light's position.
        const Vec3 start = shape.waist + z * kAlong + x * axes.x + sample->distance_um * sample->to_light;
        EXPECT_NEAR(dot(start - shape.position, kAlong), 0, 1e-9);
    }
    const double sigma_slope = 0.5 * 0.3 / std::sqrt(1 - 0.09);
    const double sigma_waist = 3.5;
    const double mean =
        x * z * sigma_slope * sigma_slope / (sigma_waist * sigma_waist + z * z * sigma_slope * sigma_slope);
    EXPECT_LT(std::abs(z_score(slope, mean)), 5);
    EXPECT_GT(std::abs(z_score(slope, 1.02 * mean)), 5);
}

struct LitCheck {
    double integral = 0, p = 1;
};

// Draws from the section of `light`, and compares with the density of the section of `claimed`.
LitCheck check_section(const Light& light, const Light& claimed, const Ray& ray, Interval domain, std::uint64_t key) {
    const LitSection drawn(light, ray, domain);
    const LitSection section(claimed, ray, domain);
    LitCheck result;
    if (!drawn || !section) return {-1, 1};
    constexpr int kBins = 300;
    constexpr int kDraws = 50000;
    const double end = std::isfinite(domain.end) ? domain.end : 4000;
    std::vector<double> expected(kBins, 0);
    for (int i = 0; i < kBins; ++i) {
        constexpr int kPoints = 100;
        const double width = (end - domain.begin) / kBins;
        for (int j = 0; j < kPoints; ++j)
            expected[static_cast<std::size_t>(i)] +=
                section.pdf(domain.begin + (i + (j + 0.5) / kPoints) * width) * width / kPoints;
        result.integral += expected[static_cast<std::size_t>(i)];
    }
    std::vector<double> counts(kBins, 0);
    Rng rng(24, key, 0);
    for (int n = 0; n < kDraws; ++n) {
        const double t = drawn.sample(rng.uniform());
        EXPECT_GE(t, domain.begin);
        EXPECT_LE(t, domain.end);
        EXPECT_GT(drawn.pdf(t), 0);
        if (t < end)
            ++counts[static_cast<std::size_t>(
                std::min(kBins - 1.0, kBins * (t - domain.begin) / (end - domain.begin)))];
    }
    for (double& e : expected)
        e *= kDraws;
    result.p = chi_squared_p(counts, expected);
    return result;
}

Light widened(Light light) {
    if (auto* s = std::get_if<SheetLight>(&light.shape)) s->thickness_um *= 1.15;
    if (auto* b = std::get_if<BeamLight>(&light.shape)) b->radius_um *= 1.15;
    if (auto* p = std::get_if<PointLight>(&light.shape)) p->position = p->position + Vec3{2, 2, 2};
    return light;
}

TEST(LitSections, DrawWithTheDensityTheySayAndItIntegratesToOne) {
    auto lights = shafts();
    PointLight point;
    point.position = {-30, 55, -40};
    lights.push_back(laser(point, 488, 1));
    for (std::size_t l = 0; l < lights.size(); ++l) {
        Rng rng(25, l, 0);
        int found = 0;
        int twins = 0;
        for (std::uint64_t r = 0; r < 40; ++r) {
            // Rays that cross the light, some of them at grazing angles, some starting inside it.
            const Vec3 crossing = Vec3{-200, 10, 30} + (40 + 250 * rng.uniform()) * kAlong +
                                  4 * sample_isotropic(rng.uniform(), rng.uniform());
            Vec3 direction = sample_isotropic(rng.uniform(), rng.uniform());
            if (r % 4 == 0) direction = normalized(kAlong + 0.1 * direction);
            const double before = r % 5 == 0 ? 0 : 200;
            const Ray ray{crossing - before * direction, direction};
            const Interval domain{r % 3 == 0 ? 20.0 * rng.uniform() : 0, 420};
            const LitCheck check = check_section(lights[l], lights[l], ray, domain, r);
            if (check.integral < 0) continue;
            ++found;
            EXPECT_NEAR(check.integral, 1, 0.02) << "light " << l << ", ray " << r;
            EXPECT_GT(check.p, kFiveSigma) << "light " << l << ", ray " << r;
            twins += check_section(lights[l], widened(lights[l]), ray, domain, r).p < kFiveSigma ? 1 : 0;
        }
        EXPECT_GT(found, 20) << "light " << l;
        EXPECT_GT(twins, found / 5) << "light " << l;  // a seventh wider shows where the ray crosses all of it
    }
}

TEST(LitSections, CoverAllThatTheLightShinesOn) {
    // Where a collimated light is bright and the domain is finite, the density must be positive, or light is lost for
    // estimators that rely on it alone.
    for (const Light& light : shafts()) {
        Rng rng(26, 0, 0);
        double lit = 0;
        double missed = 0;
        for (int r = 0; r < 300; ++r) {
            const Vec3 crossing = Vec3{-200, 10, 30} + (40 + 250 * rng.uniform()) * kAlong;
            const Vec3 direction = sample_isotropic(rng.uniform(), rng.uniform());
            const Ray ray{crossing - 200.0 * direction, direction};
            const LitSection section(light, ray, {0, 400});
            for (int i = 0; i < 200; ++i) {
                const double t = 400 * rng.uniform();
                const auto sample = sample_light(light, ray.at(t), 0.5, 0.5);
                if (!sample) continue;
                lit += sample->fluence_per_um2;
                if (!(section.pdf(t) > 0)) missed += sample->fluence_per_um2;
            }
        }
        EXPECT_GT(lit, 0);
        EXPECT_LT(missed, 1e-5 * lit);
    }
}

TEST(LitSections, EndlessDomainsAreNoTrouble) {
    PointLight point;
    point.position = {0, 3, 0};
    const Ray ray{{-10, 0, 0}, {1, 0, 0}};
    const double kFar = std::numeric_limits<double>::infinity();
    const LitSection section(laser(point, 488, 1), ray, {0, kFar});
    ASSERT_TRUE(section);
    Rng rng(27, 0, 0);
    for (int n = 0; n < 10000; ++n) {
        const double t = section.sample(rng.uniform());
        EXPECT_GE(t, 0);
        EXPECT_GT(section.pdf(t), 0);
    }
    // Equiangular: half of the angle lies before the closest approach at t = 10, tan of it 10/3.
    const double first = std::atan(10.0 / 3);
    const double share = first / (first + 0.5 * std::numbers::pi);
    RunningMean early;
    for (int n = 0; n < 100000; ++n)
        early.add(section.sample(rng.uniform()) < 10 ? 1 : 0);
    EXPECT_LT(std::abs(z_score(early, share)), 5);
    for (const Light& light : shafts()) {
        const LitSection lit(light, {{0, 0, 0}, kAlong}, {0, kFar});  // along the light: no density, or a right one
        if (lit) {
            EXPECT_TRUE(std::isfinite(lit.sample(0.7)));
        }
    }
}

}  // namespace
}  // namespace fluovox
