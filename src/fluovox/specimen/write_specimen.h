#pragma once

#include "fluovox/specimen/specimen.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {

class Progress;

/// What of a specimen may be asked for.
struct DemoSettings {
    std::optional<std::uint64_t> seed;    ///< nothing: the specimen's own
    std::optional<double> voxel_size_um;  ///< > 0; nothing: the specimen's own
};

/// Makes a specimen and writes it into `folder` (made where missing): meshes (.obj, um) and morphology (.swc) where it
/// has them, the grid of concentrations NAME.vdb, and scene.toml. Gives the files in that order.
/// Throws UsageError for an unknown name, OutputError when something cannot be written.
std::vector<std::filesystem::path> write_specimen(const std::string& name, const std::filesystem::path& folder,
                                                  const DemoSettings& settings, Progress& progress);

}  // namespace fluovox
