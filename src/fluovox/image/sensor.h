#pragma once

#include "fluovox/image/stack_info.h"
#include "fluovox/spectral/spectrum.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fluovox {

/// A camera's chip in the linear model of EMVA 1288: photons become electrons with the quantum efficiency (Poisson),
/// dark current adds electrons, the well limits them, an electron-multiplying register may multiply them (gamma
/// distributed), read-out adds normal noise, and the gain turns electrons into counts above an offset.
struct Sensor {
    std::string name;
    double quantum_efficiency = 1;  ///< electrons per photon, where `efficiency` is empty
    Spectrum efficiency;            ///< the same over wavelength
    double dark_electrons_per_s = 0;
    double spurious_electrons = 0;  ///< per read-out, before multiplication (clock-induced charge)
    double full_well_electrons = 1e18;
    double em_gain = 1;               ///< 1: no multiplying register
    double read_noise_electrons = 0;  ///< standard deviation, after multiplication
    double counts_per_electron = 1;   ///< EMVA's K
    double offset_counts = 0;
    int bits = 16;

    double efficiency_at(double wavelength_nm) const {
        return efficiency.empty() ? quantum_efficiency : efficiency(wavelength_nm);
    }
};

/// Typical chips: "ideal" (every photon an electron, an electron a count, shot noise only), "scmos", "emccd".
/// Throws InputError for another name.
Sensor sensor_preset(std::string_view name);
std::vector<std::string> sensor_presets();

/// Photons that come to one pixel during `exposure_s`, for each unit of a stack's value in a channel: radiance times
/// pi sin^2(theta) of the aperture, the pixel's area in the specimen, the exposure and, for a spectrometer, the bin's
/// width. Watts are counted at the channel's centre wavelength. 1 for stacks of photons. Throws InputError where that
/// cannot be: other quantities, no aperture.
double photons_per_value(const StackInfo& info, int channel, double exposure_s);

/// One pixel's electrons before multiplication and its count.
struct Exposed {
    double electrons = 0;
    std::uint16_t count = 0;
    bool is_full = false;  ///< the well or the converter is at its end
};

/// What falls on a pixel.
struct Exposure {
    double photons = 0;     ///< expected number
    double efficiency = 1;  ///< with which they are detected: the sensor's at their wavelength; 1: they were already
    double seconds = 0;
};

/// Which pixel of which image: the random numbers follow from it alone.
struct PixelPlace {
    std::uint64_t seed = 0, page = 0, pixel = 0;
};

Exposed expose(const Sensor& sensor, const Exposure& exposure, const PixelPlace& place);

}  // namespace fluovox
