#pragma once

#include "fluovox/image/film.h"
#include "fluovox/scene/scene.h"

#include <cstdint>
#include <string>
#include <vector>

namespace fluovox::validation {

/// `samples` per pixel of a scene.
Film picture(Scene scene, const std::string& estimator, std::int64_t samples, std::uint64_t seed);

/// The scene of a folder in volumes, with keys replaced.
Scene specimen(const std::string& name, const std::vector<std::string>& overrides);

}  // namespace fluovox::validation
