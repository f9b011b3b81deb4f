#pragma once

#include <vector>

namespace fluovox::reference {

/// A layer of a sample whose layers all have one refractive index.
struct PlaneLayer {
    double albedo = 0, thickness = 0, g = 0;  ///< optical thickness; Henyey-Greenstein
};

struct PlaneFluxes {
    double specular = 0;     ///< of the light that arrives, at the first side (both faces of its glass)
    double reflected = 0;    ///< the rest that comes back
    double transmitted = 0;  ///< with the unscattered part
};

/// Light that falls straight, from air, on layers of refractive index `index` between sheets of clear glass of index
/// `glass` (the same as `index`: none). Adding-doubling on quadrature points inside the sample; shares no code and no
/// method with the Monte Carlo it is compared with. `points`: even; 64 give six digits.
PlaneFluxes adding_doubling(const std::vector<PlaneLayer>& layers, double index, double glass, int points = 64);

}  // namespace fluovox::reference
