#include "fluovox/transport/photon_rounds.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

namespace fluovox {

struct PhotonRounds::Threads {
    Threads(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits, double photons_per_s)
        : workers([&scene, &space, limits, photons_per_s] {
              return std::make_unique<Worker>(
                  Worker{PhotonTracer<CameraSink>(scene, space, limits), CameraSink(scene, photons_per_s)});
          }) {}
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers;
};

PhotonRounds::PhotonRounds(const Scene& scene, const PhotonSpace& space, const PhotonLimits& limits,
                           double photons_per_s)
    : threads_(std::make_unique<Threads>(scene, space, limits, photons_per_s)) {}

PhotonRounds::~PhotonRounds() = default;

void PhotonRounds::trace(std::int64_t photons, Progress& progress, CameraSink::Order order,
                         const std::function<void(Worker&, std::int64_t)>& trace,
                         const std::function<void(std::span<const Splat>)>& add) {
    constexpr std::int64_t kBatch = 1000;
    constexpr std::int64_t kRound = 64;
    std::vector<Splats> batches(kRound);
    for (std::int64_t round = 0; round < photons && !progress.stopped(); round += kBatch * kRound) {
        tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, kRound, 1), [&](const auto& range) {
            Worker& worker = *threads_->workers.local();
            for (std::int64_t b = range.begin(); b < range.end() && !progress.stopped(); ++b) {
                Splats& batch = batches[static_cast<std::size_t>(b)];
                batch.clear();
                const std::int64_t first = std::min(photons, round + b * kBatch);
                const std::int64_t last = std::min(photons, first + kBatch);
                for (std::int64_t n = first; n < last && !progress.stopped(); ++n) {
                    trace(worker, n);
                    worker.sink.finish(batch, order);
                }
                progress.advance(last - first);
            }
        });
        if (progress.stopped()) return;
        for (const Splats& batch : batches)
            add(batch);
    }
}

TrackingCounts PhotonRounds::counts() const {
    TrackingCounts counts;
    for (const auto& worker : threads_->workers) {
        counts += worker->sink.counts();
        counts.real_collisions += worker->tracer.scatterings();
        counts.bound_violations += worker->tracer.bound_violations();
    }
    return counts;
}

}  // namespace fluovox
