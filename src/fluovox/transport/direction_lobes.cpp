#include "fluovox/transport/direction_lobes.h"

#include "fluovox/medium/phase_function.h"

#include <cstddef>
#include <numbers>

namespace fluovox {
namespace {

// Enough for what comes from beside the lobes; more of it costs photons that are of little use.
constexpr double kIsotropic = 0.25;

}  // namespace

Vec3 sample_direction(std::span<const DirectionLobe> lobes, Rng& rng) {
    if (lobes.empty() || rng.uniform() < kIsotropic) return sample_isotropic(rng);
    const DirectionLobe& lobe = lobes[static_cast<std::size_t>(rng.uniform() * static_cast<double>(lobes.size()))];
    return turned(lobe.axis, sample_henyey_greenstein_cosine(lobe.g, rng.uniform()), rng.uniform());
}

double direction_pdf(std::span<const DirectionLobe> lobes, Vec3 direction) {
    constexpr double kSphere_sr = 4 * std::numbers::pi;
    if (lobes.empty()) return 1 / kSphere_sr;
    double leaning = 0;
    for (const DirectionLobe& lobe : lobes)
        leaning += henyey_greenstein(dot(direction, lobe.axis), lobe.g);
    return kIsotropic / kSphere_sr + (1 - kIsotropic) * leaning / static_cast<double>(lobes.size());
}

}  // namespace fluovox
