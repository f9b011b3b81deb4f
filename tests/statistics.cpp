#include "statistics.h"

#include <boost/math/special_functions/gamma.hpp>

#include <algorithm>
#include <cstddef>

namespace fluovox::testing {

double chi_squared_p(const std::vector<double>& observed, const std::vector<double>& expected) {
    constexpr double kLeast = 10;
    double statistic = 0;
    int bins = 0;
    double o = 0;
    double e = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        o += observed[i];
        e += expected[i];
        if (e < kLeast) continue;
        statistic += (o - e) * (o - e) / e;
        ++bins;
        o = e = 0;
    }
    if (o > kLeast && e == 0) return 0;
    if (e > 0) {  // the rest joins nobody: a bin of its own, a little less exact
        statistic += (o - e) * (o - e) / std::max(e, 1.0);
        ++bins;
    }
    return bins < 2 ? 1 : boost::math::gamma_q(0.5 * (bins - 1), 0.5 * statistic);
}

}  // namespace fluovox::testing
