#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/image/film.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/optical_field.h"

#include <optional>
#include <string>

namespace fluovox {

struct RenderResult {
    Film film;
    TrackingCounts counts;
    bool stopped = false;  ///< the user stopped it; the film is not complete
};

/// The name of the estimator that "auto" stands for in this scene.
std::string chosen_estimator(const Scene& scene);

/// Renders the scene with its own settings. The same scene and seed give the same film for any number of threads.
/// Throws SceneError where the estimator cannot sample what the scene asks for.
RenderResult render(const Scene& scene, Progress& progress);

}  // namespace fluovox
