#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/render.h"

namespace fluovox {

/// The estimator "light": photons from the lights (width x height x samples of them), whose every emission and every
/// scattering is connected to the camera. Finds what paths from the camera cannot: pencil beams, and collimated light
/// that shines into the camera. The film is the same for any number of threads.
/// Throws SceneError where such a connection cannot be made: refracting surfaces, uniform light that the film sees.
RenderResult render_from_lights(const Scene& scene, Progress& progress);

}  // namespace fluovox
