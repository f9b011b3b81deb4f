#pragma once

#include "fluovox/scene/scene.h"
#include "fluovox/transport/fluence.h"

#include <functional>
#include <string>
#include <vector>

namespace fluovox::validation {

/// A number somebody else found, and how we find it.
struct Case {
    std::string name;
    double expected = 0;
    double uncertainty = 0;  ///< of `expected`, one sigma
    std::string source;
    Scene scene;
    std::function<Estimate(const FluenceResult&)> measure;
    double scale = 1;  ///< of what is measured as a share of the launched, for the precision that is asked
    FluenceSettings settings = {};
};

struct Outcome {
    const Case* what = nullptr;
    Estimate got;
    std::int64_t photons = 0;
    double seconds = 0;

    double z() const;
};

/// Runs one case to a standard error of 1e-3 of the value or 3e-4 of the launched, whichever is larger: a short run
/// tells how many photons that takes, another with other random numbers is the result.
Outcome run(const Case& what, std::uint64_t seed);

std::vector<Case> slab_cases();
std::vector<Case> geometry_cases();
std::vector<Case> fluorescence_cases();

// Scenes of one light; lengths in micrometres stand for any unit.
Light normal_pencil(Vec3 position, Vec3 direction = {0, 0, 1});
/// Lambertian light on the face z = 0 of a slab, from below, over a small square.
Light lambertian_below();
Scene scene_of(std::vector<SceneMedium> media, Light light);

/// Rows of a table in tests/reference without its comments; the first is its header.
std::vector<std::vector<std::string>> load_reference(const std::string& file);

// What is measured.
std::function<Estimate(const FluenceResult&)> leaves(int face);  ///< not specular
std::function<Estimate(const FluenceResult&)> fluorescence_leaves(int face);
std::function<Estimate(const FluenceResult&)> absorbed_by(std::size_t medium);

}  // namespace fluovox::validation
