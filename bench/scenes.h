#pragma once

#include "fluovox/volume/brick_field.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace fluovox::bench {

/// Branching tubes like neurites in a box of voxels of one micrometre. They are the same for any `scale`: that only
/// says how many voxels make one unit of the other lengths.
struct Tubes {
    Voxel size{256, 256, 256};  ///< of the box, in units
    double share = 0.047;       ///< of the box that they fill, about
    double radius = 2;          ///< of the thickest, in units; the thinnest have half of it
    int scale = 1;              ///< voxels along a unit
    std::uint64_t seed = 1;
};

/// A field with what a scene needs to know of it.
struct BenchField {
    BrickField bricks;
    Voxel size;                    ///< of the whole box, in voxels
    std::int64_t active = 0;       ///< voxels above zero
    double mean = 0;               ///< over the whole box
    double through_middle_um = 0;  ///< integral along z through the middle, mean over its ninth part
};

/// Values rise from 0 to 1 over one voxel at the surface of the tubes. Only bricks that hold something take memory.
BenchField make_tubes(const Tubes& tubes);

/// A billowing cloud in a cube of `resolution` voxels of one micrometre: values between 0 and 1.
BenchField make_cloud(int resolution);

/// Writes NAME.vdb and NAME.toml: elastic scattering (albedo 0.99, isotropic) with the given coefficient per unit of
/// density, distant light from the side, an orthographic camera along z on all of the box, one wavelength, so many
/// samples a pixel.
void write_elastic_scene(const std::filesystem::path& folder, const std::string& name, const BenchField& field,
                         double extinction_per_um, int samples);

}  // namespace fluovox::bench
