#pragma once

#include "fluovox/voxelize/segmentation.h"
#include "fluovox/voxelize/specimen.h"

#include "command.h"

#include <optional>
#include <string>
#include <vector>

namespace fluovox::tools {

/// What `fluovox voxelize` was asked to do.
struct VoxelizeRequest {
    std::vector<SpecimenGroup> groups;
    SpecimenSettings settings;
    std::string output;
    std::optional<Segmentation> segmentation;  ///< instead of meshes
    std::string levelset;                      ///< a VDB file to convert instead of meshes; its groups have no parts
    std::string levelset_grid;                 ///< empty: the only one
    double um_per_unit = 0;                    ///< of the meshes; 0: not said
    std::string report;                        ///< JSON file; empty: none
    std::vector<std::string> remarks;          ///< "GFP" stands for EGFP, an absurd concentration ...
};

CommandLine voxelize_command_line();

/// Fills `request` from the command line; false when only the help was wanted. Throws UsageError, InputError (folders
/// that don't exist) and, for dyes, what resolve_dye throws.
bool parse_voxelize(CommandLine& line, const std::vector<std::string>& arguments, VoxelizeRequest& request);

}  // namespace fluovox::tools
