#pragma once

#include "fluovox/image/stack_info.h"
#include "fluovox/scene/scene.h"
#include "fluovox/volume/label_field.h"

#include <optional>
#include <string>
#include <vector>

namespace fluovox {

/// What a stack of a scene should show, without optics and noise, on the very pixels of the stack: for training and for
/// judging what programs make of an image. A voxel is a pixel as deep as a step of the stack.
class GroundTruth {
public:
    /// Opens the grids of labels beside the dyes' grids. Throws InputError.
    GroundTruth(const Scene& scene, int view);

    /// One channel: which object the middle of a voxel is in, 0 for none. Where the file of a dye's grid has a grid
    /// "labels" its numbers hold; otherwise each dye medium is one object, numbered in the order of the scene from 1,
    /// and reaches to half of its grid's largest value.
    static StackInfo labels_info(const StackInfo& stack);
    void labels(int plane, std::span<float> values) const;

    /// One channel for each dye: its mean concentration in a voxel, umol/L.
    StackInfo concentration_info(const StackInfo& stack) const;
    void concentration(int plane, int dye, std::span<float> values) const;

    /// One channel for each [[light]] that has a place (of a two-sided or pivoted sheet, all parts together): the
    /// fluence rate of its light that was not scattered, in W/mm2, at the middle of each pixel; absorbed and scattered
    /// on the way as the media do, along straight lines.
    StackInfo irradiance_info(const StackInfo& stack) const;
    void irradiance(int plane, int channel, std::span<float> values) const;

private:
    struct Lattice;

    Lattice lattice(int plane) const;
    int label_at(Vec3 position_um) const;
    double concentration_at(int dye, Vec3 position_um) const;

    const Scene* scene_;
    int view_;
    std::vector<std::optional<LabelField>> label_fields_;  // per medium
    std::vector<int> lit_by_;                              // tables of lights with an irradiance
    int fineness_ = 2;                                     // samples of a voxel along each axis
};

}  // namespace fluovox
