#pragma once

// Internal: what the attributes of our EXR files are called. Not installed.

#include "fluovox/image/film_spec.h"

#include <string>
#include <vector>

namespace fluovox::exr {

inline constexpr const char* kVersion = "fluovox:version";
inline constexpr const char* kScene = "fluovox:scene";
inline constexpr const char* kSeed = "fluovox:seed";
inline constexpr const char* kSamples = "fluovox:samples";
inline constexpr const char* kEstimator = "fluovox:estimator";
inline constexpr const char* kDyes = "fluovox:dyes";
inline constexpr const char* kFilm = "fluovox:film";
inline constexpr const char* kCount = "fluovox:count";
inline constexpr const char* kVarianceUnit = "fluovox:varianceUnit";
inline constexpr const char* kRegionVariances = "fluovox:regionVariances";
inline constexpr const char* kNanCount = "fluovox:nanCount";
inline constexpr const char* kBoundViolations = "fluovox:boundViolations";
inline constexpr const char* kRadianceUnits = "fluovox:radianceUnits";
inline constexpr const char* kStack = "fluovox:stack";
inline constexpr const char* kPreview = "fluovox:preview";

/// Stands for all channels of a layer added up; with a dot, so that no channel is called so.
inline constexpr const char* kAllChannels = "all.channels";
inline constexpr const char* kCountChannel = "samples.count";

/// A film's description and layers as one line of JSON.
std::string film_to_json(const FilmSpec& spec, const std::vector<std::string>& layers);

struct FilmAndLayers {
    FilmSpec spec;
    std::vector<std::string> layers;
};
/// Throws std::exception for anything that `film_to_json` would not have written.
FilmAndLayers film_from_json(const std::string& text);

std::string names_to_json(const std::vector<std::string>& names);
std::vector<std::string> names_from_json(const std::string& text);

}  // namespace fluovox::exr
