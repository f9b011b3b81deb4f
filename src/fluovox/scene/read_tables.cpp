#include "fluovox/core/csv.h"
#include "fluovox/core/text.h"
#include "fluovox/scene/read_scene.h"

#include <fmt/format.h>

#include <cstddef>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

void require_wavelengths(const CsvTable& csv) {
    const std::vector<double>& wavelengths = csv.columns[0];
    for (std::size_t row = 0; row < wavelengths.size(); ++row) {
        if (!kWavelengthRange_nm.contains(wavelengths[row])) {
            csv.fail(row, fmt::format("the wavelength {} is not in nanometres: it must lie from {} to {}",
                                      wavelengths[row], kWavelengthRange_nm.min, kWavelengthRange_nm.max));
        }
        if (row > 0 && !(wavelengths[row] > wavelengths[row - 1])) {
            csv.fail(row, fmt::format("the wavelength {} comes after {}: they must increase", wavelengths[row],
                                      wavelengths[row - 1]));
        }
    }
}

}  // namespace

Band read_band(const SceneTable& table) {
    if (table.has("center") || table.has("width")) {
        for (const char* key : {"from", "to"}) {
            if (table.has(key)) table.fail(key, "does not go with center and width: a band has either pair");
        }
        const double center = table.quantity("center", Dimension::Wavelength, kWavelengthRange_nm);
        const double width = table.quantity("width", Dimension::Wavelength, NumberRange::positive());
        const Band band = {center - 0.5 * width, center + 0.5 * width};
        if (!(band.from_nm > 0)) table.fail("width", "is too large for its center: the band would begin below 0");
        return band;
    }
    const Band band = {table.quantity("from", Dimension::Wavelength, kWavelengthRange_nm),
                       table.quantity("to", Dimension::Wavelength, kWavelengthRange_nm)};
    if (!(band.from_nm < band.to_nm)) {
        table.fail("to", fmt::format("must be above {} = \"{}\"", table.path("from"), table.text("from")));
    }
    return band;
}

std::filesystem::path resolve_path(const SceneTable& table, std::string_view key, const ReadContext& context) {
    const std::string name = table.text(key);
    if (name.empty() || name.find('\0') != std::string::npos) table.fail(key, "must be the name of a file");
    return context.folder / name;
}

Spectrum load_table(const SceneTable& table, std::string_view key, const ReadContext& context, NumberRange range,
                    std::string* file_text) {
    const std::filesystem::path path = resolve_path(table, key, context);
    std::string text;
    try {
        text = load_text(path);
    } catch (const InputError& e) {
        throw InputError(table.place(key) + ": " + e.what());
    }
    const CsvTable csv = parse_csv(text, path.string());
    if (csv.columns.size() != 2) {
        csv.fail(0, fmt::format("{} columns where two are needed: wavelength_nm and the value", csv.columns.size()));
    }
    if (csv.rows() < 2) csv.fail(0, "the table needs two rows or more");
    require_wavelengths(csv);
    for (std::size_t row = 0; row < csv.rows(); ++row) {
        const double value = csv.columns[1][row];
        if (range.contains(value)) continue;
        csv.fail(row, std::isfinite(range.max)
                          ? fmt::format("the value {} must lie from {} to {}", value, range.min, range.max)
                          : fmt::format("the value {} must be {} or more", value, range.min));
    }
    if (file_text != nullptr) *file_text = std::move(text);
    return {csv.columns[0], csv.columns[1]};
}

Spectrum read_numbers(const SceneTable& parent, NumberRange range) {
    const SceneTable table = parent.table("table");
    table.allow_only({"wavelength_nm", "value"});
    std::vector<double> wavelengths_nm = table.numbers("wavelength_nm", kWavelengthRange_nm);
    std::vector<double> values = table.numbers("value", range);
    if (wavelengths_nm.size() < 2) table.fail("wavelength_nm", "needs two wavelengths or more");
    if (values.size() != wavelengths_nm.size()) {
        table.fail("value", fmt::format("has {} values for {} wavelengths", values.size(), wavelengths_nm.size()));
    }
    for (std::size_t i = 1; i < wavelengths_nm.size(); ++i) {
        if (!(wavelengths_nm[i] > wavelengths_nm[i - 1])) table.fail("wavelength_nm", "must increase");
    }
    return {std::move(wavelengths_nm), std::move(values)};
}

}  // namespace fluovox
