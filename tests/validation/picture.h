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

double launched_W(const Scene& scene);

/// Of the light launched, what a telecentric camera with an aperture collects where its pixels have this mean radiance,
/// summed over the bins of the film, in watts.
double share_on_sensor(const Scene& scene, double radiance);

}  // namespace fluovox::validation
