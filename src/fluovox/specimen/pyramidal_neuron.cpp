#include "fluovox/specimen/pyramidal_neuron.h"

#include "fluovox/core/rng.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

constexpr double kStep_um = 3;
constexpr double kThinnest_um = 0.3;  // radius below which no cable tapers
constexpr double kHalfDepth_um = 38;  // cables turn back before they leave this depth
constexpr double kSpinesPerMicrometre = 0.35;
constexpr double kPi = std::numbers::pi;

/// One unbranched cable to grow.
struct Cable {
    CellPart part = CellPart::BasalDendrite;
    int from = 0;    ///< point it starts at
    Vec3 direction;  ///< unit length
    Vec3 toward;     ///< it bends slowly this way
    double length_um = 0;
    double begin_radius_um = 0, end_radius_um = 0;
};

/// Where a cable ended.
struct Tip {
    int point = 0;
    Vec3 direction;
};

class Grower {
public:
    explicit Grower(std::uint64_t seed) : rng_(seed, 0x6e6575726f6e, 0) {}

    Morphology grow();

private:
    double between(double low, double high) { return low + (high - low) * rng_.uniform(); }
    Vec3 random_direction();
    Vec3 turned(Vec3 direction, double angle_rad);

    int add(CellPart part, Vec3 position, double radius_um, int parent);
    const MorphologyPoint& at(int point) const { return cell_.points[static_cast<std::size_t>(point)]; }

    void grow_soma();
    Tip grow_cable(const Cable& cable);
    void grow_tree(Cable stem, int forks, double daughter_length_um);
    void grow_basal_dendrites();
    void grow_apical_dendrite();
    void grow_axon();
    void grow_collateral(int from, double side);
    void grow_spines();
    void add_spine(int point, double share);

    Rng rng_;
    Morphology cell_;
    int soma_base_ = 0, soma_center_ = 0, soma_top_ = 0;
};

