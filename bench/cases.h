#pragma once

#include "table.h"

#include <filesystem>

namespace fluovox::bench {

/// Writes the scenes of fine structures.
void write_scenes(const std::filesystem::path& folder);
/// Writes the scene of the cuvette that report_fluorescence renders.
void write_cuvette(const std::filesystem::path& folder);

/// Elastic light in fine structures: collisions, paths per second, against plain tracking, growth, memory.
void report_elastic(const std::filesystem::path& folder, Table& table);

/// Photons from the lights in a plain cube.
void report_photons(const std::filesystem::path& folder, Table& table);

/// A slice of a light-sheet image, and what carrying many wavelengths along is worth. `neuron`: folder of the specimen.
void report_fluorescence(const std::filesystem::path& folder, const std::filesystem::path& neuron, Table& table);

/// What the estimators are worth on one plane of a light-sheet stack.
void report_sheet(const std::filesystem::path& folder, Table& table);

/// The project's own neuron: voxels, set-up, images.
void report_neuron(const std::filesystem::path& folder, Table& table);

}  // namespace fluovox::bench
