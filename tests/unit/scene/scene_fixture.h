#pragma once

#include "fluovox/core/error.h"
#include "fluovox/scene/scene_description.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace fluovox::testing {

/// A valid scene with most kinds of values; tests replace pieces of it.
inline const std::string kScene = R"(title = "test"
[[medium]]
dye  = "EGFP"
grid = { file = "neuron.vdb", name = "EGFP", unit = "nM", length_unit = "8 nm", scale = 2 }

[[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { box = { min = ["-5 mm", "-15 mm", "-5 mm"], max = ["5 mm", "15 mm", "5 mm"] } }

[[medium]]
scattering = "20 /mm"
absorption = "0.02 /mm"
anisotropy = 0.9
region     = "everywhere"

[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-1 mm", "250 um", "250 um"]
direction  = [2, 0, 0]
normal     = [1, 0, 1]
width      = "600 um"
thickness  = "5 um"

[camera]
kind       = "telecentric"
position   = ["250 um", "250 um", "2 mm"]
target     = ["250 um", "250 um", "250 um"]
up         = [0, 1, 0]
field      = "500 um"
resolution = [256, 128]
numerical_aperture = 0.3

[film]
spectrum = { from = "480 nm", to = "620 nm", bins = 28 }

[stack]
along = [0, 0, 1]
start = "-20 um"
stop  = "20 um"
step  = "2 um"

[render]
estimator = "auto"
samples   = 64
)";

/// `text` with the one occurrence of `from` replaced.
inline std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << "the scene has no \"" << from << '"';
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return text;
}

class SceneTest : public ::testing::Test {
public:
    SceneTest() : folder_(::testing::TempDir() + "fluovox_scene_" + std::to_string(::getpid())) {
        std::filesystem::create_directories(folder_);
    }
    ~SceneTest() override {
        std::error_code ignored;
        std::filesystem::remove_all(folder_, ignored);
    }
    SceneTest(const SceneTest&) = delete;
    SceneTest& operator=(const SceneTest&) = delete;

protected:
    const std::filesystem::path& folder() const { return folder_; }
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    SceneDescription load(const std::string& scene, const std::vector<std::string>& overrides = {}) const {
        return parse_scene_description(scene, folder_ / "scene.toml", overrides);
    }
    /// What loading the scene complains about, without the folder's name, and with the exit code in front.
    std::string complaint(const std::string& scene, const std::vector<std::string>& overrides = {}) const {
        try {
            load(scene, overrides);
        } catch (const Error& e) {
            std::string message = e.what();
            for (std::size_t at = 0; (at = message.find(folder_.string() + '/')) != std::string::npos;)
                message.erase(at, folder_.string().size() + 1);
            return std::to_string(static_cast<int>(e.code())) + ' ' + message;
        }
        return "no complaint";
    }

private:
    std::filesystem::path folder_;
};

}  // namespace fluovox::testing
