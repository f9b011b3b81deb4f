#include "scenes.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/rng.h"
#include "fluovox/medium/phase_function.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>
#include <vector>

namespace fluovox::bench {
namespace {

/// Bricks made where something is written, in the order in which that happens.
class BrickWriter {
public:
    explicit BrickWriter(Voxel size) { field_.size = size; }

    /// The voxel's value becomes at least this.
    void raise(int x, int y, int z, float value) {
        float& old = at(x, y, z);
        old = std::max(old, value);
    }

    BenchField finish() {
        double sum = 0;
        double middle = 0;
        const auto in_middle = [](int i, int n) { return 3 * i >= n && 3 * i < 2 * n; };
        const BrickField& bricks = field_.bricks;
        for (std::size_t b = 0; b < bricks.bricks.size(); ++b) {
            for (int i = 0; i < 512; ++i) {
                const auto value = static_cast<double>(bricks.values[512 * b + static_cast<std::size_t>(i)]);
                if (value == 0) continue;
                ++field_.active;
                sum += value;
                const Voxel& origin = bricks.bricks[b];
                if (in_middle(origin.x + (i >> 6), field_.size.x) &&
                    in_middle(origin.y + ((i >> 3) & 7), field_.size.y))
                    middle += value;
            }
        }
        field_.mean = sum / field_.size.x / field_.size.y / field_.size.z;
        field_.through_middle_um = middle * 9 / field_.size.x / field_.size.y;
        field_.bricks.name = "density";
        return std::move(field_);
    }

private:
    float& at(int x, int y, int z) {
        const Voxel origin{x & ~7, y & ~7, z & ~7};
        const auto key = (static_cast<std::uint64_t>(origin.x) << 40U) | (static_cast<std::uint64_t>(origin.y) << 20U) |
                         static_cast<std::uint64_t>(origin.z);
        const auto [known, fresh] = slots_.try_emplace(key, field_.bricks.bricks.size());
        if (fresh) {
            field_.bricks.bricks.push_back(origin);
            field_.bricks.values.resize(512 * field_.bricks.bricks.size(), 0.0F);
        }
        return field_.bricks
            .values[512 * known->second + static_cast<std::size_t>(((x & 7) << 6) | ((y & 7) << 3) | (z & 7))];
    }

