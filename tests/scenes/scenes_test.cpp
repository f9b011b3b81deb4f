#include "fluovox/image/compare.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/png.h"
#include "fluovox/image/preview.h"

#include "cli/run_program.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

// Every scene of volumes/ is rendered small and compared with the reference stored beside it, as `fluovox diff` does.
// volumes/make_references.sh makes the references anew, with other random numbers and more samples.

namespace fluovox::testing {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(fs::path(FLUOVOX_SOURCE_DIR) / "volumes")) {
        if (fs::exists(entry.path() / "scene.toml")) names.push_back(entry.path().filename().string());
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
    fs::path volume() const { return fs::path(FLUOVOX_SOURCE_DIR) / "volumes" / GetParam(); }

    /// The scene at 32 x 32.
    RenderedImage render() const {
        std::vector<std::string> arguments = {"render", (volume() / "scene.toml").string(), "-o", "image.exr"};
        for (const char* change : {"camera.resolution=[32,32]", "film.spectrum.bins=7", "render.samples=256"})
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

std::string test_name(const ::testing::TestParamInfo<std::string>& scene) {
    std::string name = scene.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(Volumes, SceneTest, ::testing::ValuesIn(scene_names()), test_name);

}  // namespace
}  // namespace fluovox::testing
