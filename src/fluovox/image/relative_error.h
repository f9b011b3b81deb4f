#pragma once

#include "fluovox/image/film.h"

#include <optional>
#include <string>

namespace fluovox {

/// Medians of the relative standard error of brightness, the mean over the channels of one layer. Nothing where it is
/// not known: no light, or pixels of one sample, whose spread says nothing.
struct RelativeErrors {
    std::optional<double> all;        ///< over the pixels that have light
    std::optional<double> brightest;  ///< over the brightest tenth
};

/// What the brightest tenth is a tenth of.
enum class BrightestOf { AllPixels, LitPixels };

RelativeErrors relative_errors(const Film& film, int layer, BrightestOf tenth_of);

/// For people: `2.31 %`, or why there is none: `unknown (one sample per pixel)`, `unknown (no light)`.
std::string relative_error_text(std::optional<double> error, bool has_light);

}  // namespace fluovox
