#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/image/film.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/optical_field.h"

#include <cstddef>
#include <optional>
#include <string>

namespace fluovox {

struct RenderResult {
    Film film;
    TrackingCounts counts;
    bool stopped = false;         ///< the user stopped it; the film is not complete
    std::size_t guess_bytes = 0;  ///< memory of guesses (LightShadows) while it ran
};

/// What a scene is rendered with.
struct EstimatorChoice {
    std::string name;  ///< as in the scene file, never "auto"
    std::string why;   ///< where the scene leaves it open: the reason, to print after the name; else empty
};

/// The scene's estimator, or what "auto" stands for: one that can show every light there is, "cached" where light is
/// scattered on its way to a dye, else "path".
EstimatorChoice chosen_estimator(const Scene& scene);

/// A film for what the scene's camera sees, without samples.
Film empty_film(const Scene& scene);

/// Renders the scene with its own settings. The same scene and seed give the same film for any number of threads.
/// Throws SceneError where the estimator cannot sample what the scene asks for.
RenderResult render(const Scene& scene, Progress& progress);

}  // namespace fluovox
