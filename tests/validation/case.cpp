#include "validation/case.h"

#include "fluovox/core/error.h"

#include "scene_kit.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <future>
#include <sstream>
#include <thread>
#include <utility>

namespace fluovox::validation {
namespace {

FluenceResult trace(const Case& what, std::int64_t photons, std::uint64_t seed) {
    FluenceSettings settings = what.settings;
    settings.photons = photons;
    settings.seed = seed;
    NoProgress progress;
    return trace_fluence(what.scene, settings, progress);
}

constexpr double kOfValue = 1e-3, kOfLaunched = 3e-4;

/// Of independent runs, with its standard error.
Estimate mean_of(const std::vector<double>& values) {
    const auto count = static_cast<double>(values.size());
    double sum = 0;
    for (const double value : values)
        sum += value;
    const double mean = sum / count;
    double squares = 0;
    for (const double value : values)
        squares += (value - mean) * (value - mean);
    return {mean, std::sqrt(squares / (count - 1) / count)};
}

double size_of(const Case& what) {
    return what.size > 0 ? what.size : std::abs(what.expected);
}

}  // namespace

Estimate estimate_of(const Case& what, std::int64_t photons, std::uint64_t seed) {
    return what.estimate ? what.estimate(photons, seed) : what.measure(trace(what, photons, seed));
}

double Outcome::z() const {
    return (got.value - what->expected) / std::hypot(got.standard_error, what->uncertainty);
}

bool Outcome::fine_in_value() const {
    return got.standard_error <= kOfValue * size_of(*what);
}

bool Outcome::fine_in_launched() const {
    const double scale = what->reaches_sensor ? size_of(*what) / *what->reaches_sensor : what->scale;
    return got.standard_error <= kOfLaunched * scale;
}

std::string Outcome::precision() const {
    if (what->many) return "many values";
    if (fine_in_value()) return fine_in_launched() ? "both" : "value";
    if (!fine_in_launched()) return "MISSED";
    return what->reaches_sensor ? fmt::format("launched ({:.1e} of it seen)", *what->reaches_sensor) : "launched";
}

Outcome run(const Case& what, std::uint64_t seed) {
    constexpr double kPilot = 20000;
    constexpr double kLeast = 50000;
    constexpr double kMost = 3e7;
    constexpr double kSpare = 1.15;
    const auto begin = std::chrono::steady_clock::now();
    Outcome outcome;
    outcome.what = &what;
    outcome.photons = what.fixed;
    if (what.fixed > 0) {
        outcome.got = estimate_of(what, outcome.photons, seed);
    } else {
        const double asked = std::max(kOfValue * size_of(what), kOfLaunched * what.scale) / what.finer;
        const double wanted = what.aim > 0 ? what.aim : asked;
        auto before = static_cast<std::int64_t>(kPilot);
        outcome.got = estimate_of(what, before, seed + 1000000);
        for (std::uint64_t round = 0; round < 3; ++round) {
            const double needed =
                kSpare * static_cast<double>(before) * std::pow(outcome.got.standard_error / wanted, 2);
            outcome.photons = before = static_cast<std::int64_t>(std::clamp(needed, kLeast, kMost));
            outcome.got = estimate_of(what, before, seed + 2000000 * round);
            if (outcome.got.standard_error <= wanted) break;
        }
    }
    outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return outcome;
}

Estimate deviation_of(double chi_squared, double degrees_of_freedom) {
    const boost::math::chi_squared distribution(degrees_of_freedom);
    const double above = boost::math::cdf(boost::math::complement(distribution, chi_squared));
    constexpr double kLeast = 1e-300;
    if (above < 0.5) {
        return {boost::math::quantile(boost::math::complement(boost::math::normal(), std::max(above, kLeast))), 1};
    }
    return {boost::math::quantile(boost::math::normal(), std::max(boost::math::cdf(distribution, chi_squared), kLeast)),
            1};
}

Estimate deviation_of_largest(double t, double count, double degrees_of_freedom) {
    const boost::math::students_t distribution(degrees_of_freedom);
    const double each = 2 * boost::math::cdf(boost::math::complement(distribution, t));
    // Chance that none of them is as large.
    const double below = std::clamp(std::exp(count * std::log1p(-each)), 1e-300, 1 - 1e-16);
    return {boost::math::quantile(boost::math::normal(), below), 1};
}

Estimate mean_of_runs(int runs, std::uint64_t seed, const std::function<double(std::uint64_t)>& run) {
    std::vector<double> values;
    for (int i = 0; i < runs; ++i)
        values.push_back(run(seed * 1000 + static_cast<std::uint64_t>(i)));
    return mean_of(values);
}

Estimate mean_of_runs_at_once(int runs, std::uint64_t seed, const std::function<double(std::uint64_t)>& run) {
    std::vector<double> values(static_cast<std::size_t>(runs));
    const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
    std::vector<std::future<void>> pending;
    for (std::size_t t = 0; t < threads; ++t) {
        pending.push_back(std::async(std::launch::async, [&, t] {
            for (std::size_t i = t; i < values.size(); i += threads)
                values[i] = run(seed * 1000 + i);
        }));
    }
    for (auto& part : pending)
        part.get();
    return mean_of(values);
}

Light normal_pencil(Vec3 position, Vec3 direction) {
    BeamLight beam;
    beam.position = beam.waist = position;
    beam.direction = direction;
    return testing::laser(beam, 480, 1);
}

Light lambertian_below() {
    RectangleLight light;
    light.center = {0, 0, -1e-3};
    light.normal = {0, 0, 1};
    light.up = {0, 1, 0};
    light.width_um = light.height_um = 1;
    return testing::laser(light, 480, 1);
}

Scene scene_of(std::vector<SceneMedium> media, Light light) {
    Scene scene;
    scene.media = std::move(media);
    scene.lights = {std::move(light)};
    return scene;
}

std::vector<std::vector<std::string>> load_reference(const std::string& file) {
    std::ifstream in(FLUOVOX_SOURCE_DIR "/tests/reference/" + file);
    if (!in) throw InputError(file + ": cannot be read");
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream cells(line);
        auto& row = rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(cell);
    }
    return rows;
}

std::function<Estimate(const FluenceResult&)> leaves(int face) {
    return [face](const FluenceResult& r) { return r.share.excitation.not_specular[static_cast<std::size_t>(face)]; };
}
std::function<Estimate(const FluenceResult&)> fluorescence_leaves(int face) {
    return [face](const FluenceResult& r) { return r.share.emission.not_specular[static_cast<std::size_t>(face)]; };
}
std::function<Estimate(const FluenceResult&)> absorbed_by(std::size_t medium) {
    return [medium](const FluenceResult& r) { return r.share.excitation.absorbed[medium]; };
}

}  // namespace fluovox::validation
