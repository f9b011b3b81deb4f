#include "fluovox/medium/dye_file.h"

#include "fluovox/core/error.h"
#include "fluovox/core/quantity.h"
#include "fluovox/core/text.h"
#include "fluovox/medium/dye_library.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace fluovox {
namespace {

const std::vector<std::string>& known_keys() {
    static const std::vector<std::string> keys = {"name",        "kind",   "quantum_yield", "extinction", "spectra",
                                                  "emission_is", "source", "licence",       "note"};
    return keys;
}

/// One table of a dye file; every complaint points at the value or the key it is about.
class DyeTable {
public:
    DyeTable(const toml::table& table, const std::string& file) : table_(table), file_(file) { refuse_unknown_keys(); }

    std::string text(std::string_view key) const {
        const toml::node* node = table_.get(key);
        if (node == nullptr) fail(key, "is missing; a text is needed");
        const auto value = node->value<std::string>();
        if (!node->is_string() || !value) fail(key, "must be a text in quotes");
        if (value->empty()) fail(key, "is empty");
        return *value;
    }
    std::string text_or(std::string_view key, const std::string& fallback) const {
        return table_.contains(key) ? text(key) : fallback;
    }
    double quantum_yield() const {
        const toml::node* node = table_.get("quantum_yield");
        if (node == nullptr) fail("quantum_yield", "is missing; a number from 0 to 1 is needed");
        const auto value = node->value<double>();
        if (!node->is_number() || !value) fail("quantum_yield", "must be a number from 0 to 1");
        if (!(*value >= 0 && *value <= 1)) fail("quantum_yield", fmt::format("is {}, but must be from 0 to 1", *value));
        return *value;
    }
    double extinction_per_M_cm() const {
        const toml::node* node = table_.get("extinction");
        if (node != nullptr && node->is_number()) {
            fail("extinction", fmt::format("= {} needs a unit, for example \"{}\"", node->value_or(0.0),
                                           example_quantity(Dimension::Extinction, node->value_or(0.0))));
        }
        double value = 0;
        try {
            value = parse_quantity(text("extinction"), Dimension::Extinction);
        } catch (const std::invalid_argument& e) {
            fail("extinction", std::string(": ") + e.what());
        }
        if (!(value > 0)) fail("extinction", fmt::format("is {} /M/cm, but must be above 0", value));
        return value;
    }
    bool emission_is_energy() const {
        const std::string value = text_or("emission_is", "photons");
        if (value == "energy") return true;
        if (value == "photons") return false;
        fail("emission_is", fmt::format(R"(is "{}", but must be "photons" or "energy")", value));
    }
    SourceLocation place(std::string_view key) const {
        const toml::node* node = table_.get(key);
        return location(node != nullptr ? node->source() : table_.source());
    }
    [[noreturn]] void fail(std::string_view key, const std::string& message) const {
        const std::string space = message.front() == ':' ? "" : " ";
        throw SceneError(place(key), std::string(key) + space + message);
    }

private:
    void refuse_unknown_keys() const {
        for (const auto& [key, value] : table_) {
            const std::string name(key.str());
            const auto& known = known_keys();
            if (std::find(known.begin(), known.end(), name) != known.end()) continue;
            const std::string hint = did_you_mean(name, known);
            std::string all;
            for (const std::string& each : known)
                all += (all.empty() ? "" : ", ") + each;
            throw SceneError(
                location(key.source()),
                fmt::format("unknown key \"{}\"{}", name, hint.empty() ? " (a dye file has: " + all + ")" : hint));
        }
    }
    SourceLocation location(const toml::source_region& region) const {
        // The table of a whole file has no place of its own.
        return {file_, std::max(1, static_cast<int>(region.begin.line)),
                std::max(1, static_cast<int>(region.begin.column))};
    }

