#include "fluovox/voxelize/voxel_tile.h"

#include "fluovox/voxelize/clip.h"
#include "fluovox/voxelize/sub_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace fluovox {
namespace {

constexpr double kTiny = 1e-9;    // rounding of sums of areas
constexpr double kExcess = 1e-6;  // of a winding number over 1 or under 0 that isn't rounding

/// Cuts the triangles of a tile into pieces, one a voxel.
class PieceMaker {
public:
    /// With a `layer` above zero each piece is a sheet that thick instead of the surface of a solid.
    PieceMaker(const TileTask& task, std::vector<Piece>& pieces, double layer = 0, Solid solid = Solid::Inside)
        : y_(kBlockSide * task.y), z_(kBlockSide * task.z), layer_(layer), solid_(solid), pieces_(pieces) {}

    void add(const Vec3& a, const Vec3& b, const Vec3& c) {
        Polygon polygon;
        polygon.add(a);
        polygon.add(b);
        polygon.add(c);
        cut_rows(polygon);
    }

private:
    static int cell(double coordinate) { return static_cast<int>(std::floor(coordinate)); }

    /// Calls `next(part, cell)` for the part in each cell from `low` to `high` (exclusive) along an axis.
    template <class Next>
    static void cut(const Polygon& polygon, int axis, int low, int high, Next&& next) {
        const double begin = polygon.low(axis);
        const double end = polygon.high(axis);
        int first = cell(begin);
        // A polygon that lies in the plane between two cells belongs to the one above, or below at the far end.
        const int last = std::max(first, static_cast<int>(std::ceil(end)) - 1);
        if (first >= high || last < low) return;
        if (first == last) {
            next(polygon, first);
            return;
        }
        Polygon rest = polygon;
        Polygon below;
        Polygon above;
        if (first < low) {
            split(rest, axis, low, below, above);
            rest = above;
            first = low;
        }
        const int stop = std::min(last, high - 1);
        for (int i = first; i <= stop && rest.size > 2; ++i) {
            if (i == last) {
                next(rest, i);
                return;
            }
            split(rest, axis, i + 1, below, above);
            if (below.size > 2) next(below, i);
            rest = above;
        }
    }

    void cut_rows(const Polygon& polygon) {
        cut(polygon, 2, z_, z_ + kBlockSide, [&](const Polygon& row, int z) {
            cut(row, 1, y_, y_ + kBlockSide, [&](const Polygon& column, int y) {
                const auto number = static_cast<std::uint16_t>((y - y_) * kBlockSide + (z - z_));
                constexpr int kAll = 1 << 30;
                cut(column, 0, -kAll, kAll, [&](const Polygon& piece, int x) { add_piece(piece, x, number); });
            });
        });
    }

    void add_piece(const Polygon& piece, int x, std::uint16_t column) {
        if (layer_ > 0) {
            Vec3 area;
            for (std::size_t i = 2; i < piece.size; ++i)
                area = area + cross(piece.corners[i - 1] - piece.corners[0], piece.corners[i] - piece.corners[0]);
            pieces_.push_back({x, column, layer_ * length(area) / 2, 0});
            return;
        }
        const Vec3& origin = piece.corners[0];
        const double x0 = origin.x - x;
        double area = 0;
        double moment = 0;  // integral of x - cell over the area
        for (std::size_t i = 2; i < piece.size; ++i) {
            const Vec3 u = piece.corners[i - 1] - origin;
            const Vec3 v = piece.corners[i] - origin;
            const double part = (u.y * v.z - u.z * v.y) / 2;
            area += part;
            moment += part * (x0 + (u.x + v.x) / 3);
        }
        if (area == 0 && solid_ == Solid::Inside) return;
        pieces_.push_back({x, column, moment - area, -area});
    }

    int y_, z_;
    double layer_;
    Solid solid_;
    std::vector<Piece>& pieces_;
};

/// Sweeps a tile along x, block by block.
class TileSweep {
public:
    /// `lines`: what decides where surfaces overlap; without, nothing winds around anything twice.
    TileSweep(const TileTask& task, SubLines* lines, Solid solid = Solid::Inside)
        : task_(task), lines_(lines), solid_(solid) {}

    TileResult run(std::vector<Piece>& pieces) {
        std::stable_sort(pieces.begin(), pieces.end(),
                         [](const Piece& a, const Piece& b) { return a.x / kBlockSide < b.x / kBlockSide; });
        auto piece = pieces.begin();
        auto open = task_.open_blocks.begin();
        constexpr std::int32_t kEnd = std::numeric_limits<std::int32_t>::max();
        std::int32_t at = 0;
        while (piece != pieces.end() || open != task_.open_blocks.end()) {
            const std::int32_t next_piece = piece == pieces.end() ? kEnd : piece->x / kBlockSide;
            const std::int32_t next_open = open == task_.open_blocks.end() ? kEnd : *open;
            const std::int32_t block = std::min(next_piece, next_open);
            constant_run(at, block);
            auto end = piece;
            while (end != pieces.end() && end->x / kBlockSide == block)
                ++end;
            mixed_block(block, pieces.data() + (piece - pieces.begin()), static_cast<std::size_t>(end - piece),
                        next_open == block);
            piece = end;
            while (open != task_.open_blocks.end() && *open == block)
                ++open;
            at = block + 1;
        }
        return std::move(result_);
    }

private:
    using Columns = std::array<double, kBlockColumns>;

