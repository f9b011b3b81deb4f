#include "fluovox/transport/voxel_tally.h"

#include "fluovox/transport/absorbed_share.h"
#include "fluovox/volume/sparse_grid_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace fluovox {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kBrick = SparseGrid::kBrickSize;
constexpr std::size_t kVoxels = std::size_t{kBrick} * kBrick * kBrick;

// Voxels of a brick that have a value themselves or next to them: values reach half a voxel beyond their own, being
// trilinear.
VoxelLattice::Mask voxels_with_values(const SparseGrid& grid, Voxel origin) {
    constexpr int kWide = kBrick + 2;
    // Rows along z in bits, of which each takes in the rows next to it.
    std::array<std::array<unsigned, kWide>, kWide> rows{};
    for (int x = 0; x < kWide; ++x) {
        for (int y = 0; y < kWide; ++y) {
            unsigned row = 0;
            for (int z = 0; z < kWide; ++z) {
                if (grid.value({origin.x + x - 1, origin.y + y - 1, origin.z + z - 1}) > 0) row |= 1U << z;
            }
            rows[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)] = row | row << 1U | row >> 1U;
        }
    }
    VoxelLattice::Mask mask{};
    for (std::size_t x = 0; x < kBrick; ++x) {
        for (std::size_t y = 0; y < kBrick; ++y) {
            unsigned near = 0;
            for (std::size_t i = 0; i < 9; ++i)
                near |= rows[x + i / 3][y + i % 3];
            mask[x] |= std::uint64_t{(near >> 1U) & 0xffU} << (8 * y);
        }
    }
    return mask;
}

std::vector<Voxel> bricks_in_box(const SparseGrid& grid) {
    Bounds box;
    for (int corner = 0; corner < 8; ++corner) {
        const Bounds& world = grid.bounds();
        box.add(grid.index_from_world().point({(corner & 1) != 0 ? world.min.x : world.max.x,
                                               (corner & 2) != 0 ? world.min.y : world.max.y,
                                               (corner & 4) != 0 ? world.min.z : world.max.z}));
    }
    std::vector<Voxel> bricks;
    const auto low = [](double v) { return static_cast<int>(std::floor(v / kBrick)) * kBrick; };
    for (int x = low(box.min.x); x <= box.max.x; x += kBrick) {
        for (int y = low(box.min.y); y <= box.max.y; y += kBrick) {
            for (int z = low(box.min.z); z <= box.max.z; z += kBrick)
                bricks.push_back({x, y, z});
        }
    }
    return bricks;
}

// The bricks of the grid and those above them, into which the values of their last layers reach. Of a fibre's box they
// are a vanishing part.
std::vector<Voxel> bricks_near_values(const SparseGrid& grid) {
    std::vector<std::array<int, 3>> near;
    for (const Voxel brick : SparseGridBuilder::bricks_of(grid)) {
        for (int axes = 0; axes < 8; ++axes)
            near.push_back(
                {brick.x + kBrick * (axes >> 2), brick.y + kBrick * ((axes >> 1) & 1), brick.z + kBrick * (axes & 1)});
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::vector<Voxel> bricks;
    bricks.reserve(near.size());
    for (const auto& [x, y, z] : near)
        bricks.push_back({x, y, z});
    return bricks;
}

/// Cells of `size` voxels: the first, and how many along each axis.
struct CellBox {
    std::array<int, 3> first{}, count{};
    int size = 1;
};

/// Part of `span` that is inside the box.
Interval inside(const CellBox& box, const Ray& ray, Interval span) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double low = box.first[a] * box.size - ray.origin[axis];
        const double high = low + box.count[a] * box.size;
        if (ray.direction[axis] == 0) {
            if (low > 0 || high <= 0) return {0, 0};
            continue;
        }
        const double t0 = low / ray.direction[axis];
        const double t1 = high / ray.direction[axis];
        span = {std::max(span.begin, std::min(t0, t1)), std::min(span.end, std::max(t0, t1))};
    }
    return span;
}

