#pragma once

#include "fluovox/image/film_spec.h"
#include "fluovox/image/png.h"
#include "fluovox/image/stack_info.h"

#include <string>
#include <vector>

namespace fluovox {

/// A stack for the eye.
struct StackPictures {
    Picture projection;           ///< the brightest value of each pixel along the stack
    std::string exposure;         ///< what full brightness stands for
    std::vector<Picture> frames;  ///< planes, small, exposed like the projection; at most 64 of them, evenly spaced
};

/// Goes through the stack twice, one plane at a time; what it holds does not grow with the number of planes.
/// `film` says what colour the channels have.
StackPictures make_stack_pictures(const StackInfo& info, const FilmSpec& film, const PlaneSource& source);

}  // namespace fluovox
