#pragma once

#include "fluovox/volume/region.h"

namespace fluovox {

/// Whether one of two regions lies wholly in the other, or they have at most a surface in common. What it says of
/// finite regions it knows from 2000 points under their surfaces.
bool nested_or_apart(const Region& a, const Region& b);

}  // namespace fluovox
