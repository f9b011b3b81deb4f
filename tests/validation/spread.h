#pragma once

#include "validation/case.h"

#include <cstdint>

namespace fluovox::validation {

struct SpreadSettings {
    int runs = 0;
    double share = 0.02;           ///< of the photons or samples that a case has fixed
    std::int64_t photons = 20000;  ///< where it has not
    std::uint64_t seed = 1;        ///< of the first run
};

/// How short runs of one case lie about each other and about the reference, by the standard errors that they tell.
struct Spread {
    double variance = 0;   ///< between runs, over the mean of the variances told; 1 where these are right
    double z = 0;          ///< mean over runs; 0 +- 1 / sqrt(runs)
    double z_squared = 0;  ///< mean over runs; 1 +- sqrt(2 / runs)
    double seconds = 0;
};

Spread spread_of(const Case& what, const SpreadSettings& settings);

}  // namespace fluovox::validation
