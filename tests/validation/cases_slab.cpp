// Plane layers: reflection, transmission and absorption as tabulated.

#include "scene_kit.h"
#include "validation/case.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace fluovox::validation {
namespace {

using testing::host;

constexpr int kFront = 4, kBack = 5;  // -z, +z

Light light_of(const std::string& kind) {
    if (kind == "lambertian") return lambertian_below();
    double cosine = 1;
    if (kind.starts_with("cosine ")) cosine = std::stod(kind.substr(7));
    return normal_pencil({0, 0, -1e-3}, {std::sqrt(1 - cosine * cosine), 0, cosine});
}

std::function<Estimate(const FluenceResult&)> measure_of(const std::string& quantity) {
    if (quantity == "R") return leaves(kFront);
    if (quantity == "T") return leaves(kBack);
    if (quantity == "A") return absorbed_by(0);
    if (quantity == "S") return [](const FluenceResult& r) { return r.share.excitation.escaped[kFront][0]; };
    return [](const FluenceResult& r) {  // R+S
        const Estimate& all = r.share.excitation.not_specular[kFront];
        const Estimate& mirrored = r.share.excitation.escaped[kFront][0];
        // Of the same photons, each of which does one or the other.
        const double variance = std::pow(all.standard_error, 2) + std::pow(mirrored.standard_error, 2) -
                                2 * all.value * mirrored.value / static_cast<double>(r.photons);
        return Estimate{all.value + mirrored.value, std::sqrt(variance)};
    };
}

Case slab_case(const std::vector<std::string>& row) {
    const double albedo = std::stod(row[1]);
    const double thickness = row[2] == "inf" ? std::numeric_limits<double>::infinity() : std::stod(row[2]);
    SceneMedium medium = host(SlabRegion{2, 0, thickness}, albedo, 1 - albedo, std::stod(row[3]));
    const double index = std::stod(row[4]);
    if (index != 1) medium.refractive_index = index;
    Case result;
    result.name =
        fmt::format("{}: a {}, tau {}, g {}, n {}, {}: {}", row[0], row[1], row[2], row[3], row[4], row[5], row[6]);
    result.expected = std::stod(row[7]);
    result.uncertainty = std::stod(row[8]);
    result.source = row[9];
    result.scene = scene_of({medium}, light_of(row[5]));
    result.measure = measure_of(row[6]);
    return result;
}

/// The same slab in layers, and behind clear glass of its own index, which must change nothing.
Case layered_case() {
    std::vector<SceneMedium> layers;
    for (int i = 0; i < 4; ++i)
        layers.push_back(host(SlabRegion{2, 0.5 * i, 0.5 * (i + 1)}, 0.99, 0.01, 0.9));
    for (SceneMedium& layer : layers)
        layer.refractive_index = 1.4;
    SceneMedium glass = host(SlabRegion{2, -1, 3}, 0, 0);
    glass.refractive_index = 1.4;
    layers.push_back(glass);
    Case result;
    result.name = "slab with index in four layers between matched glass: a 0.99, tau 2, g 0.9, n 1.4: R";
    for (const auto& row : load_reference("slabs.csv")) {
        if (row[1] == "0.99" && row[2] == "2" && row[3] == "0.9" && row[4] == "1.4")
            result.expected = std::stod(row[7]);
    }
    result.uncertainty = 1e-9;
    result.source = "as the slab in one piece";
    result.scene = scene_of(layers, normal_pencil({0, 0, -2}));
    result.measure = leaves(kFront);
    return result;
}

Case two_layers() {
    SceneMedium upper = host(SlabRegion{2, 0, 0.1}, 20, 2, 0.7);
    SceneMedium lower = host(SlabRegion{2, 0.1}, 20, 1, 0.9);
    upper.refractive_index = 1.3;
    lower.refractive_index = 1.4;
    Case result;
    result.name = "two layers of index 1.3 and 1.4 (mm): R";
    result.expected = 0.5 * (0.1049 + 0.1050);
    result.uncertainty = 1.4e-4;
    result.source = "mean of two Monte Carlo programs, MCCL and MCML (Virtual Photonics)";
    result.finer = 2;
    result.scene = scene_of({upper, lower}, normal_pencil({0, 0, -1e-3}));
    result.measure = leaves(kFront);
    return result;
}

}  // namespace

std::vector<Case> slab_cases() {
    std::vector<Case> cases;
    const auto rows = load_reference("slabs.csv");
    for (std::size_t i = 1; i < rows.size(); ++i)
        cases.push_back(slab_case(rows[i]));
    cases.push_back(layered_case());
    cases.push_back(two_layers());
    return cases;
}

}  // namespace fluovox::validation
