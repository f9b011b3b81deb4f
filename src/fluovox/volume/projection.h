#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// The largest value along each line of sight through a grid, row 0 on top.
struct Projection {
    std::string grid;
    int width = 0;
    int height = 0;
    std::vector<float> values;  ///< width x height
    float largest = 0;
};

/// Maximum projections of every float grid of a file that has anything in it, all of one size and along the same axis
/// of the voxels: the one in which everything together is shortest. Pictures wider or higher than `most_pixels` are
/// made of larger cells. Throws InputError.
std::vector<Projection> project_grids(const std::filesystem::path& file, int most_pixels);

}  // namespace fluovox
