#pragma once

#include "fluovox/core/csv.h"
#include "fluovox/medium/dye.h"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// Reads the table of curves that a dye's `spectra` key names, empty cells as 0.
using LoadCurves = std::function<CsvTable(const std::string& name)>;

/// One dye from the text of a dye file, which messages call `file`. Its id is left empty.
/// Throws SceneError with the place in `file` or in the table of curves.
Dye parse_dye(std::string_view toml, const std::string& file, const LoadCurves& load_curves);

/// The dyes of a library: a TOML text with one table a dye, named by its id, in the order of the text.
std::vector<Dye> parse_dye_library(std::string_view toml, const std::string& file, const LoadCurves& load_curves);

}  // namespace fluovox
