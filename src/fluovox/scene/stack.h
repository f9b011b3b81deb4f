#pragma once

#include "fluovox/scene/scene.h"
#include "fluovox/scene/scene_description.h"

namespace fluovox {

/// How many images one view of a stack has: from `start` in whole steps up to `stop`.
int plane_count(const StackDescription& stack);

/// How far plane `plane` (from 0) lies along the stack from where the scene file puts sheet and focus.
double plane_offset_um(const StackDescription& stack, int plane);

/// The scene with camera, sheets and beams where they stand for one image of its stack, and without the stack: an
/// instrument moved as one piece along a specimen (a stage that moves the specimen the other way). Other lights and
/// the media stay. Each image gets a seed of its own, from the scene's; `view` and `plane` count from 0.
Scene scene_at(const Scene& scene, int view, int plane);

}  // namespace fluovox
