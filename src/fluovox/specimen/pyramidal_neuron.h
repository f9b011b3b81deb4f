#pragma once

#include "fluovox/specimen/morphology.h"

#include <cstdint>

namespace fluovox {

/// A pyramidal neuron of upper cortex, grown at random from `seed` (the same seed, the same cell): soma at the
/// origin, apical dendrite with obliques and tuft along +y, basal dendrites, spines, and an axon with collaterals and
/// boutons along -y. Some 350 um tall and 250 um wide, flattened to about 80 um along z as in a slice.
///
/// Sizes follow what is commonly reported of layer 2/3 pyramidal cells (soma 15 um, trunk 4 um, distal dendrites and
/// axon under 1 um across); spines are sparser and their necks thicker than life, so that a surface of 0.4 um
/// resolution keeps them. It is a specimen for optics, not a model of any one cell.
Morphology grow_pyramidal_neuron(std::uint64_t seed);

}  // namespace fluovox
