#pragma once

#include "fluovox/image/film.h"
#include "fluovox/image/plane_store.h"
#include "fluovox/image/stack_info.h"
#include "fluovox/scene/scene.h"

#include <span>
#include <string>
#include <vector>

namespace fluovox {

/// One view of the scene's stack as its file describes it: sizes, places of the planes, and for each channel of the
/// film the dye that is mostly seen in it and the laser line that excites that dye. `key` and `max_value` are left out.
StackInfo describe_stack(const Scene& scene, int view);

/// What is wrong with a stack before it is rendered, a sentence each: sheets that miss a dye's specimen in every plane
/// (with the distance), detector channels that no dye and no light shines into.
std::vector<std::string> doubts_about_stack(const Scene& scene);

/// One layer of a film as the values of a plane: channel by channel, row 0 on top. Its figures go into `figures`
/// (all but the seconds).
std::vector<float> plane_values(const Film& film, int layer, PlaneFigures& figures);

}  // namespace fluovox
