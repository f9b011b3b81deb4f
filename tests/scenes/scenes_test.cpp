#include "fluovox/core/text.h"
#include "fluovox/image/compare.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/png.h"
#include "fluovox/image/preview.h"
#include "fluovox/image/response.h"
#include "fluovox/medium/dye_library.h"

#include "cli/run_program.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

// Every scene of volumes/ is rendered small and compared with the reference stored beside it, as `fluovox diff` does.
// volumes/make_references.sh makes the references anew, with other random numbers and more samples.

namespace fluovox::testing {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(fs::path(FLUOVOX_SOURCE_DIR) / "volumes")) {
        const fs::path scene = entry.path() / "scene.toml";
        // Stacks have tests of their own.
        if (fs::exists(scene) && load_text(scene).find("[stack]") == std::string::npos)
            names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

/// What `image` would be with all lights at `factor` times their power.
RenderedImage dimmed(RenderedImage image, double factor) {
    for (float& mean : image.means)
        mean *= static_cast<float>(factor);
    image.variance_unit *= factor;
    return image;
}

class SceneTest : public ProgramTest, public ::testing::WithParamInterface<std::string> {
protected:
    static fs::path volume() { return fs::path(FLUOVOX_SOURCE_DIR) / "volumes" / GetParam(); }

    /// The scene at 32 x 32.
    RenderedImage render() const {
        std::vector<std::string> arguments = {"render", (volume() / "scene.toml").string(), "-o", "image.exr"};
        // Haze around the neuron: its pixels share photons, and with fewer a fifth of the light is within the noise.
        const std::string samples = GetParam() == "neuron" ? "512" : "256";
        for (const std::string& change : {std::string("camera.resolution=[32,32]"), std::string("film.spectrum.bins=7"),
                                          "render.samples=" + samples})
            arguments.insert(arguments.end(), {"--set", change});
        const ProgramResult result = run(arguments, {.seconds = 300, .max_file_bytes = {}});
        EXPECT_EQ(result.exit_code, 0) << result.command << '\n' << result.err;
        return load_exr(folder() / "image.exr");
    }

    /// Keeps what is needed to see why two images differ.
    void keep_evidence(const RenderedImage& image, const Comparison& found) const {
        const fs::path kept = fs::path(FLUOVOX_FAILED_SCENES) / GetParam();
        fs::create_directories(kept);
        fs::copy_file(folder() / "image.exr", kept / "image.exr", fs::copy_options::overwrite_existing);
        save_preview(kept / "image.png", make_preview(image));
        save_png(kept / "difference.png", difference_picture(found, image.width, image.height));
        save_png(kept / "p_values.png", p_value_picture(found, image.width, image.height));
        ADD_FAILURE() << "image, difference and p-values are in " << kept;
    }
};

TEST_P(SceneTest, LooksLikeItsReference) {
    const RenderedImage reference = load_exr(volume() / "reference.exr");
    const RenderedImage image = render();
    EXPECT_EQ(image.nan_count, 0);
    EXPECT_EQ(image.bound_violations, 0);
    const Comparison found = compare(image, reference);
    EXPECT_GT(found.mean_a, 0) << "the picture is black";
    // The twin that must fail: a fifth less light.
    EXPECT_FALSE(compare(image, dimmed(reference, 0.8)).same) << "this test would not see a fifth less light";
    if (!found.same) {
        EXPECT_TRUE(found.same) << "p = " << found.p_value << ", " << found.differing << " pixels differ, most at "
                                << found.where << "; means " << found.mean_a << " and " << found.mean_b;
        keep_evidence(image, found);
    }
}

TEST_F(ProgramTest, TheSceneThatTheReadmeExplainsIsAccepted) {
    const std::string readme = load_text(FLUOVOX_SOURCE_DIR "/README.md");
    const std::string opening = "```toml\n";
    const std::size_t begin = readme.find(opening) + opening.size();
    write("scene.toml", readme.substr(begin, readme.find("```", begin) - begin));
    fs::copy_file(FLUOVOX_SOURCE_DIR "/volumes/neuron/neuron.vdb", folder() / "neuron.vdb");
    const ProgramResult result = run({"check", "scene.toml"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_TRUE(found("sheet at \\(-300, 38, 0\\) um", result.out)) << result.out;
}

// Thin beads in an even sheet of light: what the camera sees can be worked out by hand (volumes/beads/README.md).
TEST_F(ProgramTest, BeadsShineAsBrightAsTheirAmountOfDyeSays) {
    const std::string scene = FLUOVOX_SOURCE_DIR "/volumes/beads/scene.toml";
    const ProgramResult result = run({"render", scene, "-o", "beads.exr"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const RenderedImage image = load_exr(folder() / "beads.exr");
    const SpectralResponse response =
        mean_response(image, image.layer("fluorescence"), {0, 0, image.width, image.height});
    constexpr double kBin_nm = 10;
    const double radiance = kBin_nm * response.sum;  // photons s^-1 m^-2 sr^-1
    const double error = kBin_nm * response.standard_error_of_sum;
    const Dye egfp = find_dye("EGFP")->dye;
    constexpr double kPhoton_J = 6.62607015e-34 * 2.99792458e8 / 488e-9;
    const double photons_per_s_m2 = 1e-3 / (200e-6 * 200e-6) / kPhoton_J;
    const double absorption_per_m = 1e6 * 50 * absorption_per_um_per_uM(egfp, 488);
    const double volume_m3 = 27 * std::numbers::pi / 6 * 1e-15;
    const double per_sr = photons_per_s_m2 * absorption_per_m * volume_m3 * egfp.quantum_yield / (4 * std::numbers::pi);
    // On its way the light passes 3.75 um of its own bead and 7.5 um of the one before it, on average.
    const double inner_filter = 1 - absorption_per_m * 11.25e-6;
    const double expected = inner_filter * per_sr / (160e-6 * 160e-6);
    EXPECT_NEAR(radiance / expected, 1, 0.01);
    EXPECT_LT(error / radiance, 0.002) << "too noisy to tell";
}

std::string test_name(const ::testing::TestParamInfo<std::string>& scene) {
    std::string name = scene.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(Volumes, SceneTest, ::testing::ValuesIn(scene_names()), test_name);

}  // namespace
}  // namespace fluovox::testing
