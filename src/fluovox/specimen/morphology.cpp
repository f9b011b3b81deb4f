#include "fluovox/specimen/morphology.h"

#include <fmt/format.h>

#include <iterator>
#include <sstream>

namespace fluovox {

double Morphology::length_um(CellPart part) const {
    double sum = 0;
    for (const MorphologyPoint& point : points) {
        if (point.part != part || point.parent < 0) continue;
        const MorphologyPoint& parent = points[static_cast<std::size_t>(point.parent)];
        const bool from_soma = parent.part == CellPart::Soma && part != CellPart::Soma;
        if (!from_soma) sum += length(point.position - parent.position);
    }
    return sum;
}

std::string to_swc(const Morphology& morphology, const std::string& comment) {
    std::string text;
    std::istringstream lines(comment);
    for (std::string line; std::getline(lines, line);)
        text += line.empty() ? "#\n" : "# " + line + '\n';
    int id = 0;
    for (const MorphologyPoint& point : morphology.points) {
        fmt::format_to(std::back_inserter(text), "{} {} {:.4f} {:.4f} {:.4f} {:.4f} {}\n", ++id,
                       static_cast<int>(point.part), point.position.x, point.position.y, point.position.z,
                       point.radius_um, point.parent < 0 ? -1 : point.parent + 1);
    }
    return text;
}

}  // namespace fluovox