Vec3 Grower::random_direction() {
    const double z = between(-1, 1);
    const double phi = between(0, 2 * kPi);
    const double r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// `direction` turned by an angle, mostly within the plane of the slice.
Vec3 Grower::turned(Vec3 direction, double angle_rad) {
    const Vec3 axis = normalized(Vec3{0, 0, 1} + 0.5 * random_direction());
    const Vec3 side = cross(axis, direction);
    return normalized(std::cos(angle_rad) * direction + std::sin(angle_rad) * side);
}

int Grower::add(CellPart part, Vec3 position, double radius_um, int parent) {
    cell_.points.push_back({part, position, radius_um, parent});
    return static_cast<int>(cell_.points.size()) - 1;
}

void Grower::grow_soma() {
    soma_base_ = add(CellPart::Soma, {0, -3.5, 0}, 6.8, -1);
    soma_center_ = add(CellPart::Soma, {0, 0, 0}, 7.6, soma_base_);
    soma_top_ = add(CellPart::Soma, {0, 8.5, 0}, 4.4, soma_center_);
}

Tip Grower::grow_cable(const Cable& cable) {
    constexpr double kWobble = 0.2;    // random turn per step
    constexpr double kBend = 0.05;     // turn towards the aim per step
    constexpr double kFlatten = 0.12;  // turn back towards the middle of the slice
    Tip tip{cable.from, cable.direction};
    Vec3 position = at(cable.from).position;
    if (at(cable.from).part == CellPart::Soma) position = position + (at(cable.from).radius_um + 1) * cable.direction;
    const int steps = std::max(2, static_cast<int>(std::lround(cable.length_um / kStep_um)));
    for (int i = 1; i <= steps; ++i) {
        const double share = static_cast<double>(i) / steps;
        const Vec3 back = {0, 0, -kFlatten * position.z / kHalfDepth_um};
        tip.direction = normalized(tip.direction + kBend * cable.toward + kWobble * random_direction() + back);
        position = position + (cable.length_um / steps) * tip.direction;
        const double radius = cable.begin_radius_um + share * (cable.end_radius_um - cable.begin_radius_um);
        tip.point = add(cable.part, position, std::max(radius, kThinnest_um), tip.point);
    }
    return tip;
}

/// A cable that forks `forks` times over, each time into two daughters.
/// Their radii follow Rall's 3/2 rule (W. Rall, Ann. N.Y. Acad. Sci. 96 (1962) 1071), softened as in real cells.
void Grower::grow_tree(Cable stem, int forks, double daughter_length_um) {
    const Tip tip = grow_cable(stem);
    if (forks == 0) return;
    const double angle = between(0.35, 0.65);
    for (const double side : {-1.0, 1.0}) {
        Cable daughter = stem;
        daughter.from = tip.point;
        daughter.direction = turned(tip.direction, side * angle * between(0.7, 1.3));
        daughter.length_um = daughter_length_um * between(0.75, 1.3);
        daughter.begin_radius_um = 0.76 * stem.end_radius_um;
        daughter.end_radius_um = forks > 1 ? 0.9 * daughter.begin_radius_um : 0.62 * daughter.begin_radius_um;
        const bool ends_early = forks > 1 && rng_.uniform() < 0.2;
        grow_tree(daughter, ends_early ? 0 : forks - 1, daughter_length_um * 1.35);
    }
}

void Grower::grow_basal_dendrites() {
    constexpr int kStems = 6;
    for (int i = 0; i < kStems; ++i) {
        // Spread over a little more than the lower half circle; straight down is left to the axon.
        const double share = (i + between(0.2, 0.8)) / kStems;
        const double gap = share < 0.5 ? -0.22 : 0.22;
        const double angle = -kPi / 2 + gap + (share - 0.5) * 1.12 * kPi;
        Cable stem;
        stem.part = CellPart::BasalDendrite;
        stem.from = std::abs(share - 0.5) < 0.25 ? soma_base_ : soma_center_;
        stem.direction = normalized({std::cos(angle), std::sin(angle), between(-0.6, 0.6)});
        stem.toward = stem.direction;
        stem.length_um = between(14, 24);
        stem.begin_radius_um = between(1.3, 1.7);
        stem.end_radius_um = 0.75 * stem.begin_radius_um;
        grow_tree(stem, 2, between(36, 46));
    }
}

void Grower::grow_apical_dendrite() {
    constexpr int kTrunkPieces = 7;
    constexpr double kTrunk_um = 135;
    Tip tip{soma_top_, {0, 1, 0}};
    double radius = 2.3;
    for (int piece = 0; piece < kTrunkPieces; ++piece) {
        Cable trunk{
            CellPart::ApicalDendrite, tip.point, tip.direction, {0, 1.5, 0}, kTrunk_um / kTrunkPieces, radius, 0};
        trunk.end_radius_um = radius = 0.93 * radius;
        tip = grow_cable(trunk);
        if (piece == 0 || piece == kTrunkPieces - 1) continue;
        Cable oblique;
        oblique.part = CellPart::ApicalDendrite;
        oblique.from = tip.point;
        const double side = piece % 2 == 0 ? 1 : -1;
        oblique.direction = normalized({side, between(0.25, 0.7), between(-0.7, 0.7)});
        oblique.toward = {side, 0.3, 0};
        oblique.length_um = between(18, 42);
        oblique.begin_radius_um = 0.9;
        oblique.end_radius_um = 0.75;
        grow_tree(oblique, rng_.uniform() < 0.75 ? 1 : 0, between(32, 58));
    }
    for (const double side : {-1.0, 1.0}) {
        Cable limb{CellPart::ApicalDendrite,
                   tip.point,
                   turned(tip.direction, -side * between(0.35, 0.55)),
                   {0, 0.8, 0},
                   between(14, 22),
                   0.8 * radius,
                   0.7 * radius};
        grow_tree(limb, 2, between(26, 34));
    }
}

/// Leaves the axon at one side; carries a bouton every dozen micrometres.
void Grower::grow_collateral(int from, double side) {
    Tip tip{from, normalized({side, between(-0.6, 0.3), between(-0.5, 0.5)})};
    const int boutons = 4 + static_cast<int>(between(0, 5));
    for (int i = 0; i < boutons; ++i) {
        const Cable piece{CellPart::Axon, tip.point, tip.direction, {side, -0.2, 0}, between(10, 15), 0.4, 0.36};
        tip = grow_cable(piece);
        tip.point = add(CellPart::Axon, at(tip.point).position + 0.8 * tip.direction, 0.85, tip.point);
        tip.point = add(CellPart::Axon, at(tip.point).position + 0.8 * tip.direction, 0.34, tip.point);
    }
}

void Grower::grow_axon() {
    Tip tip = grow_cable({CellPart::Axon, soma_base_, {0.08, -1, 0.1}, {0, -1, 0}, 22, 1.0, 0.6});
    constexpr int kPieces = 5;
    for (int piece = 0; piece < kPieces; ++piece) {
        tip = grow_cable({CellPart::Axon, tip.point, tip.direction, {0, -1, 0}, between(20, 30), 0.55, 0.45});
        if (piece < kPieces - 1) grow_collateral(tip.point, piece % 2 == 0 ? 1 : -1);
    }
}

/// A neck and a head beside a cable, between a point and its parent.
void Grower::add_spine(int point, double share) {
    const MorphologyPoint a = at(at(point).parent);
    const MorphologyPoint b = at(point);
    const Vec3 along = normalized(b.position - a.position);
    const Frame frame = Frame::around(along);
    const double phi = between(0, 2 * kPi);
    const Vec3 out = normalized(std::cos(phi) * frame.x + std::sin(phi) * frame.y + between(-0.4, 0.4) * along);
    const Vec3 foot = a.position + share * (b.position - a.position);
    const double shaft = a.radius_um + share * (b.radius_um - a.radius_um);
    const double neck = between(0.5, 1.4);
    const double head = between(0.45, 0.7);
    const int base = add(CellPart::Spine, foot + shaft * out, 0.36, share < 0.5 ? b.parent : point);
    const int end = add(CellPart::Spine, foot + (shaft + neck) * out, 0.33, base);
    add(CellPart::Spine, foot + (shaft + neck + head) * out, head, end);
}

void Grower::grow_spines() {
    const auto cables = static_cast<int>(cell_.points.size());
    for (int point = 0; point < cables; ++point) {
        const MorphologyPoint here = at(point);
        const bool is_dendrite = here.part == CellPart::BasalDendrite || here.part == CellPart::ApicalDendrite;
        if (!is_dendrite || at(here.parent).part == CellPart::Soma) continue;
        if (length(here.position) < 30) continue;  // none near the soma
        const double expected = kSpinesPerMicrometre * length(here.position - at(here.parent).position);
        const int spines = static_cast<int>(expected + rng_.uniform());
        for (int i = 0; i < spines; ++i)
            add_spine(point, rng_.uniform());
    }
}

Morphology Grower::grow() {
    grow_soma();
    grow_apical_dendrite();
    grow_basal_dendrites();
    grow_axon();
    grow_spines();
    return std::move(cell_);
}

}  // namespace

Morphology grow_pyramidal_neuron(std::uint64_t seed) {
    return Grower(seed).grow();
}

}  // namespace fluovox
