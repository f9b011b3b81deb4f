#pragma once

#include "fluovox/voxelize/specimen.h"

#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// One line of a circuit: a cell with its place and label.
struct CircuitCell {
    SpecimenPart part;
    std::string dye;            ///< as written; empty: not said
    std::string concentration;  ///< with its unit, as written
    int line = 0;
};

/// Reads a table of cells (CSV). The first line names its columns: `file` (relative to the table's folder), and of
/// `x`, `y`, `z` (um), `rx`, `ry`, `rz` (degrees; turned about x first, then y, then z), `scale`, `dye`,
/// `concentration` (with unit) and `label` (a whole number above zero) any that are wanted. Lines that begin with # are
/// passed over. Throws InputError with the line.
std::vector<CircuitCell> load_circuit(const std::filesystem::path& file, double um_per_unit);

}  // namespace fluovox
