#include "fluovox/image/plot_axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace fluovox {
namespace {

double round_step(double rough) {
    const double decade = std::pow(10, std::floor(std::log10(rough)));
    for (const double factor : {1.0, 2.0, 5.0}) {
        if (rough <= factor * decade * (1 + 1e-9)) return factor * decade;
    }
    return 10 * decade;
}

}  // namespace

AxisTicks axis_ticks(double low, double high, int count) {
    AxisTicks ticks;
    if (!(high > low) || !std::isfinite(high - low)) return ticks;
    const double step = round_step((high - low) / std::max(count, 1));
    const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 300);
    const double largest = std::max(std::fabs(low), std::fabs(high));
    const bool as_power = largest >= 1e6 || largest < 1e-3;  // plain digits would not fit beside the axis
    const auto first = static_cast<long long>(std::ceil(low / step - 1e-9));
    const auto last = static_cast<long long>(std::floor(high / step + 1e-9));
    for (long long i = first; i <= last; ++i) {
        const double value = static_cast<double>(i) * step;
        ticks.at.push_back(value);
        ticks.labels.push_back(as_power ? fmt::format("{:.3g}", value) : fmt::format("{:.{}f}", value, decimals));
    }
    return ticks;
}

std::pair<double, double> finite_range(const std::vector<double>& values) {
    double low = 0;
    double high = 1;
    bool any = false;
    for (const double value : values) {
        if (!std::isfinite(value)) continue;
        low = any ? std::min(low, value) : value;
        high = any ? std::max(high, value) : value;
        any = true;
    }
    return {low, high};
}

}  // namespace fluovox
