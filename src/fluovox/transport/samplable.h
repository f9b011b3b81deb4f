#pragma once

#include "fluovox/scene/scene.h"

namespace fluovox {

/// Throws SceneError at the light that a path from the camera can never meet, so that no image comes out dark without
/// a word: one without width, or collimated light that shines straight into the camera and onto its film; and at a
/// medium that light would never leave.
void require_samplable_by_path(const Scene& scene);

/// True when `require_samplable_by_path` has nothing to say about the lights.
bool path_shows_all_lights(const Scene& scene);

/// The same where photons from the lights excite the dyes: only light that the film sees unconverted must be found.
void require_samplable_with_cache(const Scene& scene);

}  // namespace fluovox
