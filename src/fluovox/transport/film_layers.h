#pragma once

#include "fluovox/scene/scene.h"

#include <cstddef>

namespace fluovox {

/// Places of the layers of a film, in the order of Film::add: all light, what was never converted, fluorescence, and
/// where the film asks for it the light of each dye. Without dyes there is only the first.
inline constexpr std::size_t kTotalPlace = 0, kElasticPlace = 1, kFluorescencePlace = 2, kFirstDyePlace = 3;

inline std::size_t count_film_layers(const Scene& scene) {
    if (scene.dyes.empty()) return 1;
    return kFirstDyePlace + (scene.description.film.per_dye ? scene.dyes.size() : 0);
}

}  // namespace fluovox
