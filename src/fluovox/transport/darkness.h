#pragma once

#include "fluovox/image/film.h"
#include "fluovox/scene/scene.h"

#include <string>
#include <vector>

namespace fluovox {

/// True when no pixel of the film received anything in a layer: by default that which shows the dyes (without dyes, or
/// without the layer, any light).
bool is_dark(const Film& film, const char* layer = kFluorescenceLayer);

/// Why an image of this scene may be black: what misses what, by how much. A sentence for each reason found.
std::vector<std::string> reasons_for_darkness(const Scene& scene);

/// By how much each light misses each medium that has bounds, and media whose grids are empty. A sentence for each.
std::vector<std::string> how_lights_miss(const Scene& scene);

}  // namespace fluovox
