#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/camera_sink.h"
#include "fluovox/transport/photon_tracer.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>

namespace fluovox {

/// Traces photons whose splats go onto a film, on all threads.
class PhotonRounds {
public:
    /// What a thread has of its own.
    struct Worker {
        PhotonTracer<CameraSink> tracer;
        CameraSink sink;
    };

    /// `photons_per_s`: what the weight 1 of a photon stands for.
    PhotonRounds(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits, double photons_per_s);
    ~PhotonRounds();
    PhotonRounds(const PhotonRounds&) = delete;
    PhotonRounds& operator=(const PhotonRounds&) = delete;

    /// Calls `trace` for all numbers below `photons`, in any order, and `add` with their splats in the order of the
    /// numbers, so that sums do not depend on the threads. Stops early when the user stops `progress`.
    void trace(std::int64_t photons, Progress& progress, CameraSink::Order order,
               const std::function<void(Worker&, std::int64_t)>& trace,
               const std::function<void(std::span<const Splat>)>& add);

    TrackingCounts counts() const;

private:
    struct Threads;
    std::unique_ptr<Threads> threads_;
};

}  // namespace fluovox
