#include "fluovox/medium/dye_library.h"

#include "fluovox/core/csv.h"
#include "fluovox/core/text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <numbers>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

const Dye& egfp() {
    static const DyeMatch match = find_dye("EGFP").value();
    return match.dye;
}

TEST(DyeLibrary, EgfpHasItsPublishedNumbers) {
    EXPECT_EQ(egfp().id, "egfp");
    EXPECT_EQ(egfp().name, "EGFP");
    EXPECT_EQ(egfp().kind, "fluorescent protein");
    EXPECT_EQ(egfp().quantum_yield, 0.6);
    EXPECT_DOUBLE_EQ(egfp().molar_absorption_per_M_cm.max(), 55900);
    EXPECT_EQ(egfp().molar_absorption_per_M_cm.peak_nm(), 489);
    EXPECT_EQ(egfp().emission_per_nm.peak_nm(), 511);
    // 1 umol/L at the peak: ln(10) * 55900 * 1e-6 per cm.
    EXPECT_NEAR(absorption_per_um_per_uM(egfp(), 489), std::numbers::ln10 * 0.0559e-4, 1e-15);
}

TEST(DyeLibrary, EveryDyeIsCompleteAndNormalised) {
    ASSERT_EQ(dye_library().size(), 14U);
    for (const Dye& dye : dye_library()) {
        SCOPED_TRACE(dye.id);
        EXPECT_NEAR(dye.emission_per_nm.integral(), 1, 1e-12);
        EXPECT_GT(dye.quantum_yield, 0);
        EXPECT_LE(dye.quantum_yield, 1);
        EXPECT_GT(dye.molar_absorption_per_M_cm.max(), 1e4);
        EXPECT_LT(dye.molar_absorption_per_M_cm.peak_nm(), dye.emission_per_nm.peak_nm());
        EXPECT_FALSE(dye.kind.empty() || dye.source.empty() || dye.licence.empty());
        EXPECT_NE(dye.licence.find("CC BY-SA 4.0"), std::string::npos);
        EXPECT_EQ(find_dye(dye.id)->dye.id, dye.id);
        EXPECT_EQ(find_dye(dye.name)->dye.id, dye.id);
    }
}

TEST(DyeLibrary, NamesMatchWithoutCaseSpacesAndDashes) {
    for (const char* name : {"alexa488", "Alexa 488", "ALEXA-488", "Alexa Fluor 488", "alexa_fluor_488"})
        EXPECT_EQ(find_dye(name).value().dye.id, "alexa488") << name;
    EXPECT_EQ(find_dye("cy 5")->dye.id, "cy5");
    for (const char* name : {"", " ", "EGF", "alexa", "nothing"})
        EXPECT_FALSE(find_dye(name).has_value()) << name;
}

TEST(DyeLibrary, GfpAndRfpStandForTheNearestDyesAndSaySo) {
    EXPECT_EQ(find_dye("GFP")->dye.id, "egfp");
    EXPECT_FALSE(find_dye("\u00c9GFP").has_value());
    EXPECT_NE(find_dye("gfp")->remark.find("489/508 nm"), std::string::npos);
    EXPECT_EQ(find_dye("RFP")->dye.id, "dsred");
    EXPECT_NE(find_dye("RFP")->remark.find("583 nm"), std::string::npos);
    EXPECT_EQ(find_dye("EGFP")->remark, "");
}

TEST(DyeLibrary, UnknownNamesAreAnsweredWithTheClosest) {
    EXPECT_EQ(closest_dyes("EGPF").front(), "EGFP");
    EXPECT_EQ(closest_dyes("alexa480").front(), "Alexa Fluor 488");
    EXPECT_EQ(closest_dyes("xyzzyxyzzy"), std::vector<std::string>{});
    EXPECT_NE(unknown_dye_message("EGPF").find("did you mean \"EGFP\""), std::string::npos);
    EXPECT_NE(unknown_dye_message("xyzzyxyzzy").find("\"fluovox dyes\""), std::string::npos);
    EXPECT_NE(unknown_dye_message("ATTO 488").find("dyes-optional/atto488.toml"), std::string::npos);
    try {
        resolve_dye("EGPF", ".", {"scene.toml", 7, 3});
        FAIL() << "no complaint";
    } catch (const SceneError& e) {
        EXPECT_EQ(std::string(e.what()).rfind("scene.toml:7:3: error: unknown dye \"EGPF\"", 0), 0U) << e.what();
    }
}

