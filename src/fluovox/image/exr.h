#pragma once

#include "fluovox/image/film.h"
#include "fluovox/image/film_spec.h"
#include "fluovox/image/rendered_image.h"

#include <filesystem>
#include <string>

namespace fluovox {

/// Writes an image as one OpenEXR part of float channels, zip-compressed; the same film gives the same bytes.
///
/// A spectrometer's image follows the spectral layout of Fichet, Pacanowski and Wilkie, "An OpenEXR Layout for Spectral
/// Images", JCGT 10(3), 2021: exactly one set of `S0` channels, which is all light. What else we know stands beside it
/// under names that foreign readers pass over:
///
///     S0.550,000nm                          spectral radiance of all light, bin centred at 550 nm
///     elastic.550,000nm                     of it, light at the wavelength it left its source with
///     fluorescence.550,000nm                of it, light that a dye converted; these two only where there is a dye
///     dye.EGFP.550,000nm                    of it, light whose last conversion was in EGFP (film.per_dye)
///     variance.550,000nm                    variance of the mean of S0; times fluovox:varianceUnit squared
///     variance.fluorescence.550,000nm ...   and of every other layer
///     variance.all.channels ...             variance of all channels of a layer added up
///     R, G, B                               preview, linear sRGB, exposed so that bright parts are near 1
///     samples.count                         samples of each pixel, only where they differ
///
/// Photon images have `photons.550,000nm` instead of `S0.550,000nm`. Films of detector channels have `green`,
/// `elastic.green` ...; a dot in a name becomes an underscore; with a channel named R, G or B there is no preview.
///
/// Attributes: spectralLayoutVersion "1.0" and emissiveUnits "W.m^-2.sr^-1" (the only text the layout allows; the
/// values are per nm, as fluovox:radianceUnits says), and as text fluovox:version, :scene (JSON), :seed, :samples,
/// :estimator, :dyes, :film (JSON), :count (samples of every pixel; the smallest where they differ), :varianceUnit,
/// :nanCount, :boundViolations, :preview (the exposure of R, G, B), and of a stack's plane :stack (JSON).
///
/// Throws OutputError; an existing file survives a failure.
void save_exr(const std::filesystem::path& path, const Film& film, const FilmSpec& spec, const Provenance& provenance);

/// Reads an image that `save_exr` wrote. Throws InputError for a missing, truncated or damaged file, and for an EXR
/// image of another program.
RenderedImage load_exr(const std::filesystem::path& path);

/// The name of a channel in the file: of a layer's mean, or of its variance.
std::string exr_channel_name(const FilmSpec& spec, const std::string& layer, const std::string& channel, bool variance);

}  // namespace fluovox
