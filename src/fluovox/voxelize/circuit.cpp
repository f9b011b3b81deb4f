#include "fluovox/voxelize/circuit.h"

#include "fluovox/core/error.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/mesh_readers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <system_error>

namespace fluovox {
namespace {

std::string trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\"";
    const auto begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return {};
    return std::string(text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1));
}

std::vector<std::string> cells_of(std::string_view line) {
    std::vector<std::string> cells;
    for (;;) {
        const auto comma = line.find(',');
        cells.push_back(trimmed(line.substr(0, comma)));
        if (comma == std::string_view::npos) return cells;
        line.remove_prefix(comma + 1);
    }
}

constexpr std::array<std::string_view, 11> kColumns = {
    "file", "x", "y", "z", "rx", "ry", "rz", "scale", "dye", "concentration", "label"};

/// Rotation about x, then y, then z, times a scale.
std::array<Vec3, 3> rotation(double rx_deg, double ry_deg, double rz_deg, double scale) {
    const double rad = std::numbers::pi / 180;
    const double cx = std::cos(rx_deg * rad);
    const double sx = std::sin(rx_deg * rad);
    const double cy = std::cos(ry_deg * rad);
    const double sy = std::sin(ry_deg * rad);
    const double cz = std::cos(rz_deg * rad);
    const double sz = std::sin(rz_deg * rad);
    return {scale * Vec3{cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx},
            scale * Vec3{sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx}, scale * Vec3{-sy, cy * sx, cy * cx}};
}

/// One line with the names of its columns.
class Row {
public:
    Row(const std::vector<std::string>& header, std::vector<std::string> cells, std::string place)
        : header_(header), cells_(std::move(cells)), place_(std::move(place)) {
        if (cells_.size() != header_.size()) {
            fail("has " + std::to_string(cells_.size()) + " cells, and the first line names " +
                 std::to_string(header_.size()));
        }
    }

    std::string text(std::string_view column) const {
        const auto at = std::find(header_.begin(), header_.end(), column);
        return at == header_.end() ? "" : cells_[static_cast<std::size_t>(at - header_.begin())];
    }
    double number(std::string_view column, double otherwise) const {
        const std::string cell = text(column);
        if (cell.empty()) return otherwise;
        try {
            return to_number(cell, TextScanner({}, place_));
        } catch (const InputError&) {
            fail(std::string(column) + " = \"" + cell + "\" is not a number");
        }
    }
    [[noreturn]] void fail(const std::string& message) const { throw InputError(place_ + ": " + message); }

private:
    const std::vector<std::string>& header_;
    std::vector<std::string> cells_;
    std::string place_;
};

CircuitCell read_cell(const Row& row, const std::filesystem::path& folder, double um_per_unit) {
    CircuitCell cell;
    const std::string file = row.text("file");
    if (file.empty()) row.fail("names no file");
    const double scale = row.number("scale", 1);
    if (!(scale > 0)) row.fail("scale must be greater than zero");
    const double label = row.number("label", 0);
    if (label < 0 || label > 2147483647.0 || label != std::floor(label))
        row.fail("label must be a whole number above zero");
    cell.part.file = folder / file;
    // Now, and not when its turn comes after hours.
    std::error_code failure;
    if (!std::filesystem::is_regular_file(cell.part.file, failure)) {
        row.fail(cell.part.file.string() +
                 " cannot be read: no such file (its place is relative to the table's folder)");
    }
    cell.part.name = cell.part.file.string();
    cell.part.um_per_unit = um_per_unit;
    cell.part.label = static_cast<int>(label);
    cell.part.placement.rows = rotation(row.number("rx", 0), row.number("ry", 0), row.number("rz", 0), scale);
    cell.part.placement.shift_um = {row.number("x", 0), row.number("y", 0), row.number("z", 0)};
    cell.dye = row.text("dye");
    cell.concentration = row.text("concentration");
    return cell;
}

/// The names of the columns.
std::vector<std::string> read_header(std::string_view line, const std::string& place) {
    std::vector<std::string> header = cells_of(line);
    if (header.size() == 1 && line.find_first_of(";\t") != std::string_view::npos) {
        throw InputError(place + ": its columns must be separated by commas, not by " +
                         (line.find(';') != std::string_view::npos ? "semicolons" : "tabs"));
    }
    const auto unknown = std::find_if(header.begin(), header.end(), [](const std::string& name) {
        return std::find(kColumns.begin(), kColumns.end(), name) == kColumns.end();
    });
    if (unknown != header.end()) {
        throw InputError(place + ": no column \"" + *unknown +
                         "\"; there are file, x, y, z, rx, ry, rz, scale, dye, concentration, label");
    }
    return header;
}

}  // namespace

std::vector<CircuitCell> load_circuit(const std::filesystem::path& file, double um_per_unit) {
    const std::string bytes = load_bytes(file);
    std::vector<CircuitCell> cells;
    std::vector<std::string> header;
    int number = 0;
    std::string_view rest = bytes;
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
    while (!rest.empty()) {
        const auto end = rest.find('\n');
        const std::string_view line = rest.substr(0, end);
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        ++number;
        const std::string text = trimmed(line);
        if (text.empty() || text.front() == '#') continue;
        const std::string place = file.string() + ':' + std::to_string(number);
        if (header.empty()) {
            header = read_header(text, place);
            continue;
        }
        const Row row(header, cells_of(line), place);
        cells.push_back(read_cell(row, file.parent_path(), um_per_unit));
        cells.back().line = number;
        cells.back().part.place = place;
    }
    if (cells.empty()) throw InputError(file.string() + ": has no cells");
    return cells;
}

}  // namespace fluovox