    BenchField field_;
    std::unordered_map<std::uint64_t, std::size_t> slots_;
};

/// A straight piece of tube, in voxels.
struct Piece {
    Vec3 from, to;
    double radius = 0;
};

void draw(const Piece& piece, Voxel size, BrickWriter& bricks) {
    const double reach = piece.radius + 0.5;
    const Vec3 axis = piece.to - piece.from;
    const double squared = std::max(length_squared(axis), 1e-12);
    const auto low = [&](int a) {
        return std::max(0, static_cast<int>(std::ceil(std::min(piece.from[a], piece.to[a]) - reach)));
    };
    const auto high = [&](int a, int count) {
        return std::min(count - 1, static_cast<int>(std::floor(std::max(piece.from[a], piece.to[a]) + reach)));
    };
    for (int x = low(0); x <= high(0, size.x); ++x) {
        for (int y = low(1); y <= high(1, size.y); ++y) {
            for (int z = low(2); z <= high(2, size.z); ++z) {
                const Vec3 p = Vec3{1.0 * x, 1.0 * y, 1.0 * z} - piece.from;
                const double along = std::clamp(dot(p, axis) / squared, 0.0, 1.0);
                const double inside = reach - length(p - along * axis);
                if (inside > 0) bricks.raise(x, y, z, static_cast<float>(std::min(1.0, inside)));
            }
        }
    }
}

/// Grows one cable until it leaves the box, with branches; gives the volume of what it drew.
double grow(const Tubes& tubes, Rng& rng, BrickWriter& bricks, Voxel size) {
    struct Tip {
        Vec3 place, direction;
        double radius;
        int left;
    };
    constexpr double kStep = 4;
    constexpr double kBend = 0.35;
    constexpr double kBranch = 0.03;
    const auto outside = [&](Vec3 p) {
        return p.x < 0 || p.y < 0 || p.z < 0 || p.x > tubes.size.x || p.y > tubes.size.y || p.z > tubes.size.z;
    };
    const Vec3 start{tubes.size.x * rng.uniform(), tubes.size.y * rng.uniform(), tubes.size.z * rng.uniform()};
    std::vector<Tip> tips = {{start, sample_isotropic(rng.uniform(), rng.uniform()), tubes.radius, 120}};
    double volume = 0;
    while (!tips.empty()) {
        Tip& tip = tips.back();
        const Vec3 next = tip.place + kStep * tip.direction;
        draw({tubes.scale * tip.place, tubes.scale * next, tubes.scale * tip.radius}, size, bricks);
        volume += kStep * 3.14159 * tip.radius * tip.radius;
        tip.place = next;
        tip.direction = normalized(tip.direction + kBend * sample_isotropic(rng.uniform(), rng.uniform()));
        tip.radius = std::max(0.5 * tubes.radius, 0.998 * tip.radius);
        if (--tip.left == 0 || outside(next)) {
            tips.pop_back();
        } else if (rng.uniform() < kBranch) {
            Tip branch = tip;
            branch.direction = normalized(tip.direction + 1.2 * sample_isotropic(rng.uniform(), rng.uniform()));
            branch.radius = std::max(0.5 * tubes.radius, 0.85 * tip.radius);
            tips.push_back(branch);
        }
    }
    return volume;
}

// Noise between 0 and 1 that is smooth between the points of a lattice.
double noise(Vec3 p, std::uint64_t octave) {
    const Vec3 base{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const Vec3 w{smooth(p.x - base.x), smooth(p.y - base.y), smooth(p.z - base.z)};
    double total = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const auto at = [&](int axis) {
            return static_cast<std::uint64_t>(base[axis] + ((corner >> axis) & 1) + 1024);
        };
        const double value = Rng(octave, at(0) << 32U | at(1), at(2)).uniform();
        total += value * ((corner & 1) != 0 ? w.x : 1 - w.x) * ((corner & 2) != 0 ? w.y : 1 - w.y) *
                 ((corner & 4) != 0 ? w.z : 1 - w.z);
    }
    return total;
}

}  // namespace

BenchField make_tubes(const Tubes& tubes) {
    const Voxel size{tubes.scale * tubes.size.x, tubes.scale * tubes.size.y, tubes.scale * tubes.size.z};
    BrickWriter bricks(size);
    Rng rng(tubes.seed, 0x7475626573, 0);
    const double wanted = tubes.share * tubes.size.x * tubes.size.y * tubes.size.z;
    for (double volume = 0; volume < wanted;)
        volume += grow(tubes, rng, bricks, size);
    BenchField field = bricks.finish();
    // Growth is the same at any scale; only the voxels are finer.
    for (std::size_t a = 0; a < 3; ++a)
        field.bricks.world_from_index.rows[a] = (1.0 / tubes.scale) * field.bricks.world_from_index.rows[a];
    field.size = tubes.size;
    field.through_middle_um /= tubes.scale;
    return field;
}

BenchField make_cloud(int resolution) {
    BrickWriter bricks({resolution, resolution, resolution});
    for (int x = 0; x < resolution; ++x) {
        for (int y = 0; y < resolution; ++y) {
            for (int z = 0; z < resolution; ++z) {
                const Vec3 p = (2.0 / resolution) * Vec3{x + 0.5, y + 0.5, z + 0.5} - Vec3{1, 1, 1};
                const double inside = 0.75 - length(p);
                if (inside <= 0) continue;
                double billow = 0;
                double height = 0.5;
                for (std::uint64_t octave = 0; octave < 4; ++octave, height *= 0.5)
                    billow += height * noise((3.0 * static_cast<double>(1U << octave)) * p, octave);
                const double value = 2 * (billow - 0.45) + inside;
                if (value > 0) bricks.raise(x, y, z, static_cast<float>(std::min(1.0, value)));
            }
        }
    }
    return bricks.finish();
}

void write_elastic_scene(const std::filesystem::path& folder, const std::string& name, const BenchField& field,
                         double extinction_per_um, int samples) {
    save_brick_fields(folder / (name + ".vdb"), {field.bricks});
    const Vec3 size{1.0 * field.size.x, 1.0 * field.size.y, 1.0 * field.size.z};
    const Vec3 middle = 0.5 * size;
    const double far = 4 * length(size);
    const Vec3 direction = normalized(Vec3{0.48, 0.36, -0.8});
    const Vec3 light = middle - far * direction;
    const Vec3 normal = normalized(cross(direction, Vec3{0, 1, 0}));
    write_text_file(
        folder / (name + ".toml"),
        fmt::format(R"(title = "{}"

[[medium]]
name       = "tubes"
scattering = "{:.9g} /um"
absorption = "{:.9g} /um"
anisotropy = 0
grid       = {{ file = "{}.vdb", name = "density" }}

[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 W"
position   = ["{:.9g} um", "{:.9g} um", "{:.9g} um"]
direction  = [{:.17g}, {:.17g}, {:.17g}]
normal     = [{:.17g}, {:.17g}, {:.17g}]
width      = "{:.9g} um"
thickness  = "{:.9g} um"
profile    = "box"

[camera]
kind       = "telecentric"
position   = ["{:.9g} um", "{:.9g} um", "{:.9g} um"]
target     = ["{:.9g} um", "{:.9g} um", "{:.9g} um"]
up         = [0, 1, 0]
field      = "{:.9g} um"
resolution = [{}, 128]
numerical_aperture = 0

[film]
spectrum = {{ from = "487 nm", to = "489 nm", bins = 1 }}

[render]
estimator = "path"
samples   = {}
seed      = 1
)",
                    name, 0.99 * extinction_per_um, 0.01 * extinction_per_um, name, light.x, light.y, light.z,
                    direction.x, direction.y, direction.z, normal.x, normal.y, normal.z, far, far, middle.x, middle.y,
                    size.z + 10, middle.x, middle.y, middle.z, size.y, 128 * field.size.x / field.size.y, samples));
}

}  // namespace fluovox::bench
