#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"

#include <span>

namespace fluovox {

/// A direction that light which was scattered forward is likely to have, spread as by Henyey-Greenstein with `g`.
struct DirectionLobe {
    Vec3 axis;
    double g = 0;
};

/// Draws a direction: a quarter of them isotropic, the others from the lobes in equal parts; all isotropic without
/// lobes.
Vec3 sample_direction(std::span<const DirectionLobe> lobes, Rng& rng);

/// Density of `sample_direction`, per steradian.
double direction_pdf(std::span<const DirectionLobe> lobes, Vec3 direction);

}  // namespace fluovox
