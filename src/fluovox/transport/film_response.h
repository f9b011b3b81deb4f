#pragma once

#include "fluovox/image/film_spec.h"
#include "fluovox/scene/scene_description.h"
#include "fluovox/spectral/lanes.h"
#include "fluovox/spectral/spectrum.h"

#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace fluovox {

/// What a film makes of light: its channels behind the filter of the scene, and the unit they count in.
class FilmResponse {
public:
    FilmResponse(const FilmSpec& spec, const std::optional<FilterDescription>& filter);

    /// Wavelengths spread evenly over all that the film sees; `u` uniform in [0, 1) turns them together.
    Wavelengths sample(double u) const;
    /// The first of them alone.
    Wavelengths sample_one(double u) const;

    /// True when light of this wavelength reaches some channel.
    bool sees(double wavelength_nm) const;
    /// The same of any line or tabulated wavelength of a light.
    bool sees(const LightSpectrum& light) const;

    /// A table that is positive wherever light of this spectrum reaches some channel: to draw from.
    Spectrum seen_part(const Spectrum& spectrum) const;

    /// Adds light of one wavelength to the values of all channels. `photons`: photon radiance, s^-1 um^-2 sr^-1, of a
    /// line, or the radiance per nm over the density that the wavelength was drawn with.
    void add(double wavelength_nm, double photons, std::span<double> values) const;
    /// Adds an estimate by the wavelengths of a path, of `per_nm` photons s^-1 um^-2 sr^-1 nm^-1 at each.
    void add(const Wavelengths& wavelengths, const Lanes& per_nm, std::span<double> values) const;

private:
    Wavelengths comb(double u, int count) const;
    bool passes(double wavelength_nm) const;

    const FilmSpec* spec_;
    std::optional<FilterDescription> filter_;
    std::vector<std::pair<double, double>> ranges_;  // where some channel responds, nm
    double total_nm_ = 0;                            // all of them
    Spectrum where_;                                 // one there
    int lanes_;
};

}  // namespace fluovox
