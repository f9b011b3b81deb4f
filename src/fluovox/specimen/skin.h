#pragma once

#include "fluovox/specimen/morphology.h"
#include "fluovox/specimen/round_cone.h"
#include "fluovox/voxelize/mesh.h"

#include <vector>

namespace fluovox {

/// The pieces a cell's body is made of: one for each stretch between two points, and a cone where a cable leaves
/// the soma.
std::vector<RoundCone> body_of(const Morphology& morphology);

/// The closed surface of the smooth union of `pieces`, in triangles of about `resolution_um`: each edge borders exactly
/// two triangles, which face outwards. The same pieces give the same surface for any number of threads.
/// Details thinner than `resolution_um` may be lost. Throws InputError when `resolution_um` is not positive.
Mesh make_skin(const std::vector<RoundCone>& pieces, double resolution_um);

}  // namespace fluovox
