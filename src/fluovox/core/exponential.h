#pragma once

#include <array>

namespace fluovox {

/// The layers of equal area that lie under exp(-x), from the lowest, widest one up: layer i reaches from 0 to x[i], and
/// from y[i] up to y[i + 1] = exp(-x[i + 1]). The tail beyond x[1] belongs to the lowest.
/// The ziggurat method: Marsaglia & Tsang, J. Stat. Softw. 5(8) (2000), doi:10.18637/jss.v005.i08.
struct ExponentialLayers {
    std::array<double, 257> x{}, y{};
};
extern const ExponentialLayers kExponentialLayers;

}  // namespace fluovox
