#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/render.h"

namespace fluovox {

/// The estimator "cached": photons from the lights leave what they could excite in an ExcitationCache; then photons
/// leave the dyes where that, or light straight from the lights, excites them (DyeGlow), each of whose events is
/// connected to the camera. Through refracting surfaces, where nothing can be connected, paths from the camera gather
/// what the cache holds (CameraGather). Light that was not converted is found by paths from the camera. Biased by the
/// size of the cache's voxels only, which a scattered light's slow change hardly notices.
///
/// All samples of an image would share the noise of one cache, so the whole is done in independent batches of both
/// passes: the film has one sample per batch, the mean of its paths, and its error bars tell all noise there is.
/// Throws SceneError where a camera path or the cache cannot sample what the scene asks for.
RenderResult render_from_cache(const Scene& scene, Progress& progress);

}  // namespace fluovox
