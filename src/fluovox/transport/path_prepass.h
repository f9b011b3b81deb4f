#pragma once

#include "fluovox/scene/scene.h"
#include "fluovox/transport/grid_tracking.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/light_shadows.h"
#include "fluovox/transport/weight_window.h"

#include <cstddef>
#include <cstdint>
#include <map>

namespace fluovox {

struct LinePlan;

/// What is found out about a scene before many paths are followed through it, to spend less time on them: it changes no
/// expectation. Any number of threads may read it.
class PathPrepass {
public:
    /// Nothing.
    PathPrepass() = default;
    /// `paths`: as many will be followed from the scene's camera. The scene must outlive this.
    PathPrepass(const Scene& scene, const Illumination& illumination, std::int64_t paths);

    /// Adds what there is for a line of the illumination to its plan.
    void add_to(LinePlan& plan, std::size_t line) const;

    std::size_t memory_bytes() const { return shadows_.memory_bytes(); }
    /// What its own paths met.
    const TrackingCounts& counts() const { return counts_; }

private:
    LightShadows shadows_;
    std::map<std::size_t, WeightWindow> windows_;
    TrackingCounts counts_;
};

}  // namespace fluovox
