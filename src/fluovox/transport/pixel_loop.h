// Internal: it includes TBB.
#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/transport/optical_field.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <memory>

namespace fluovox {

/// Calls `work(renderer, pixel)` for so many pixels from many threads, each with a renderer of its own from `make`;
/// stops early when the user stops `progress`. What is the same for each pixel gives the same film for any number of
/// threads. Gives what the renderers counted.
template <class Make, class Work>
TrackingCounts for_each_pixel(int pixels, const Progress& progress, const Make& make, const Work& work) {
    using Renderer = decltype(make());
    tbb::enumerable_thread_specific<std::unique_ptr<Renderer>> renderers;
    tbb::parallel_for(tbb::blocked_range<int>(0, pixels, 16), [&](const auto& range) {
        auto& renderer = renderers.local();
        if (!renderer) renderer = std::unique_ptr<Renderer>(new Renderer(make()));
        for (int pixel = range.begin(); pixel < range.end() && !progress.stopped(); ++pixel)
            work(*renderer, pixel);
    });
    TrackingCounts counts;
    for (const auto& renderer : renderers)
        counts += renderer->counts();
    return counts;
}

}  // namespace fluovox
