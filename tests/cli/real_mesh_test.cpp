#include "cli/run_program.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace fluovox::testing {
namespace {

// Eight spines of a cortical neuron, in nanometres, far from the origin; signed volume 5.1428593e11 nm^3.
const std::filesystem::path kSpines =
    std::filesystem::path(FLUOVOX_SHARED_DIR) / "specimens/mesh/microns_864691134884740346_spines.obj";

// The box is that of the mesh; the sheet is as thick as all of it.
const std::string kScene = R"([[medium]]
dye  = "EGFP"
grid = { file = "spines.vdb" }
[[medium]]
scattering = "10 /mm"
anisotropy = 0.9
region     = { box = { min = ["390 um", "420 um", "955 um"], max = ["432 um", "475 um", "975 um"] } }
[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["380 um", "447 um", "964.7 um"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "60 um"
thickness  = "30 um"
[camera]
position   = ["411 um", "447 um", "1100 um"]
target     = ["411 um", "447 um", "964.7 um"]
field      = "50 um"
resolution = [24, 24]
[film]
spectrum = { from = "500 nm", to = "600 nm", bins = 5 }
[render]
samples = 16
)";

class RealMesh : public ProgramTest {};

TEST_F(RealMesh, IsVoxelizedWithTheRightAmountAndIsNotBlack) {
    if (!std::filesystem::exists(kSpines)) GTEST_SKIP() << kSpines << " is not here";
    write("scene.toml", kScene);
    const auto voxelized = run({"voxelize", kSpines.string(), "-o", "spines.vdb", "--dye", "EGFP=5uM", "--voxel-size",
                                "0.1um", "--mesh-unit", "nm"});
    ASSERT_EQ(voxelized.exit_code, 0) << voxelized.err;
    const auto info = run({"info", "spines.vdb", "--json"});
    ASSERT_EQ(info.exit_code, 0) << info.err;
    const double amount_mol = nlohmann::json::parse(info.out).at("grids").at(0).at("total_mol").get<double>();
    constexpr double kLitresPerNm3 = 1e-24;
    const double expected_mol = 5e-6 * 5.1428593e11 * kLitresPerNm3;
    EXPECT_NEAR(amount_mol / expected_mol, 1, 0.003);

    const auto rendered = run({"render", "scene.toml", "-o", "spines.exr"});
    ASSERT_EQ(rendered.exit_code, 0) << rendered.err;
    EXPECT_FALSE(found("no fluorescence", rendered.err));
    const auto response = run({"spectrum", "spines.exr", "--json"});
    ASSERT_EQ(response.exit_code, 0) << response.err;
}

}  // namespace
}  // namespace fluovox::testing
