#pragma once

#include "fluovox/medium/coefficient.h"
#include "fluovox/medium/dye.h"
#include "fluovox/medium/phase_function.h"
#include "fluovox/optics/light.h"
#include "fluovox/scene/scene_description.h"
#include "fluovox/volume/region.h"
#include "fluovox/volume/sparse_grid.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {

/// One medium of the scene, ready for tracking. Its coefficients are those of the dye or host below times `amount`
/// in its region, or times the value of its grid (umol/L of a dye, a plain factor for a host).
struct SceneMedium {
    std::string name;
    std::shared_ptr<const SparseGrid> grid;  ///< empty: constant in `region`
    Region region = Everywhere{};
    double amount = 1;
    int dye = -1;                                    ///< index into Scene::dyes; -1: a host
    Coefficient scattering = 0.0, absorption = 0.0;  ///< hosts, per um
    PhaseFunction phase;                             ///< of a host that scatters
    std::optional<double> refractive_index;          ///< inside its surface; a grid's is its box
    std::vector<int> cut_by;                         ///< media whose regions replace this one (`exclusive`)
};

/// What the renderer reads: built once, const ever after.
struct Scene {
    SceneDescription description;
    std::vector<SceneMedium> media;
    std::vector<Dye> dyes;              ///< each once, in the order of the scene
    std::vector<Light> lights;          ///< a two-sided sheet is two of them
    std::vector<int> light_tables;      ///< for each light, which [[light]] of the scene file it is of, from 0
    std::vector<std::string> warnings;  ///< what looks like a mistake but may be meant
};

/// Opens the grids and gets everything ready. Throws SceneError (what the file asks for cannot be, or is not available)
/// or InputError (a grid).
Scene build_scene(SceneDescription description);

}  // namespace fluovox