    /// Blocks without any surface across x: what winds around each column stays the same.
    void constant_run(std::int32_t begin, std::int32_t end) {
        if (begin >= end) return;
        bool all_in = true;
        bool all_out = true;
        bool doubtful = false;
        double sum = 0;
        for (const double w : running_) {
            sum += w;
            const bool whole = w == std::round(w);
            const bool in = solid_ == Solid::Inside ? w >= 1 : w != 0;
            all_in &= whole && in;
            all_out &= whole && !in;
            doubtful |= !whole && (w > 1 + kExcess || w < -kExcess);
        }
        const double blocks = end - begin;
        result_.winding_volume += sum * kBlockSide * blocks;
        if (all_out) return;
        if (all_in) {
            result_.full.push_back({begin, end});
            result_.volume += kBlockVoxels * blocks;
            return;
        }
        BlockValues values;
        if (doubtful && lines_ != nullptr) {
            lines_->fill_block(begin, values);
        } else {
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = static_cast<float>(std::clamp(running_[i % kBlockColumns], 0.0, 1.0));
        }
        add_blocks(begin, end, values);
    }

    void mixed_block(std::int32_t block, const Piece* pieces, std::size_t count, bool open) {
        std::array<double, kBlockVoxels> volume{};
        std::array<double, kBlockVoxels> area{};
        std::bitset<kBlockVoxels> crossed;
        for (const Piece* piece = pieces; piece != pieces + count; ++piece) {
            const auto slice = static_cast<std::size_t>(piece->x - kBlockSide * block);
            const std::size_t voxel = slice * kBlockColumns + piece->column;
            volume[voxel] += piece->volume;
            area[voxel] += piece->area;
            crossed.set(voxel);
        }
        if (solid_ == Solid::Enclosed) result_.crossed.emplace_back(block, crossed);
        BlockValues values;
        bool doubtful = false;
        for (std::size_t voxel = 0; voxel < kBlockVoxels; ++voxel) {
            double& w = running_[voxel % kBlockColumns];
            const double inside = w + volume[voxel];
            w += area[voxel];
            result_.winding_volume += inside;
            doubtful |= inside > 1 + kExcess || inside < -kExcess;
            values[voxel] = static_cast<float>(inside < kTiny ? 0.0 : (inside > 1 - kTiny ? 1.0 : inside));
        }
        for (double& w : running_)
            if (std::abs(w - std::round(w)) < kTiny) w = std::round(w);
        if (open) {
            result_.decided_by_winding += lines_->fill_open_block(block, values);
        } else if (doubtful && lines_ != nullptr) {
            lines_->fill_block(block, values);
        }
        add_blocks(block, block + 1, values);
    }

    void add_blocks(std::int32_t begin, std::int32_t end, const BlockValues& values) {
        double sum = 0;
        for (const float value : values)
            sum += static_cast<double>(value);
        if (sum == 0) return;
        result_.volume += sum * (end - begin);
        if (sum == kBlockVoxels) {
            result_.full.push_back({begin, end});
            return;
        }
        const auto number = static_cast<std::uint32_t>(result_.values.size());
        result_.values.push_back(values);
        for (std::int32_t block = begin; block < end; ++block)
            result_.blocks.push_back({block, number});
    }

    const TileTask& task_;
    SubLines* lines_;
    Solid solid_;
    Columns running_{};
    TileResult result_;
};

}  // namespace

TileResult fill_tile(const VoxelSurface& surface, const TileTask& task, Solid solid) {
    std::vector<Piece> pieces;
    PieceMaker maker(task, pieces, 0, solid);
    const Mesh& mesh = surface.mesh;
    for (const std::uint32_t* t = task.begin; t != task.end; ++t) {
        const auto& corners = mesh.triangles[*t];
        maker.add(mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]);
    }
    SubLines lines(surface, task, solid);
    return TileSweep(task, &lines, solid).run(pieces);
}

TileResult fill_layer_tile(const VoxelSurface& surface, const TileTask& task, double thickness) {
    std::vector<Piece> pieces;
    PieceMaker maker(task, pieces, thickness);
    const Mesh& mesh = surface.mesh;
    for (const std::uint32_t* t = task.begin; t != task.end; ++t) {
        const auto& corners = mesh.triangles[*t];
        maker.add(mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]);
    }
    return sweep_tile(task, pieces);
}

TileResult sweep_tile(const TileTask& task, std::vector<Piece>& pieces) {
    return TileSweep(task, nullptr).run(pieces);
}

}  // namespace fluovox
