#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/image/film.h"
#include "fluovox/transport/pixel_renderer.h"

#include <functional>

namespace fluovox {

/// A film for what the scene's camera sees, without samples.
Film empty_film(const Scene& scene);

/// Calls `work` for all pixels from many threads, with a renderer of `sought` light of the thread's own; stops early
/// when the user stops `progress`. What is the same for each pixel gives the same film for any number of threads.
TrackingCounts for_each_pixel(const Scene& scene, const Illumination& illumination, PixelRenderer::Sought sought,
                              const Progress& progress, const std::function<void(PixelRenderer&, int)>& work);

}  // namespace fluovox