/// A ray on its way from cell to cell. Amanatides & Woo, Eurographics 1987.
class CellSteps {
public:
    /// In the cell of `box` that holds the ray's point at `begin`.
    CellSteps(const CellBox& box, const Ray& ray, double begin) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const double d = ray.direction[axis];
            const int from = static_cast<int>(std::floor((ray.origin[axis] + begin * d) / box.size));
            cell_[a] = std::clamp(from, box.first[a], box.first[a] + box.count[a] - 1);
            if (d == 0) continue;
            step_[a] = d > 0 ? 1 : -1;
            delta_[a] = box.size / std::abs(d);
            next_[a] = ((cell_[a] + (d > 0 ? 1 : 0)) * box.size - ray.origin[axis]) / d;
        }
    }

    const std::array<int, 3>& cell() const { return cell_; }
    /// Axis across which the ray leaves the cell, and where.
    std::size_t axis() const {
        if (next_[0] < next_[1]) return next_[0] < next_[2] ? 0 : 2;
        return next_[1] < next_[2] ? 1 : 2;
    }
    double end(std::size_t axis) const { return next_[axis]; }
    void cross(std::size_t axis) {
        cell_[axis] += step_[axis];
        next_[axis] += delta_[axis];
    }

private:
    std::array<int, 3> cell_{}, step_{};
    std::array<double, 3> next_{kFar, kFar, kFar}, delta_{kFar, kFar, kFar};
};

/// Calls `visit` for each cell along a span inside the box, in order.
template <class Visit>
void march(const CellBox& box, const Ray& ray, Interval span, const Visit& visit) {
    CellSteps steps(box, ray, span.begin);
    double t = span.begin;
    while (t < span.end) {
        const std::size_t axis = steps.axis();
        const double end = std::max(t, std::min(steps.end(axis), span.end));
        visit(steps.cell(), {t, end});
        t = end;
        steps.cross(axis);
        // Rounding at a face may leave a last sliver outside.
        const int cell = steps.cell()[axis];
        if (cell < box.first[axis] || cell >= box.first[axis] + box.count[axis]) return;
    }
}

}  // namespace

VoxelLattice VoxelLattice::filling(const Bounds& box, double voxel_um) {
    VoxelLattice lattice;
    for (int axis = 0; axis < 3; ++axis)
        lattice.world_from_index.rows[static_cast<std::size_t>(axis)] = [&] {
            Vec3 row;
            row[axis] = voxel_um;
            return row;
        }();
    // Voxel centres are at whole numbers, so the lowest faces are half a voxel before.
    lattice.world_from_index.offset = box.min + 0.5 * Vec3{voxel_um, voxel_um, voxel_um};
    const auto bricks = [&](double size) {
        return static_cast<int>(std::ceil(std::ceil(size / voxel_um - 1e-9) / kBrick));
    };
    const Vec3 size = box.size();
    for (int x = 0; x < bricks(size.x); ++x) {
        for (int y = 0; y < bricks(size.y); ++y) {
            for (int z = 0; z < bricks(size.z); ++z)
                lattice.bricks.push_back({x * kBrick, y * kBrick, z * kBrick});
        }
    }
    return lattice;
}

VoxelLattice VoxelLattice::of(const SparseGrid& grid) {
    VoxelLattice lattice = with_values(grid);
    lattice.masks.clear();
    return lattice;
}

VoxelLattice VoxelLattice::with_values(const SparseGrid& grid) {
    VoxelLattice lattice;
    lattice.world_from_index = grid.world_from_index();
    for (const Voxel brick : grid.background() > 0 ? bricks_in_box(grid) : bricks_near_values(grid)) {
        const Mask mask = voxels_with_values(grid, brick);
        if (mask == Mask{}) continue;
        lattice.bricks.push_back(brick);
        lattice.masks.push_back(mask);
    }
    return lattice;
}

