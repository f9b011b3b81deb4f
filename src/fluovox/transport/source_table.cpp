#include "fluovox/transport/source_table.h"

#include "fluovox/volume/majorant_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

double constant_depth(const std::vector<MediumSpan>& spans, const PathOptics& optics, double end_um) {
    double depth = 0;
    for (const MediumSpan& s : spans) {
        const double inside = std::max(0.0, std::min(s.span.end, end_um) - s.span.begin);
        if (inside > 0) depth += inside * optics.media[static_cast<std::size_t>(s.medium)].extinction[0];
    }
    return depth;
}

double constant_extinction(const std::vector<MediumSpan>& spans, const PathOptics& optics, double t_um) {
    double total = 0;
    for (const MediumSpan& s : spans) {
        if (t_um < s.span.begin || t_um > s.span.end) continue;
        total += optics.media[static_cast<std::size_t>(s.medium)].extinction[0];
    }
    return total;
}

// Integral of exp(-fall x) from 0 to length.
double exponential_integral(double fall, double length) {
    if (fall * length < 1e-9) return length;
    return -std::expm1(-fall * length) / fall;
}

}  // namespace

void SourceTable::add(Interval span, double strength, const std::vector<MediumSpan>& spans, const PathOptics& optics) {
    Piece piece;
    piece.span = span;
    const double depth = constant_depth(spans, optics, span.begin);
    if (std::isfinite(span.end)) {
        piece.fall = (constant_depth(spans, optics, span.end) - depth) / span.length();
    } else {  // any positive number makes a density
        piece.fall = std::max(constant_extinction(spans, optics, span.begin + 1), 1e-4);
    }
    // Beyond some 30 mean free paths nothing is seen, but the density must stay positive.
    piece.weight = strength * std::exp(-std::min(depth, 30.0)) * exponential_integral(piece.fall, span.length());
    if (!(piece.weight > 0)) return;
    total_ += piece.weight;
    piece.cumulative = total_;
    pieces_.push_back(piece);
}

void SourceTable::build(const OpticalField& field, const std::vector<double>& brightness, const Ray& ray,
                        const std::vector<MediumSpan>& spans, const PathOptics& optics) {
    pieces_.clear();
    total_ = 0;
    const Scene& scene = field.scene();
    for (const MediumSpan& s : spans) {
        const SceneMedium& medium = scene.media[static_cast<std::size_t>(s.medium)];
        if (medium.dye < 0) continue;
        add(s.span, medium.amount * brightness[static_cast<std::size_t>(medium.dye)], spans, optics);
    }
    for (const SceneMedium& medium : scene.media) {
        if (medium.dye < 0 || !medium.grid) continue;
        const double per_uM = medium.amount * brightness[static_cast<std::size_t>(medium.dye)];
        if (per_uM <= 0) continue;
        MajorantWalk walk(*medium.grid, ray, {0, kFar});
        MajorantWalk::Segment segment;
        while (walk.next(segment)) {
            add({segment.begin, segment.end}, per_uM * segment.bound, spans, optics);
        }
    }
}

double SourceTable::sample(double u) const {
    const double target = u * total_;
    auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), target,
                                  [](double value, const Piece& p) { return value < p.cumulative; });
    if (piece == pieces_.end()) --piece;
    const double share = std::clamp(1 - (piece->cumulative - target) / piece->weight, 0.0, 1.0);
    const double length = piece->span.length();
    const double x = piece->fall * length < 1e-9 ? share * length
                                                 : -std::log1p(share * std::expm1(-piece->fall * length)) / piece->fall;
    return std::isfinite(x) ? std::min(piece->span.begin + x, piece->span.end) : piece->span.begin;
}

double SourceTable::pdf(double t_um) const {
    double density = 0;
    for (const Piece& piece : pieces_) {
        if (t_um < piece.span.begin || t_um > piece.span.end) continue;
        const double x = t_um - piece.span.begin;
        density += piece.weight * std::exp(-piece.fall * x) / exponential_integral(piece.fall, piece.span.length());
    }
    return density / total_;
}

}  // namespace fluovox
