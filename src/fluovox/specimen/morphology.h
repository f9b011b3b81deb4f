#pragma once

#include "fluovox/core/vec.h"

#include <string>
#include <vector>

namespace fluovox {

/// What a point of a morphology belongs to; the numbers are SWC's, 5 is free for own use there.
enum class CellPart { Soma = 1, Axon = 2, BasalDendrite = 3, ApicalDendrite = 4, Spine = 5 };

/// One point of a cable: where it is, how thick, and the point it grew from.
struct MorphologyPoint {
    CellPart part = CellPart::Soma;
    Vec3 position;         ///< um
    double radius_um = 0;  ///< > 0
    int parent = -1;       ///< index of an earlier point; -1 for the root
};

/// A cell as a tree of tapered cables; parents come before their children.
struct Morphology {
    std::vector<MorphologyPoint> points;

    /// Length of all cables of one part, um; a cable's way from inside the soma to its first point counts as soma.
    double length_um(CellPart part) const;
};

/// `morphology` as the text of an SWC file (identifier, type, x, y, z, radius, parent; um), after `comment`,
/// each line of which gets a '#'. SWC: Cannon et al., J. Neurosci. Methods 84 (1998) 49.
std::string to_swc(const Morphology& morphology, const std::string& comment);

}  // namespace fluovox