    const toml::table& table_;
    const std::string& file_;
};

toml::table parse_toml(std::string_view text, const std::string& file) try {
    if (const int line = line_of_deep_key(text); line > 0)
        throw SceneError({file, line, 1}, "a key with more than 256 dots");
    return toml::parse(text, file);
} catch (const toml::parse_error& e) {
    const auto& begin = e.source().begin;
    throw SceneError({file, static_cast<int>(begin.line), static_cast<int>(begin.column)},
                     std::string(e.description()));
}

void check_wavelengths(const CsvTable& table, const std::vector<double>& wavelengths_nm) {
    if (table.rows() < 2) table.fail(0, "a dye needs at least two wavelengths");
    for (std::size_t i = 0; i < wavelengths_nm.size(); ++i) {
        const double nm = wavelengths_nm[i];
        if (nm < 100 || nm > 10000)
            table.fail(i, fmt::format("wavelength_nm is {}, but must be from 100 to 10000", nm));
        if (i > 0 && !(nm > wavelengths_nm[i - 1])) {
            table.fail(i, fmt::format("wavelength_nm must increase, but {} follows {}", nm, wavelengths_nm[i - 1]));
        }
    }
}

// The scale of a column is free, but its numbers must survive being divided by their largest.
constexpr double kLargest = 1e30;
constexpr double kLeast = 1e-30;

/// A column as a spectrum, without the zeros beyond its ends but for one on each side.
Spectrum curve(const CsvTable& table, const char* name) {
    const std::vector<double>& nm = table.column("wavelength_nm");
    const std::vector<double>& values = table.column(name);
    std::size_t first = values.size();
    std::size_t last = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] < 0) table.fail(i, fmt::format("{} is {}, but must not be negative", name, values[i]));
        if (values[i] > kLargest) table.fail(i, fmt::format("{} is {}, above any scale", name, values[i]));
        if (values[i] < kLeast) continue;
        first = std::min(first, i);
        last = i;
    }
    if (first > last) table.fail(0, fmt::format("{} is zero at every wavelength", name));
    first = first > 0 ? first - 1 : first;
    last = std::min(last + 1, values.size() - 1);
    const auto from = static_cast<std::ptrdiff_t>(first);
    const auto to = static_cast<std::ptrdiff_t>(last + 1);
    return {{nm.begin() + from, nm.begin() + to}, {values.begin() + from, values.begin() + to}};
}

Spectrum times_wavelength(const Spectrum& spectrum) {
    std::vector<double> values = spectrum.values();
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] *= spectrum.wavelengths_nm()[i];
    return {spectrum.wavelengths_nm(), std::move(values)};
}

Dye make_dye(const DyeTable& table, const LoadCurves& load_curves) {
    Dye dye;
    dye.name = table.text("name");
    dye.kind = table.text_or("kind", "");
    dye.quantum_yield = table.quantum_yield();
    dye.source = table.text_or("source", "");
    dye.licence = table.text_or("licence", "");
    dye.note = table.text_or("note", "");
    const double extinction = table.extinction_per_M_cm();
    const bool is_energy = table.emission_is_energy();
    const std::string spectra = table.text("spectra");
    const CsvTable curves = [&] {
        try {
            return load_curves(spectra);
        } catch (const InputError& e) {
            const SourceLocation where = table.place("spectra");
            throw InputError(fmt::format("{}:{}:{}: spectra: {}", where.file, where.line, where.column, e.what()));
        }
    }();
    check_wavelengths(curves, curves.column("wavelength_nm"));
    const Spectrum excitation = curve(curves, "excitation");
    const Spectrum emission = curve(curves, "emission");
    // Photons per nm are energy per nm divided by h c / lambda.
    const Spectrum photons = is_energy ? times_wavelength(emission) : emission;
    dye.molar_absorption_per_M_cm = excitation.scaled(1 / excitation.max()).scaled(extinction);
    dye.emission_per_nm = photons.scaled(1 / photons.max());
    dye.emission_per_nm = dye.emission_per_nm.scaled(1 / dye.emission_per_nm.integral());
    return dye;
}

}  // namespace

Dye parse_dye(std::string_view toml, const std::string& file, const LoadCurves& load_curves) {
    const toml::table root = parse_toml(toml, file);
    if (root.empty()) throw SceneError({file, 1, 1}, "the dye file is empty");
    return make_dye(DyeTable(root, file), load_curves);
}

std::vector<Dye> parse_dye_library(std::string_view toml, const std::string& file, const LoadCurves& load_curves) {
    const toml::table root = parse_toml(toml, file);
    std::vector<std::pair<int, std::string>> order;  // toml++ keeps its keys sorted, so the text's order is by line
    for (const auto& [key, value] : root)
        order.emplace_back(static_cast<int>(key.source().begin.line), key.str());
    std::sort(order.begin(), order.end());
    std::vector<Dye> dyes;
    for (const auto& [line, id] : order) {
        const toml::table* table = root.get_as<toml::table>(id);
        if (table == nullptr) throw SceneError({file, line, 1}, "a table of a dye is needed");
        dyes.push_back(make_dye(DyeTable(*table, file), load_curves));
        dyes.back().id = id;
    }
    return dyes;
}

Dye load_dye(const std::filesystem::path& file) {
    const auto load_curves = [&](const std::string& name) { return load_csv(file.parent_path() / name, 0.0); };
    Dye dye = parse_dye(load_text(file), file.string(), load_curves);
    dye.id = lower_case(file.stem().string());
    return dye;
}

}  // namespace fluovox