double VoxelLattice::voxel_volume_um3() const {
    const auto& rows = world_from_index.rows;
    return std::abs(dot(rows[0], cross(rows[1], rows[2])));
}

bool operator==(const VoxelLattice& a, const VoxelLattice& b) {
    const auto same = [](const Voxel& v, const Voxel& w) { return v.x == w.x && v.y == w.y && v.z == w.z; };
    return a.world_from_index.rows == b.world_from_index.rows &&
           a.world_from_index.offset == b.world_from_index.offset &&
           std::equal(a.bricks.begin(), a.bricks.end(), b.bricks.begin(), b.bricks.end(), same) && a.masks == b.masks;
}

double VoxelTally::bytes(const VoxelLattice& lattice, int fields) {
    return static_cast<double>(lattice.bricks.size()) * static_cast<double>(kVoxels * sizeof(std::int64_t)) * fields;
}

std::size_t VoxelTally::bytes() const {
    return per_field_ * sizeof(std::int64_t) * static_cast<std::size_t>(fields_);
}

VoxelTally::VoxelTally(VoxelLattice lattice, int fields, double photons)
    : lattice_(std::move(lattice)),
      index_from_world_(lattice_.world_from_index.inverse()),
      volume_(lattice_.voxel_volume_um3()),
      // Room for every photon to pass each voxel 256 times.
      units_(0x1p62 / (256 * std::max(1.0, photons)) / std::cbrt(volume_)),
      fields_(fields),
      per_field_(lattice_.bricks.size() * kVoxels),
      sums_(per_field_ * static_cast<std::size_t>(fields)) {
    Voxel last{std::numeric_limits<int>::min(), std::numeric_limits<int>::min(), std::numeric_limits<int>::min()};
    first_ = {std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
    for (const Voxel& v : lattice_.bricks) {
        first_ = {std::min(first_.x, v.x >> 3), std::min(first_.y, v.y >> 3), std::min(first_.z, v.z >> 3)};
        last = {std::max(last.x, v.x >> 3), std::max(last.y, v.y >> 3), std::max(last.z, v.z >> 3)};
    }
    if (lattice_.bricks.empty()) first_ = last = {0, 0, 0};
    count_ = {last.x - first_.x + 1, last.y - first_.y + 1, last.z - first_.z + 1};
    const auto cubes = [](int bricks) { return (bricks + kCube - 1) / kCube; };
    cubes_ = {cubes(count_.x), cubes(count_.y), cubes(count_.z)};
    cube_.assign(
        static_cast<std::size_t>(cubes_.x) * static_cast<std::size_t>(cubes_.y) * static_cast<std::size_t>(cubes_.z),
        -1);
    for (std::size_t i = 0; i < lattice_.bricks.size(); ++i) {
        const Voxel& v = lattice_.bricks[i];
        const Voxel at{(v.x >> 3) - first_.x, (v.y >> 3) - first_.y, (v.z >> 3) - first_.z};
        std::int32_t& cube = cube_[cube_at(at)];
        if (cube < 0) {
            cube = static_cast<std::int32_t>(brick_.size() / kBricksPerCube);
            brick_.resize(brick_.size() + kBricksPerCube, -1);
        }
        brick_[static_cast<std::size_t>(cube) * kBricksPerCube + place_in_cube(at)] = static_cast<std::int32_t>(i);
    }
}

// Of a place in the box of bricks.
std::size_t VoxelTally::cube_at(Voxel place) const {
    return (static_cast<std::size_t>(place.x / kCube) * static_cast<std::size_t>(cubes_.y) +
            static_cast<std::size_t>(place.y / kCube)) *
               static_cast<std::size_t>(cubes_.z) +
           static_cast<std::size_t>(place.z / kCube);
}

std::size_t VoxelTally::place_in_cube(Voxel place) {
    return (static_cast<std::size_t>(place.x % kCube) * kCube + static_cast<std::size_t>(place.y % kCube)) * kCube +
           static_cast<std::size_t>(place.z % kCube);
}

void VoxelTally::clear() {
    for (auto& sum : sums_)
        sum.store(0, std::memory_order_relaxed);
}

std::int64_t VoxelTally::slot(int x, int y, int z) const {
    const int i = (x >> 3) - first_.x;
    const int j = (y >> 3) - first_.y;
    const int k = (z >> 3) - first_.z;
    if (i < 0 || j < 0 || k < 0 || i >= count_.x || j >= count_.y || k >= count_.z) return -1;
    const std::int32_t cube = cube_[cube_at({i, j, k})];
    if (cube < 0) return -1;
    const std::int32_t brick = brick_[static_cast<std::size_t>(cube) * kBricksPerCube + place_in_cube({i, j, k})];
    if (brick < 0) return -1;
    return std::int64_t{brick} * static_cast<std::int64_t>(kVoxels) + ((x & 7) << 6 | (y & 7) << 3 | (z & 7));
}

std::int64_t VoxelTally::slot(Vec3 position_um) const {
    const Vec3 p = index_from_world_.point(position_um) + Vec3{0.5, 0.5, 0.5};
    constexpr double kFarthest = 0x1.0p31;  // light may go farther than whole numbers do
    for (int axis = 0; axis < 3; ++axis) {
        if (!(std::abs(p[axis]) < kFarthest)) return -1;
    }
    return slot(static_cast<int>(std::floor(p.x)), static_cast<int>(std::floor(p.y)),
                static_cast<int>(std::floor(p.z)));
}

void VoxelTally::add(std::int64_t slot, int field, double amount, Rng& rng) {
    const double units = amount * units_;
    const auto whole = static_cast<std::int64_t>(std::floor(units + rng.uniform()));
    const std::size_t at = static_cast<std::size_t>(field) * per_field_ + static_cast<std::size_t>(slot);
    if (whole != 0) sums_[at].fetch_add(whole, std::memory_order_relaxed);
}

void VoxelTally::add_point(Vec3 position_um, int field, double amount, Rng& rng) {
    const std::int64_t at = slot(position_um);
    if (at >= 0) add(at, field, amount, rng);
}

// One walk for those that add and those that read; a template, so that adding costs no calls.
template <class Function>
void VoxelTally::walk(const Ray& ray, double length_um, const Function& visit) const {
    const Ray in_voxels{index_from_world_.point(ray.origin) + Vec3{0.5, 0.5, 0.5},
                        index_from_world_.direction(ray.direction)};
    const auto visit_brick = [&](const std::array<int, 3>& brick, Interval in_brick) {
        const std::int64_t first = slot(kBrick * brick[0], kBrick * brick[1], kBrick * brick[2]);
        if (first < 0) return;
        const CellBox voxels{{kBrick * brick[0], kBrick * brick[1], kBrick * brick[2]}, {kBrick, kBrick, kBrick}, 1};
        march(voxels, in_voxels, in_brick, [&](const std::array<int, 3>& voxel, Interval stretch) {
            const int number = (voxel[0] & 7) << 6 | (voxel[1] & 7) << 3 | (voxel[2] & 7);
            const auto index = static_cast<std::size_t>(first >> 9);
            if (lattice_.counts(index, number)) visit(index, number, stretch);
        });
    };
    const CellBox bricks{{first_.x, first_.y, first_.z}, {count_.x, count_.y, count_.z}, kBrick};
    const Interval span = inside(bricks, in_voxels, {0, length_um});
    if (span.empty()) return;
    if (cube_.size() == 1) {
        march(bricks, in_voxels, span, visit_brick);
        return;
    }
    // Cubes without any brick are passed at once. Counted from the first brick, a cube begins at a multiple of them.
    const Ray from_first{in_voxels.origin - kBrick * Vec3{1.0 * first_.x, 1.0 * first_.y, 1.0 * first_.z},
                         in_voxels.direction};
    const CellBox cubes{{0, 0, 0}, {cubes_.x, cubes_.y, cubes_.z}, kCube * kBrick};
    march(cubes, from_first, span, [&](const std::array<int, 3>& cube, Interval in_cube) {
        const Voxel at{kCube * cube[0], kCube * cube[1], kCube * cube[2]};
        if (cube_[cube_at(at)] < 0) return;
        const CellBox inner{{first_.x + at.x, first_.y + at.y, first_.z + at.z}, {kCube, kCube, kCube}, kBrick};
        march(inner, in_voxels, in_cube, visit_brick);
    });
}

// Calls `add(slot, integral, stretch, share)` with the integral of the weight over what lies in each voxel, of which
// `share` is absorbed.
template <class AddShares>
void VoxelTally::add_stretches(const FadingFlight& flight, const AddShares& add) {
    const double absorption = flight.absorption_per_um;
    double here = flight.weight;
    double before = 0;  // where `here` holds
    walk(flight.ray, flight.length_um, [&](std::size_t brick, int in_brick, Interval stretch) {
        // From voxel to voxel the exponential is made from its factors; over a gap it is taken anew.
        if (absorption > 0 && stretch.begin != before) here = flight.weight * std::exp(-absorption * stretch.begin);
        before = stretch.end;
        const double share = absorbed_share(absorption * stretch.length());
        const double lost = here * share;
        const double integral = absorption > 0 ? lost / absorption : here * stretch.length();
        here -= lost;
        add(static_cast<std::int64_t>(brick * kVoxels) + in_brick, integral, stretch, share);
    });
}

void VoxelTally::add_flight(const FadingFlight& flight, const std::vector<Share>& shares, Rng& rng) {
    add_stretches(flight, [&](std::int64_t slot, double integral, Interval, double) {
        for (const Share& share : shares)
            add(slot, share.field, share.factor * integral, rng);
    });
}

void VoxelTally::add_flight(const FadingFlight& flight, const std::vector<Share>& shares, const FactorAt& at,
                            Rng& rng) {
    const double absorption = flight.absorption_per_um;
    add_stretches(flight, [&](std::int64_t slot, double integral, Interval stretch, double lost) {
        // More of the weight is at the beginning.
        const double u = rng.uniform();
        const double along = absorption > 0 ? depth_of_share(u * lost) / absorption : u * stretch.length();
        const Vec3 place = flight.ray.at(stretch.begin + along);
        for (const Share& share : shares) {
            const double factor = share.factor * at(share, place);
            if (factor > 0) add(slot, share.field, factor * integral, rng);
        }
    });
}

void VoxelTally::for_each_voxel(const Ray& ray, double length_um, const Visit& visit) const {
    walk(ray, length_um, visit);
}

double VoxelTally::at(Vec3 position_um, int field) const {
    const std::int64_t voxel = slot(position_um);
    if (voxel < 0) return 0;
    return at(static_cast<std::size_t>(voxel >> 9), static_cast<int>(voxel & 511), field);
}

double VoxelTally::at(std::size_t brick, int in_brick, int field) const {
    const std::size_t i =
        static_cast<std::size_t>(field) * per_field_ + brick * kVoxels + static_cast<std::size_t>(in_brick);
    return static_cast<double>(sums_[i].load(std::memory_order_relaxed)) / units_;
}

BrickField VoxelTally::field(int field, double factor) const {
    BrickField result;
    result.world_from_index = lattice_.world_from_index;
    result.bricks = lattice_.bricks;
    result.values.resize(per_field_);
    const std::size_t first = static_cast<std::size_t>(field) * per_field_;
    for (std::size_t i = 0; i < per_field_; ++i) {
        const auto sum = static_cast<double>(sums_[first + i].load(std::memory_order_relaxed));
        result.values[i] = static_cast<float>(factor * sum / units_);
    }
    return result;
}

}  // namespace fluovox
