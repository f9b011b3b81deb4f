#include "fluovox/voxelize/sub_lines.h"

#include "fluovox/core/rng.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

/// Where the lines of a column lie within their cells of 1/8 x 1/8 voxel: the same for all 64, different from column
/// to column, so that no direction of a thin process is favoured.
std::pair<double, double> shift_of_column(int y, int z) {
    Rng random(0x5eed, static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(z));
    const double u = random.uniform();
    return {u, random.uniform()};
}

/// Which side of the edge from `a` to `b` a line is on, the same number with opposite signs for the two triangles of
/// the edge; exactly on it, one of the two has it.
bool left_of(const Mesh& mesh, std::uint32_t a, std::uint32_t b, double y, double z, double& value) {
    const bool forward = a < b;
    const Vec3& low = mesh.vertices[forward ? a : b];
    const Vec3& high = mesh.vertices[forward ? b : a];
    const double side = (high.y - low.y) * (z - low.z) - (high.z - low.z) * (y - low.y);
    value = forward ? side : -side;
    return value > 0 || (value == 0 && forward);
}

}  // namespace

std::pair<double, double> sub_line_place(const TileTask& task, std::size_t line) {
    constexpr int kPerSide = 8;
    const auto column = static_cast<int>(line / kSubLines);
    const auto number = static_cast<int>(line % kSubLines);
    const int y = kBlockSide * task.y + column / kBlockSide;
    const int z = kBlockSide * task.z + column % kBlockSide;
    const int row = number / kPerSide;
    const int place = number % kPerSide;
    const auto [u, v] = shift_of_column(y, z);
    return {y + (row + u) / kPerSide, z + (place + v) / kPerSide};
}

SubLines::Place SubLines::place(std::size_t line) const {
    const auto [y, z] = sub_line_place(task_, line);
    return {y, z};
}

void SubLines::cut_lines_by(std::uint32_t triangle, std::vector<std::pair<std::uint32_t, Crossing>>& found) const {
    const Mesh& mesh = surface_.mesh;
    const Mesh::Triangle& t = mesh.triangles[triangle];
    const bool open_cap = !surface_.is_open_cap.empty() && surface_.is_open_cap[triangle] != 0;
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3& b = mesh.vertices[t[1]];
    const Vec3& c = mesh.vertices[t[2]];
    const auto range = [](double low, double high, int origin) {
        return std::pair(std::max(0, static_cast<int>(std::floor(low)) - origin),
                         std::min(kBlockSide - 1, static_cast<int>(std::floor(high)) - origin));
    };
    const auto [y0, y1] = range(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), kBlockSide * task_.y);
    const auto [z0, z1] = range(std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z}), kBlockSide * task_.z);
    for (int column_y = y0; column_y <= y1; ++column_y) {
        for (int column_z = z0; column_z <= z1; ++column_z) {
            const auto first = static_cast<std::uint32_t>((column_y * kBlockSide + column_z) * kPerColumn);
            const Place corner = place(first);
            for (std::uint32_t n = 0; n < kPerColumn; ++n) {
                const std::uint32_t row = n / kPerSide;
                const double y = corner.y + static_cast<double>(row) / kPerSide;
                const double z = corner.z + static_cast<double>(n % kPerSide) / kPerSide;
                double u = 0;
                double v = 0;
                double w = 0;
                const bool left_u = left_of(mesh, t[1], t[2], y, z, u);
                const bool left_v = left_of(mesh, t[2], t[0], y, z, v);
                const bool left_w = left_of(mesh, t[0], t[1], y, z, w);
                if (left_u != left_v || left_v != left_w || u + v + w == 0) continue;
                const double x = (u * a.x + v * b.x + w * c.x) / (u + v + w);
                const auto enters = static_cast<std::int16_t>(left_u ? -1 : 1);
                found.push_back({first + n, {x, enters, open_cap}});
            }
        }
    }
}

void SubLines::cut_lines() {
    if (ready_) return;
    ready_ = true;
    std::vector<std::pair<std::uint32_t, Crossing>> found;
    for (const std::uint32_t* t = task_.begin; t != task_.end; ++t)
        cut_lines_by(*t, found);
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first < b.first : a.second.x < b.second.x;
    });
    constexpr std::size_t kLines = std::size_t{kBlockColumns} * kPerColumn;
    first_.assign(kLines + 1, 0);
    crossings_.reserve(found.size());
    for (const auto& [line, crossing] : found) {
        ++first_[line + 1];
        crossings_.push_back(crossing);
    }
    for (std::size_t line = 0; line < kLines; ++line)
        first_[line + 1] += first_[line];
}

void SubLines::fill_block(std::int32_t block, BlockValues& values) {
    cut_lines();
    const double x0 = kBlockSide * block;
    std::array<double, kBlockVoxels> inside{};
    const auto is_solid = [&](int winding) { return solid_ == Solid::Inside ? winding >= 1 : winding != 0; };
    for (std::size_t line = 0; line + 1 < first_.size(); ++line) {
        const std::size_t column = line / kPerColumn;
        int winding = 0;
        double begin = 0;
        for (std::uint32_t i = first_[line]; i < first_[line + 1]; ++i) {
            const Crossing& crossing = crossings_[i];
            const bool before = is_solid(winding);
            winding += crossing.enters;
            if (!before && is_solid(winding)) begin = crossing.x;
            if (!before || is_solid(winding)) continue;
            const double low = std::clamp(begin - x0, 0.0, static_cast<double>(kBlockSide));
            const double high = std::clamp(crossing.x - x0, 0.0, static_cast<double>(kBlockSide));
            for (auto x = static_cast<std::size_t>(low); static_cast<double>(x) < high; ++x) {
                const auto cell = static_cast<double>(x);
                inside[x * kBlockColumns + column] += std::min(high, cell + 1) - std::max(low, cell);
            }
        }
    }
    for (std::size_t voxel = 0; voxel < values.size(); ++voxel)
        values[voxel] = static_cast<float>(std::min(1.0, inside[voxel] / kPerColumn));
}

