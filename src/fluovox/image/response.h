#pragma once

#include "fluovox/image/rendered_image.h"
#include "fluovox/spectral/spectrum.h"

#include <vector>

namespace fluovox {

/// A rectangle of pixels: columns x0 to x1 and rows y0 to y1, the last of each excluded; row 0 is on top.
struct PixelRegion {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// The mean over a region of one layer, per channel, with its standard error: NaN where pixels of one sample do not
/// tell.
struct SpectralResponse {
    std::vector<double> mean;
    std::vector<double> standard_error;
    /// All channels added up. One path lights many of them, so that this error is not the root of their squares.
    double sum = 0;
    double standard_error_of_sum = 0;
};

/// Throws std::invalid_argument when the region is empty or leaves the image, or there is no such layer.
SpectralResponse mean_response(const RenderedImage& image, int layer, const PixelRegion& region);

/// What each channel of the film reads of light with the photon spectrum `emission_per_nm`, up to a common factor:
/// the integral of response times emission, as energy (divided by the wavelength) where the channel reads watts.
std::vector<double> emission_on_film(const Spectrum& emission_per_nm, const FilmSpec& film);

/// A curve per bin divided by its area, sum of value x `bin_nm`; all zero if the area is not positive.
std::vector<double> normalized(const std::vector<double>& curve, double bin_nm);

/// Distance between the shapes of two curves: sum |a - b| x bin width, of both normalised to unit area over the film's
/// range. 0: equal shapes; 2: they share no wavelength.
double normalized_distance(const std::vector<double>& a, const std::vector<double>& b);

/// How large that distance is on average from the noise of `response` alone (Gaussian, bins independent).
double distance_from_noise(const SpectralResponse& response);

}  // namespace fluovox
