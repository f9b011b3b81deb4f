#pragma once

#include "fluovox/scene/scene.h"

#include <vector>

namespace fluovox {

/// Wavelengths that light may have on its way through the scene: those of the lights and of what the dyes emit.
std::vector<double> travelling_wavelengths_nm(const Scene& scene);

/// Throws SceneError at a medium without end in which light of one of these wavelengths would scatter for ever, since
/// nothing that is without end absorbs it. Passes where render.max_scatterings bounds the work.
void require_an_end(const Scene& scene, const std::vector<double>& wavelengths_nm);

}  // namespace fluovox