int SubLines::winding_at(std::size_t line, double x) const {
    int winding = 0;
    for (std::uint32_t i = first_[line]; i < first_[line + 1] && crossings_[i].x < x; ++i)
        winding += crossings_[i].enters;
    return winding;
}

float SubLines::open_fraction(int column, int x, const CapField& caps) const {
    // Every other line both ways, four points on each; the solid angle of the caps at one point of each eighth of the
    // voxel serves for all in it, unless a cap itself is near, where it jumps.
    constexpr int kStep = 2;
    constexpr int kPoints = 4;
    const int y = kBlockSide * task_.y + column / kBlockSide;
    const int z = kBlockSide * task_.z + column % kBlockSide;
    const Vec3 corner = {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    std::array<double, 8> angles{};
    for (std::size_t i = 0; i < angles.size(); ++i) {
        const auto half = [&](unsigned bit) { return (i >> bit & 1U) != 0 ? 0.75 : 0.25; };
        angles[i] = caps(corner + Vec3{half(2), half(1), half(0)});
    }
    const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
    constexpr double kJump = 0.4;
    const bool smooth = *most - *least < kJump;
    int inside = 0;
    int all = 0;
    for (int n = 0; n < kPerColumn; ++n) {
        if (n % kStep != 0 || (n / kPerSide) % kStep != 0) continue;
        const std::size_t line = static_cast<std::size_t>(column) * kPerColumn + static_cast<std::size_t>(n);
        const Place at = place(line);
        for (int point = 0; point < kPoints; ++point, ++all) {
            const double position = x + (point + 0.5) / kPoints;
            const int eighth = 4 * (point / 2) + 2 * (n / kPerSide / 4) + n % kPerSide / 4;
            const double angle = smooth ? angles[static_cast<std::size_t>(eighth)] : caps({position, at.y, at.z});
            inside += winding_at(line, position) - angle >= 0.5 ? 1 : 0;
        }
    }
    return static_cast<float>(inside) / static_cast<float>(all);
}

double SubLines::open_winding(int column, int n, double x, const CapField& caps) const {
    const std::size_t line = static_cast<std::size_t>(column) * kPerColumn + static_cast<std::size_t>(n);
    const Place at = place(line);
    return winding_at(line, x) - caps({x, at.y, at.z});
}

/// Of a voxel that no surface crosses: the winding number without caps is nearly linear in it, so eight places tell.
float SubLines::smooth_fraction(int column, int x, const CapField& caps) const {
    constexpr int kQuarter = kPerSide / 4;
    constexpr std::array<int, 2> kPlaces = {kQuarter, kPerSide - 1 - kQuarter};
    double sum = 0;
    double least = 1;
    double most = 0;
    for (const int ny : kPlaces) {
        for (const int nz : kPlaces) {
            for (const double along : {0.25, 0.75}) {
                const double winding = open_winding(column, ny * kPerSide + nz, x + along, caps);
                sum += winding / 8;
                least = std::min(least, winding);
                most = std::max(most, winding);
            }
        }
    }
    // The places span half of the voxel each way.
    const double range = std::max(2 * (most - least), 1e-6);
    return static_cast<float>(std::clamp(0.5 + (sum - 0.5) / range, 0.0, 1.0));
}

bool SubLines::crossed(int column, double x) const {
    for (int n = 0; n < kPerColumn; ++n) {
        const std::size_t line = static_cast<std::size_t>(column) * kPerColumn + static_cast<std::size_t>(n);
        for (std::uint32_t i = first_[line]; i < first_[line + 1]; ++i)
            if (!crossings_[i].open_cap && crossings_[i].x >= x && crossings_[i].x <= x + 1) return true;
    }
    return false;
}

std::uint64_t SubLines::fill_open_block(std::int32_t block, BlockValues& values) {
    cut_lines();
    fill_block(block, values);
    const CapField field(
        surface_.open_caps,
        kBlockSide * Vec3{static_cast<double>(block), static_cast<double>(task_.y), static_cast<double>(task_.z)},
        kBlockSide);
    std::uint64_t decided = 0;
    for (int voxel = 0; voxel < kBlockVoxels; ++voxel) {
        constexpr int kMiddleLine = kPerSide * (kPerSide / 2 - 1) + kPerSide / 2 - 1;
        const int column = voxel % kBlockColumns;
        const int x = kBlockSide * block + voxel / kBlockColumns;
        const std::size_t line = static_cast<std::size_t>(column) * kPerColumn + kMiddleLine;
        const Place at = place(line);
        const double caps = field({x + 0.5, at.y, at.z});
        constexpr double kMatters = 0.35;  // half, less what it can change from a voxel's centre to its corner
        if (std::abs(caps) < kMatters) continue;
        float& value = values[static_cast<std::size_t>(voxel)];
        const double winding = winding_at(line, x + 0.5) - caps;
        constexpr double kClear = 0.1;  // it changes less across a voxel that no surface crosses
        if (crossed(column, x)) {
            value = open_fraction(column, x, field);
        } else if (std::abs(winding - 0.5) > kClear) {
            value = winding >= 0.5 ? 1.0F : 0.0F;
        } else {
            value = smooth_fraction(column, x, field);
        }
        decided += value > 0 ? 1 : 0;
    }
    return decided;
}

}  // namespace fluovox
