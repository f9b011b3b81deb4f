#include "fluovox/medium/tissue.h"

#include "fluovox/core/csv.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace fluovox {
namespace {

TEST(Tissue, BrainScattersAsPublished) {
    const Coefficient brain = tissue_scattering("Brain").value();
    EXPECT_NEAR(coefficient_per_um(brain, 400), 34.7e-4, 0.05e-4);  // Jacques 2013
    EXPECT_NEAR(coefficient_per_um(brain, 500), 24.2e-4, 1e-9);
    EXPECT_NEAR(coefficient_per_um(brain, 700), 14.1e-4, 0.05e-4);
    EXPECT_FALSE(tissue_scattering("cheese").has_value());
    const Coefficient scattering = scattering_from_reduced(*tissue_scattering("brain"), 0.9);
    EXPECT_NEAR(coefficient_per_um(scattering, 500), 242e-4, 1e-9);
}

TEST(Tissue, WaterAndBloodAbsorbAsTabulated) {
    EXPECT_NEAR(water_absorption_per_um(700), 0.00605e-4, 1e-9);
    EXPECT_NEAR(water_absorption_per_um(972), 0.4518e-4, 1e-8);
    EXPECT_EQ(water_absorption_per_um(200), 0);
    EXPECT_NEAR(water_refractive_index(500), 1.3368, 1e-4);
    EXPECT_GT(water_refractive_index(200), 1.35);
    EXPECT_EQ(oxyhaemoglobin_per_M_cm()(250), 106112);
    // ln(10) * 106112 * 150 / 64500 per cm
    EXPECT_NEAR(blood_absorption_per_um(250, 1), 568.2e-4, 0.1e-4);
    EXPECT_NEAR(blood_absorption_per_um(250, 0, 75), 301.9e-4, 0.1e-4);
}

TEST(Tissue, TablesEqualTheMeasuredOnes) {
    const std::filesystem::path folder = std::filesystem::path(FLUOVOX_SHARED_DIR) / "optics";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
    const CsvTable blood = load_csv(folder / "hemoglobin.csv");
    for (std::size_t i = 0; i < blood.rows(); ++i) {
        EXPECT_EQ(oxyhaemoglobin_per_M_cm()(blood.columns[0][i]), blood.columns[1][i]);
        EXPECT_EQ(deoxyhaemoglobin_per_M_cm()(blood.columns[0][i]), blood.columns[2][i]);
    }
    const CsvTable water = load_csv(folder / "water.csv", 0.0);
    for (std::size_t i = 0; i < water.rows(); i += 2) {  // ours is every 4 nm, this every 2 nm
        const double nm = water.columns[0][i];
        EXPECT_NEAR(water_absorption_per_um(nm) * 1e4, water.column("mua_cm-1_Segelstein1981")[i], 1e-12) << nm;
        EXPECT_NEAR(water_refractive_index(nm), water.column("n_Daimon2007_20C")[i], 1e-12) << nm;
    }
    const CsvTable cortex = load_csv(folder / "brain_musp_hillman.csv");
    for (std::size_t i = 0; i < cortex.rows(); ++i) {
        const double law = coefficient_per_um(tissue_scattering("cortex").value(), cortex.columns[0][i]) * 1e4;
        EXPECT_NEAR(law / cortex.columns[1][i], 1, 0.04);
    }
}

}  // namespace
}  // namespace fluovox
