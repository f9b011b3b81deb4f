// What the validation must notice: each case is one of the others with a mistake in it.

#include "scene_kit.h"
#include "validation/case.h"

#include <utility>

namespace fluovox::validation {
namespace {

using testing::host;

constexpr int kFront = 4, kBack = 5;

Case slab_twin(const std::string& name, const SceneMedium& medium, double expected,
               std::function<Estimate(const FluenceResult&)> measure) {
    Case result;
    result.name = name;
    result.expected = expected;
    result.uncertainty = 1e-9;
    result.scene = scene_of({medium}, normal_pencil({0, 0, -1e-3}));
    result.measure = std::move(measure);
    return result;
}

}  // namespace

std::vector<Case> broken_cases() {
    std::vector<Case> cases;
    cases.push_back(cascade_case(0.9, 0.08, 0.9 * 1.01, std::nullopt, 0.6248877375 - 0.4149474791));
    cases.back().name = "yield 1 % too high (cascade)";
    cases.push_back(slab_twin("g 1 % too high (thick Henyey-Greenstein slab)",
                              host(SlabRegion{2, 0, 16}, 0.99, 0.01, 0.9 * 1.01), 0.3231746792, leaves(kFront)));
    cases.push_back(slab_twin("extinction 1 % too high (thin slab)", host(SlabRegion{2, 0, 1}, 0.9 * 1.01, 0.1 * 1.01),
                              0.5916250896, leaves(kBack)));
    cases.back().finer = 2;
    SceneMedium glass = host(SlabRegion{2, 0, 2}, 0.99, 0.01);
    glass.refractive_index = 1.33;
    cases.push_back(slab_twin("specular reflection left out (slab of index 1.33)", glass, 0.0200593122 + 0.4335452812,
                              leaves(kFront)));
    cases.push_back(watts_case(false));
    cases.back().name = "energy that photons lose (Stokes) left out (watts)";
    cases.push_back(voxel_slab("", 0, 0.99, 1));
    cases.back().name = "bounds of voxels 1 % too low (slab in voxels)";
    cases.back().finer = 2;
    return cases;
}

}  // namespace fluovox::validation
