#pragma once

#include <string>
#include <utility>
#include <vector>

namespace fluovox {

/// Where an axis has its ticks.
struct AxisTicks {
    std::vector<double> at;
    std::vector<std::string> labels;  ///< one for each, all with as many decimals as the step needs
};

/// Ticks at round numbers (steps of 1, 2 or 5 times a power of ten) from `low` to `high`, about `count` of them.
AxisTicks axis_ticks(double low, double high, int count);

/// The least and the highest of `values` that are finite; 0 and 1 when there are none.
std::pair<double, double> finite_range(const std::vector<double>& values);

}  // namespace fluovox
