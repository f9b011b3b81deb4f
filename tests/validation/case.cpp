#include "validation/case.h"

#include "fluovox/core/error.h"

#include "scene_kit.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
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

}  // namespace

double Outcome::z() const {
    return (got.value - what->expected) / std::hypot(got.standard_error, what->uncertainty);
}

Outcome run(const Case& what, std::uint64_t seed) {
    constexpr double kPilot = 20000, kLeast = 50000, kMost = 3e7;
    const auto begin = std::chrono::steady_clock::now();
    const Estimate pilot = what.measure(trace(what, static_cast<std::int64_t>(kPilot), seed + 1000000));
    const double wanted = std::max(1e-3 * std::abs(what.expected), 3e-4 * what.scale);
    const double needed = 1.15 * kPilot * std::pow(pilot.standard_error / wanted, 2);
    Outcome outcome;
    outcome.what = &what;
    outcome.photons = static_cast<std::int64_t>(std::clamp(needed, kLeast, kMost));
    outcome.got = what.measure(trace(what, outcome.photons, seed));
    outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return outcome;
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
