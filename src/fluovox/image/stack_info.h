#pragma once

#include "fluovox/core/vec.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fluovox {

enum class SampleType {
    Float32,  ///< the values themselves
    UInt16,   ///< counts: the value is count x value_per_count
};

/// One channel of a stack.
struct StackChannel {
    std::string name;
    std::string dye;               ///< what is mostly seen in it; empty: no dye
    double excitation_nm = 0;      ///< laser line that excites the dye; 0: none
    double emission_nm = 0;        ///< centre of what the channel sees
    double width_nm = 0;           ///< values are per nm of such a bin; 0: integrated over the channel
    bool counts_photons = false;   ///< photons, not watts
    bool has_efficiency = false;   ///< the detector's efficiency is in the values already
    std::uint32_t rgb = 0xFFFFFF;  ///< colour to show it in, 0xRRGGBB
    /// Of a photon with the mean energy of the light that the dye sends into the channel, by which watts become
    /// photons; 0: not known.
    double photon_nm = 0;

    /// The wavelength that stands for the channel's light.
    double light_nm() const { return photon_nm > 0 ? photon_nm : emission_nm; }
};

/// A z-stack as its readers see it: planes of channels, sizes, and what the values mean.
struct StackInfo {
    std::string title;
    int width = 0, height = 0, planes = 0;
    std::vector<StackChannel> channels;
    double pixel_um = 0;             ///< of the specimen, along x and y
    double step_um = 0;              ///< between planes
    std::vector<Vec3> positions_um;  ///< of the middle of each plane, in the specimen's world
    /// Where the middle of the first pixel of the first plane lies in that world, measured along the stack's own axes:
    /// columns, rows (downwards), planes. Nothing: not known.
    std::optional<Vec3> origin_um;
    double angle_deg = 0;  ///< of the view
    double numerical_aperture = 0;
    double immersion_index = 1;
    double blur_um = 0;     ///< full width of the Gaussian blur that stands for diffraction; 0: none
    double exposure_s = 0;  ///< 0: not said
    std::string quantity;   ///< what a value is: "radiance", "expected photons", "label" ...
    std::string unit;       ///< "W.m^-2.sr^-1", "photons", "umol/L" ...; empty: none
    SampleType type = SampleType::Float32;
    double value_per_count = 1;  ///< UInt16 only
    int significant_bits = 16;   ///< of counts
    double max_value = 0;        ///< largest value, for viewers
    std::string scene_json;      ///< the scene with every default
    std::string key;             ///< the same for the same work

    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
    std::size_t bytes_per_sample() const { return type == SampleType::UInt16 ? 2 : 4; }
    /// Size of all samples, bytes.
    double bytes() const {
        return static_cast<double>(pixels()) * static_cast<double>(channels.size()) * planes *
               static_cast<double>(bytes_per_sample());
    }
};

/// Fills in the values of one plane of one channel: width x height, row 0 on top.
using PlaneSource = std::function<void(int plane, int channel, std::span<float> values)>;

/// As one line of JSON, without `scene_json`, and back. `stack_info_from_json` throws std::exception for anything else.
std::string to_json(const StackInfo& info);
StackInfo stack_info_from_json(const std::string& text);

/// A value as a count: rounded, and within 0 ... 65535.
std::uint16_t to_count(float value, double value_per_count);

}  // namespace fluovox
