#pragma once

// Values as the options of `fluovox voxelize` have them. What is wrong with one is a UsageError that names its option.

#include "fluovox/core/bounds.h"
#include "fluovox/core/quantity.h"

#include "command.h"

#include <string>
#include <vector>

namespace fluovox::tools {

double quantity(const CommandLine& line, const std::string& option, const std::string& text, Dimension dimension);

/// In micrometres, above zero.
double positive_length(const CommandLine& line, const std::string& option, const std::string& text);

std::vector<std::string> split(const std::string& text, char separator);

/// "nm", "um", "8nm": micrometres per unit of the mesh.
double mesh_unit(const CommandLine& line, const std::string& text);

/// "0um,0um,0um,10um,20um,5um": two corners.
Bounds box(const CommandLine& line, const std::string& option, const std::string& text);

struct DyeChoice {
    std::string name;
    double concentration_uM = 0;
};

/// `option` is the whole of one like "--dye EGFP=5uM", `name` and `concentration` its parts.
DyeChoice choose_dye(const CommandLine& line, const std::string& option, const std::string& name,
                     const std::string& concentration, std::vector<std::string>& remarks);

/// "EGFP=5uM" of `--dye`.
DyeChoice parse_dye(const CommandLine& line, const std::string& text, std::vector<std::string>& remarks);

}  // namespace fluovox::tools