TEST(DyeLibrary, OptionalDyesAreFilesThatLoadAndStateTheirTerms) {
    const fs::path folder = fs::path(FLUOVOX_SOURCE_DIR) / "data/dyes-optional";
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() != ".toml") continue;
        SCOPED_TRACE(entry.path());
        ++count;
        const Dye dye = resolve_dye(entry.path().filename().string(), folder, {}).dye;
        EXPECT_NEAR(dye.emission_per_nm.integral(), 1, 1e-12);
        EXPECT_NE(dye.licence.find("non-commercial"), std::string::npos);
        EXPECT_FALSE(find_dye(dye.name).has_value()) << "must not be built in";
        EXPECT_NE(unknown_dye_message(dye.id).find(entry.path().filename().string()), std::string::npos);
    }
    EXPECT_EQ(count, 30U);
}

// The measured 1 nm tables, rows "nm,excitation,emission" with blanks, against our spectra at our own knots.
void expect_equals_measured(const Dye& dye, const fs::path& file) {
    const CsvTable table = load_csv(file, 0.0);
    const auto& emission = table.column("emission");
    const double strongest = *std::max_element(emission.begin(), emission.end());
    for (std::size_t i = 0; i < table.rows(); ++i) {
        const double nm = table.columns[0][i];
        if (static_cast<int>(nm) % 2 != 0) continue;
        EXPECT_NEAR(dye.molar_absorption_per_M_cm(nm) / dye.molar_absorption_per_M_cm.max(),
                    table.column("excitation")[i], 1e-9)
            << nm;
        EXPECT_NEAR(dye.emission_per_nm(nm) / dye.emission_per_nm.max(), emission[i] / strongest, 1e-9) << nm;
    }
}

TEST(DyeLibrary, CurvesEqualTheMeasuredTablesAtTheirKnots) {
    const fs::path folder = fs::path(FLUOVOX_SHARED_DIR) / "dyes";
    if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
    for (const Dye& dye : dye_library()) {
        SCOPED_TRACE(dye.id);
        expect_equals_measured(dye, folder / (dye.id + ".csv"));
    }
    for (const char* id : {"wtgfp", "atto488", "rhodamine_b"}) {
        SCOPED_TRACE(id);
        const Dye dye = load_dye(fs::path(FLUOVOX_SOURCE_DIR) / "data/dyes-optional" / (std::string(id) + ".toml"));
        expect_equals_measured(dye, folder / (dye.id + ".csv"));
    }
}

TEST(DyeLibrary, NumbersEqualTheMeasuredTable) {
    const fs::path file = fs::path(FLUOVOX_SHARED_DIR) / "dyes/dyes.csv";
    if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
    std::ifstream stream(file);
    std::size_t seen = 0;
    for (std::string line; std::getline(stream, line);) {
        std::vector<std::string> cells(1);
        bool quoted = false;
        for (const char c : line) {
            if (c == '"') {
                quoted = !quoted;
            } else if (c == ',' && !quoted) {
                cells.emplace_back();
            } else {
                cells.back() += c;
            }
        }
        // id, ship, name, kind, extinction, excitation peak, emission peak, yield
        if (cells.size() < 8 || cells[1] != "yes") continue;
        SCOPED_TRACE(cells[0]);
        ++seen;
        const Dye dye = find_dye(cells[0]).value().dye;
        EXPECT_DOUBLE_EQ(dye.molar_absorption_per_M_cm.max(), std::stod(cells[4]));
        EXPECT_EQ(dye.molar_absorption_per_M_cm.peak_nm(), std::stod(cells[5]));
        EXPECT_EQ(dye.emission_per_nm.peak_nm(), std::stod(cells[6]));
        EXPECT_EQ(dye.quantum_yield, std::stod(cells[7]));
    }
    EXPECT_EQ(seen, dye_library().size());
}

}  // namespace
}  // namespace fluovox
