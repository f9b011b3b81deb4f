#pragma once

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/energy_budget.h"
#include "fluovox/volume/brick_field.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace fluovox {

/// How many photons to send, and what to keep of them.
struct FluenceSettings {
    std::int64_t photons = 1000000;  ///< with `relative_error`: at most
    /// Stop as soon as everything absorbed or escaped that makes at least 1 % of its class is known this well.
    std::optional<double> relative_error;
    std::uint64_t seed = 1;
    int angle_bins = 0;              ///< escaped light by angle, in so many even bins from 0 to 90 degrees
    bool grids = false;              ///< fluence and absorbed power in voxels
    std::optional<double> voxel_um;  ///< cubes of this size; otherwise the voxels of the dyes that have grids
    double max_bytes = 4e9;          ///< of the grids
    double majorant_factor = 1;      ///< makes the bounds of grids too high, which must change nothing
};

struct FluenceResult {
    std::int64_t photons = 0;
    EnergyBudget share;     ///< of the photons launched
    EnergyBudget watts;     ///< for the power of the scene
    Estimate met_a_medium;  ///< share of the photons launched that came into a region or the box of a grid
    Estimate mean_path_um;  ///< in media (regions, boxes of grids), of photons that met one, before conversion
    /// Fluence and absorbed power. Without `voxel_um` on the voxels of the dyes' grids: where these differ each dye's
    /// absorbed power is on its own, and fluence on those of the second, third ... is named after the medium.
    std::vector<BrickField> grids;
    std::int64_t bound_violations = 0;
    std::int64_t scatterings = 0;
    bool precise = true;   ///< false where `relative_error` was asked for and not reached
    bool stopped = false;  ///< by the user, before all was done
};

/// Follows photons from the lights of a scene. The same scene, settings and seed give the same numbers for any number
/// of threads. Throws SceneError where the scene has no light, or none that could come to an end; InputError when the
/// grids would take more than `max_bytes`.
FluenceResult trace_fluence(const Scene& scene, const FluenceSettings& settings, Progress& progress);

}  // namespace fluovox
