#pragma once

#include "fluovox/spectral/spectrum.h"

#include <string>
#include <vector>

namespace fluovox {

/// One value per pixel: the spectral radiance weighted by `response` and integrated over wavelength.
/// A bin of a spectrometer has the response 1 / width inside and zero outside, so it reads radiance per nm.
struct FilmChannel {
    std::string name;      ///< "green", or "550,000nm" for a bin
    double center_nm = 0;  ///< of a bin or band; the response's mean wavelength otherwise
    Spectrum response;
    bool counts_photons = false;  ///< it has an efficiency, so its value counts photons, not watts
};

enum class FilmUnit { Watts, Photons };

/// What each pixel of the film measures.
struct FilmSpec {
    bool is_spectral = true;        ///< the channels are neighbouring bins of equal width
    double from_nm = 0, to_nm = 0;  ///< of the spectrometer
    std::vector<FilmChannel> channels;
    FilmUnit unit = FilmUnit::Watts;
    bool per_dye = false;  ///< one more layer for each dye
};

}  // namespace fluovox
