#pragma once

#include "fluovox/volume/region.h"

namespace fluovox {

/// How two regions lie to each other; `Apart` also where they have a surface in common.
enum class Nesting { Apart, FirstInSecond, SecondInFirst, Equal, Partial };

/// What it says of finite regions it knows from 2000 points under their surfaces.
Nesting nesting_of(const Region& a, const Region& b);

/// Of regions with different refractive indices one must be inside the other, or both apart. Otherwise what they do, to
/// be said after their names: "overlap in part" or "fill the same space"; nothing where all is well.
const char* index_conflict(const Region& a, const Region& b);

}  // namespace fluovox
