#include "fluovox/core/exponential.h"

#include "fluovox/core/rng.h"

#include <cmath>
#include <cstddef>

namespace fluovox {
namespace {

ExponentialLayers make_layers() {
    constexpr double kTail = 7.69711747013104972;  // where 256 layers of this area end at the top, y = 1
    const double area = std::exp(-kTail) * (1 + kTail);
    ExponentialLayers layers;
    layers.x[0] = area / std::exp(-kTail);  // as wide as a box of its height and area, its tail counted in
    layers.x[1] = kTail;
    layers.y[1] = std::exp(-kTail);
    for (std::size_t i = 2; i < 256; ++i) {
        layers.y[i] = layers.y[i - 1] + area / layers.x[i - 1];
        layers.x[i] = -std::log(layers.y[i]);
    }
    layers.x[256] = 0;
    layers.y[256] = 1;
    return layers;
}

}  // namespace

const ExponentialLayers kExponentialLayers = make_layers();

double Rng::exponential_at_edge(std::size_t layer, double x) {
    if (layer == 0) return kExponentialLayers.x[1] + exponential();  // the tail looks like the whole
    const double low = kExponentialLayers.y[layer];
    const double high = kExponentialLayers.y[layer + 1];
    return low + uniform() * (high - low) < std::exp(-x) ? x : exponential();
}

}  // namespace fluovox
