#include "fluovox/medium/tissue.h"

#include "fluovox/core/csv.h"
#include "fluovox/core/embedded_text.h"
#include "fluovox/core/text.h"

#include <algorithm>
#include <numbers>

namespace fluovox {
namespace {

constexpr double kPerUm_per_cm = 1e-4;

struct Water {
    Spectrum absorption_per_cm, refractive_index;
};

const Water& water() {
    static const Water table = [] {
        constexpr const char* kTable = "medium/data/water.csv";
        const CsvTable csv = parse_csv(embedded_text(kTable), kTable);
        const auto& nm = csv.column("wavelength_nm");
        return Water{{nm, csv.column("absorption_per_cm")}, {nm, csv.column("refractive_index")}};
    }();
    return table;
}

struct Haemoglobin {
    Spectrum oxygenated, deoxygenated;
};

const Haemoglobin& haemoglobin() {
    static const Haemoglobin table = [] {
        constexpr const char* kTable = "medium/data/haemoglobin.csv";
        const CsvTable csv = parse_csv(embedded_text(kTable), kTable);
        const auto& nm = csv.column("wavelength_nm");
        return Haemoglobin{{nm, csv.column("oxygenated")}, {nm, csv.column("deoxygenated")}};
    }();
    return table;
}

}  // namespace

double water_absorption_per_um(double wavelength_nm) {
    return kPerUm_per_cm * water().absorption_per_cm(wavelength_nm);
}

double water_refractive_index(double wavelength_nm) {
    const Spectrum& index = water().refractive_index;
    return index(std::clamp(wavelength_nm, index.first_nm(), index.last_nm()));
}

const Spectrum& oxyhaemoglobin_per_M_cm() {
    return haemoglobin().oxygenated;
}

const Spectrum& deoxyhaemoglobin_per_M_cm() {
    return haemoglobin().deoxygenated;
}

double blood_absorption_per_um(double wavelength_nm, double saturation, double haemoglobin_g_per_L) {
    constexpr double kTetramer_g_per_mol = 64500;
    const double extinction_per_M_cm = saturation * oxyhaemoglobin_per_M_cm()(wavelength_nm) +
                                       (1 - saturation) * deoxyhaemoglobin_per_M_cm()(wavelength_nm);
    return kPerUm_per_cm * std::numbers::ln10 * extinction_per_M_cm * haemoglobin_g_per_L / kTetramer_g_per_mol;
}

const std::vector<TissueScattering>& tissues() {
    static const std::vector<TissueScattering> table = {
        {"brain",
         {.at_nm = 500, .value_per_um = 24.2 * kPerUm_per_cm, .exponent = -1.611},
         "Jacques, Phys. Med. Biol. 58 (2013) R37, table 2: mean of 8 studies"},
        {"cortex",
         {.at_nm = 500, .value_per_um = 40 * kPerUm_per_cm, .exponent = -1.16},
         "mouse, in vivo imaging: table of the Hillman laboratory in BauerLabCodebase/CodeforBiceElife2022 "
         "(Apache-2.0), "
         "510 to 997 nm, fitted within 4 %"},
        {"skin",
         {.at_nm = 500, .value_per_um = 46.0 * kPerUm_per_cm, .exponent = -1.421},
         "Jacques, Phys. Med. Biol. 58 (2013) R37, table 2: mean"},
    };
    return table;
}

std::optional<PowerLaw> tissue_scattering(std::string_view name) {
    for (const TissueScattering& tissue : tissues()) {
        if (lower_case(name) == tissue.name) return tissue.reduced;
    }
    return {};
}

PowerLaw scattering_from_reduced(const PowerLaw& reduced, double g) {
    return {reduced.at_nm, reduced.value_per_um / (1 - g), reduced.exponent};
}

}  // namespace fluovox
