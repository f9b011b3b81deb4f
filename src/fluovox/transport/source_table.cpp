#include "fluovox/transport/source_table.h"

#include "fluovox/volume/majorant_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

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
    const double depth = fall * length;
    if (depth == 0) return length;
    return depth < 1e-4 ? length * (1 - 0.5 * depth) : (1 - std::exp(-depth)) / fall;
}

// About exp(-depth) for the short steps between pieces, always positive. A density need not be more exact.
double about_exp_minus(double depth) {
    return 1 / (1 + depth * (1 + depth * (0.5 + depth / 6)));
}

}  // namespace

void SourceTable::add(Piece piece) {
    if (!(piece.weight > 0)) return;
    total_ += piece.weight;
    piece.cumulative = total_;
    pieces_.push_back(piece);
}

void SourceTable::add_constant(Interval span, double strength, const std::vector<MediumSpan>& spans,
                               const PathOptics& optics) {
    Piece piece;
    piece.span = span;
    const double depth = hero_depth(spans, optics, span.begin);
    if (std::isfinite(span.end)) {
        piece.fall = (hero_depth(spans, optics, span.end) - depth) / span.length();
    } else {  // any positive number makes a density
        piece.fall = std::max(constant_extinction(spans, optics, span.begin + 1), 1e-4);
    }
    // Beyond some 30 mean free paths nothing is seen, but the density must stay positive.
    piece.weight = strength * std::exp(-std::min(depth, 30.0)) * exponential_integral(piece.fall, span.length());
    add(piece);
}

// The pieces of a grid are many and small: the light's fall from each to the next is taken in steps.
void SourceTable::add_grid(const SparseGrid& grid, double per_uM, const Ray& ray, const std::vector<MediumSpan>& spans,
                           const PathOptics& optics) {
    constexpr double kThin = 0.5;  // a piece on which the density may be flat
    constexpr double kDim = 1e-13;
    MajorantWalk walk(grid, ray, {0, kFar});
    MajorantWalk::Segment segment;
    double depth = 0;
    double light = 1;
    while (walk.next(segment)) {
        const Interval span{segment.begin, segment.end};
        const double end_depth = std::isfinite(span.end) ? hero_depth(spans, optics, span.end) : kFar;
        const double begin_depth = hero_depth(spans, optics, span.begin);
        if (!(end_depth - begin_depth < kThin)) {
            add_constant(span, per_uM * segment.bound, spans, optics);
            continue;
        }
        light = std::max(kDim, light * about_exp_minus(0.5 * (begin_depth + end_depth) - depth));
        depth = 0.5 * (begin_depth + end_depth);
        add({span, 0, per_uM * segment.bound * light * span.length(), 0});
    }
}

void SourceTable::build(const OpticalField& field, const std::vector<double>& brightness, const Ray& ray,
                        const std::vector<MediumSpan>& spans, const PathOptics& optics) {
    pieces_.clear();
    total_ = 0;
    const Scene& scene = field.scene();
    for (const MediumSpan& s : spans) {
        const SceneMedium& medium = scene.media[static_cast<std::size_t>(s.medium)];
        if (medium.dye < 0) continue;
        add_constant(s.span, medium.amount * brightness[static_cast<std::size_t>(medium.dye)], spans, optics);
    }
    for (const SceneMedium& medium : scene.media) {
        if (medium.dye < 0 || !medium.grid) continue;
        const double per_uM = medium.amount * brightness[static_cast<std::size_t>(medium.dye)];
        if (per_uM <= 0) continue;
        add_grid(*medium.grid, per_uM, ray, spans, optics);
    }
}

double SourceTable::sample(double u) const {
    const double target = u * total_;
    auto piece = std::upper_bound(pieces_.begin(), pieces_.end(), target,
                                  [](double value, const Piece& p) { return value < p.cumulative; });
    if (piece == pieces_.end()) --piece;
    const double share = std::clamp(1 - (piece->cumulative - target) / piece->weight, 0.0, 1.0);
    const double length = piece->span.length();
    const double x =
        piece->fall == 0 ? share * length : -std::log1p(share * std::expm1(-piece->fall * length)) / piece->fall;
    return std::isfinite(x) ? std::min(piece->span.begin + x, piece->span.end) : piece->span.begin;
}

double SourceTable::pdf(double t_um) const {
    double density = 0;
    for (const Piece& piece : pieces_) {
        if (t_um < piece.span.begin || t_um > piece.span.end) continue;
        const double fallen = piece.fall == 0 ? 1 : std::exp(-piece.fall * (t_um - piece.span.begin));
        density += piece.weight * fallen / exponential_integral(piece.fall, piece.span.length());
    }
    return density / total_;
}

}  // namespace fluovox
