#include "validation/spread.h"

#include "statistics.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace fluovox::validation {

Spread spread_of(const Case& what, const SpreadSettings& settings) {
    const auto begin = std::chrono::steady_clock::now();
    const auto fixed = static_cast<std::int64_t>(settings.share * static_cast<double>(what.fixed));
    const std::int64_t count = what.fixed > 0 ? std::max<std::int64_t>(2, fixed) : settings.photons;
    Spread spread;
    testing::RunningMean values;
    testing::RunningMean told;
    testing::RunningMean deviations;
    for (int run = 0; run < settings.runs; ++run) {
        const Outcome outcome{&what, estimate_of(what, count, settings.seed + static_cast<std::uint64_t>(run)), 0, 0};
        values.add(outcome.got.value);
        told.add(std::pow(outcome.got.standard_error, 2));
        deviations.add(outcome.z());
        spread.z_squared += std::pow(outcome.z(), 2) / settings.runs;
    }
    spread.variance = values.sum_of_squares / (settings.runs - 1) / told.mean;
    spread.z = deviations.mean;
    spread.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return spread;
}

}  // namespace fluovox::validation
