#pragma once

#include "fluovox/voxelize/mesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace fluovox {

/// A specimen that fluovox makes by itself, with the scene that shows it.
struct SpecimenInfo {
    std::string name;          ///< "neuron"
    std::string summary;       ///< one line
    double voxel_size_um = 0;  ///< of its grid unless asked otherwise; 0: it has no grid
    std::uint64_t seed = 0;    ///< unless asked otherwise; 0: nothing about it is random
    bool is_stack = false;     ///< its scene makes a z-stack, and its file has a grid of labels
};

/// All of them.
const std::vector<SpecimenInfo>& specimens();

/// One of them; throws UsageError with their names when there is none of that name.
const SpecimenInfo& find_specimen(const std::string& name);

/// A body full of one dye.
struct LabelledBody {
    std::string file;  ///< of its mesh, "neuron.obj"
    std::string dye;   ///< "EGFP"
    double concentration_uM = 0;
    Mesh mesh;
    std::string comment;
};

/// A specimen before anything of it is on disk.
struct Specimen {
    std::vector<LabelledBody> bodies;
    std::string swc;         ///< morphology as text; empty where there is none
    std::string scene_toml;  ///< reads the grid NAME.vdb
};

/// `name` is one of `specimens()`; throws UsageError otherwise.
Specimen make_specimen(const std::string& name, std::uint64_t seed);

}  // namespace fluovox
