// Samples of several layers and glass, and the light that leaves a slab by its angle.

#include "adding_doubling.h"
#include "scene_kit.h"
#include "validation/case.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace fluovox::validation {
namespace {

using reference::PlaneLayer;
using testing::host;

constexpr int kFront = 4, kBack = 5;

/// Reflected with what glass and surface mirror, or transmitted.
std::function<Estimate(const FluenceResult&)> total(int face) {
    return [face](const FluenceResult& r) {
        const Estimate& all = r.share.excitation.not_specular[static_cast<std::size_t>(face)];
        const Estimate& mirrored = r.share.excitation.escaped[static_cast<std::size_t>(face)][0];
        // Of the same photons, each of which does one or the other.
        const double variance = std::pow(all.standard_error, 2) + std::pow(mirrored.standard_error, 2) -
                                2 * all.value * mirrored.value / static_cast<double>(r.photons);
        return Estimate{all.value + mirrored.value, std::sqrt(variance)};
    };
}

void add_sample(std::vector<Case>& cases, const std::string& name, const std::vector<PlaneLayer>& layers, double index,
                double glass) {
    std::vector<SceneMedium> media;
    double depth = 0;
    for (const PlaneLayer& layer : layers) {
        const SlabRegion region{2, depth, depth + layer.thickness};
        media.push_back(host(region, layer.albedo, 1 - layer.albedo, layer.g));
        media.back().refractive_index = index;
        depth += layer.thickness;
    }
    if (glass != index) {
        for (const SlabRegion sheet : {SlabRegion{2, -0.3, 0}, SlabRegion{2, depth, depth + 0.3}}) {
            media.push_back(host(sheet, 0, 0));
            media.back().refractive_index = glass;
        }
    }
    const reference::PlaneFluxes exact = reference::adding_doubling(layers, index, glass, 96);
    for (const bool back : {false, true}) {
        Case one;
        one.name = name + (back ? ": T" : ": R+S");
        one.expected = back ? exact.transmitted : exact.reflected + exact.specular;
        one.uncertainty = 2e-5;  // of the quadrature
        one.source = "adding-doubling (tests/reference)";
        one.scene = scene_of(media, normal_pencil({0, 0, -1}));
        one.measure = total(back ? kBack : kFront);
        cases.push_back(std::move(one));
    }
}

/// Radiance times cosine of the light that leaves the van de Hulst slab, in degrees 1.5, 4.5 ... 88.5: bins of one
/// degree in the middle of the table's.
Case angles_case(int face) {
    Case result;
    result.name =
        fmt::format("van de Hulst slab: {} at 30 angles (chi-squared as a deviation)", face == kFront ? "R" : "T");
    result.source = "van de Hulst 1980 table 35; discrete ordinates";
    result.scene = scene_of({host(SlabRegion{2, 0, 2}, 0.9, 0.1, 0.75)}, normal_pencil({0, 0, -1e-3}));
    result.fixed = 15000000;
    result.many = true;
    std::vector<double> per_sr;
    for (const auto& row : load_reference("slab_angles.csv")) {
        if (row[0] == (face == kFront ? "R" : "T")) per_sr.push_back(std::stod(row[2]));
    }
    result.settings.angle_bins = 90;
    result.measure = [face, per_sr](const FluenceResult& r) {
        const auto& bins = r.share.excitation.by_angle[static_cast<std::size_t>(face)][2];
        constexpr double kDegree = std::numbers::pi / 180;
        double squares = 0;
        for (std::size_t i = 0; i < per_sr.size(); ++i) {
            const double angle = (3 * static_cast<double>(i) + 1.5) * kDegree;
            const double expected = per_sr[i] * 2 * std::numbers::pi * std::sin(angle) * 2 * std::sin(0.5 * kDegree);
            const Estimate& bin = bins[3 * i + 1];
            squares += std::pow((bin.value - expected) / bin.standard_error, 2);
        }
        return deviation_of(squares, static_cast<double>(per_sr.size()));
    };
    return result;
}

}  // namespace

std::vector<Case> layer_cases() {
    std::vector<Case> cases;
    cases.push_back(angles_case(kFront));
    cases.push_back(angles_case(kBack));
    // The sample that comes with MCML: mu_a, mu_s, g and thickness 1, 100, 0.9, 0.1; 1, 10, 0, 0.1; 2, 10, 0.7, 0.2
    // (cm).
    add_sample(cases, "three layers of index 1.37",
               {{100.0 / 101, 10.1, 0.9}, {10.0 / 11, 1.1, 0}, {10.0 / 12, 2.4, 0.7}}, 1.37, 1.37);
    add_sample(cases, "slab of index 1.4 between slides of 1.5: a 0.5, tau 1, g 0.9", {{0.5, 1, 0.9}}, 1.4, 1.5);
    add_sample(cases, "milky water between cuvette glass of 1.52: a 0.99, tau 4, g 0.8", {{0.99, 4, 0.8}}, 1.33, 1.52);
    return cases;
}

}  // namespace fluovox::validation
