#include "fluovox/core/csv.h"
#include "fluovox/scene/read_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace fluovox {
namespace {

constexpr NumberRange kAnisotropy = {.min = -1, .max = 1, .without_min = true, .without_max = true};

/// The columns of a table: directions, and the value towards each.
struct PhaseColumns {
    std::size_t direction = 0, value = 1;
    bool by_angle = false;  ///< in degrees; otherwise cosines
};

PhaseColumns columns_of(const CsvTable& csv) {
    if (csv.columns.size() != 2) {
        csv.fail(
            0, fmt::format("{} columns where two are needed: angle_deg (or cosine) and the value", csv.columns.size()));
    }
    const auto angle = csv.find("angle_deg");
    const auto direction = angle ? angle : csv.find("cosine");
    if (!direction) csv.fail(0, "needs a first line that names the columns: angle_deg,value or cosine,value");
    return {*direction, 1 - *direction, angle.has_value()};
}

void check_row(const CsvTable& csv, const PhaseColumns& columns, std::size_t row) {
    const std::vector<double>& directions = csv.columns[columns.direction];
    const double given = directions[row];
    const double least = columns.by_angle ? 0 : -1;
    const double most = columns.by_angle ? 180 : 1;
    if (given < least || given > most) {
        csv.fail(row, fmt::format("{} must lie from {}", given,
                                  columns.by_angle ? "0 to 180 degrees" : "-1 to 1, being a cosine"));
    }
    if (row > 0 && !(given > directions[row - 1]))
        csv.fail(row, fmt::format("{} comes after {}: they must increase", given, directions[row - 1]));
    const double value = csv.columns[columns.value][row];
    if (value < 0) csv.fail(row, fmt::format("the value {} is negative, which no phase function is", value));
}

void require_all_directions(const CsvTable& csv, const PhaseColumns& columns) {
    const std::vector<double>& directions = csv.columns[columns.direction];
    const double least = columns.by_angle ? 0 : -1;
    const double most = columns.by_angle ? 180 : 1;
    if (directions.front() == least && directions.back() == most) return;
    csv.fail(0, fmt::format("the table reaches from {} to {}, but its integral is over all directions: {}",
                            directions.front(), directions.back(),
                            columns.by_angle ? "0 to 180 degrees" : "cosines from -1 to 1"));
}

double cosine_of_degrees(double angle) {
    if (angle == 0) return 1;
    return angle == 180 ? -1 : std::cos(angle * std::numbers::pi / 180);
}

// Rows of angle or cosine and value as cosines that increase.
PhaseTable table_of(const CsvTable& csv) {
    const PhaseColumns columns = columns_of(csv);
    for (std::size_t row = 0; row < csv.rows(); ++row)
        check_row(csv, columns, row);
    require_all_directions(csv, columns);
    std::vector<double> cosines = csv.columns[columns.direction];
    std::vector<double> values = csv.columns[columns.value];
    if (columns.by_angle) {
        std::transform(cosines.begin(), cosines.end(), cosines.begin(), cosine_of_degrees);
        std::reverse(cosines.begin(), cosines.end());
        std::reverse(values.begin(), values.end());
    }
    for (std::size_t i = 1; i < cosines.size(); ++i) {
        if (!(cosines[i] > cosines[i - 1])) csv.fail(i, "two angles are too close to tell their cosines apart");
    }
    try {
        return {std::move(cosines), std::move(values)};
    } catch (const std::invalid_argument& e) {
        csv.fail(0, fmt::format("the phase function {}", e.what()));
    }
}

PhaseTable read_phase_numbers(const SceneTable& table) {
    table.allow_only({"kind", "cosine", "value"});
    std::vector<double> cosines = table.numbers("cosine", {.min = -1, .max = 1});
    std::vector<double> values = table.numbers("value", NumberRange::not_negative());
    if (values.size() != cosines.size() || values.size() < 2)
        table.fail("value", fmt::format("has {} values for {} cosines, of two or more", values.size(), cosines.size()));
    try {
        return {std::move(cosines), std::move(values)};
    } catch (const std::invalid_argument& e) {
        table.fail(fmt::format("is no phase function: it {}", e.what()));
    }
}

PhaseTable read_phase_table(const SceneTable& table, ReadContext& context) {
    if (table.has("cosine")) return read_phase_numbers(table);
    table.allow_only({"kind", "file"});
    const std::filesystem::path path = resolve_path(table, "file", context);
    const CsvTable csv = [&] {
        try {
            return load_csv(path);
        } catch (const InputError& e) {
            throw InputError(table.place("file") + ": " + e.what());
        }
    }();
    PhaseTable phase = table_of(csv);
    constexpr double kRounding = 0.01;
    if (std::abs(phase.given_integral() - 1) > kRounding) {
        context.remarks.push_back(
            fmt::format("{}: the table integrates to {:.4g} over all directions and was scaled to 1",
                        table.path("file"), phase.given_integral()));
    }
    return phase;
}

constexpr const char* kKinds =
    "must be \"isotropic\", \"rayleigh\", { kind = \"henyey-greenstein\", g = 0.9 }, "
    "{ kind = \"two-term-henyey-greenstein\", g1 = 0.9, g2 = -0.3, weight = 0.95 } or { file = \"phase.csv\" }";

}  // namespace

PhaseFunction read_phase(const SceneTable& medium, ReadContext& context) {
    if (!medium.has("phase_function")) return HenyeyGreenstein{medium.number_or("anisotropy", 0, kAnisotropy)};
    if (medium.has("anisotropy"))
        medium.fail("anisotropy", "does not go with phase_function, which says it all: keep one of them");
    if (medium.is_text("phase_function")) {
        const std::string name = medium.text("phase_function");
        if (name == "isotropic") return HenyeyGreenstein{0};
        if (name == "rayleigh") return Rayleigh{};
        medium.fail("phase_function", kKinds);
    }
    if (!medium.is_table("phase_function")) medium.fail("phase_function", kKinds);
    const SceneTable table = medium.table("phase_function");
    if (!table.has("kind") && table.has("file")) return read_phase_table(table, context);
    if (!table.has("kind")) medium.fail("phase_function", kKinds);
    switch (
        table.choice("kind", {"isotropic", "rayleigh", "henyey-greenstein", "two-term-henyey-greenstein", "table"})) {
        case 0:
            table.allow_only({"kind"});
            return HenyeyGreenstein{0};
        case 1:
            table.allow_only({"kind"});
            return Rayleigh{};
        case 2:
            table.allow_only({"kind", "g"});
            return HenyeyGreenstein{table.number("g", kAnisotropy)};
        case 3:
            table.allow_only({"kind", "g1", "g2", "weight"});
            return TwoTermHenyeyGreenstein{table.number("g1", kAnisotropy), table.number("g2", kAnisotropy),
                                           table.number("weight", {.min = 0, .max = 1})};
        default:
            return read_phase_table(table, context);
    }
}

}  // namespace fluovox
