#pragma once

// A small scene with a [stack], and readers of what the program makes of it.

#include "cli/run_program.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace fluovox::testing {

// Two dyes, a laser line for each, a little scattering; seven planes.
inline const std::string kStackScene = R"(title = "two <balls> & µ"
[[medium]]
dye           = "EGFP"
concentration = "10 uM"
region        = { sphere = { center = ["0 um", "0 um", "0 um"], radius = "30 um" } }
[[medium]]
dye           = "mCherry"
concentration = "10 uM"
region        = { sphere = { center = ["40 um", "20 um", "10 um"], radius = "20 um" } }
[[medium]]
scattering = "2 /mm"
anisotropy = 0.9
region     = { box = { min = ["-100 um", "-100 um", "-100 um"], max = ["100 um", "100 um", "100 um"] } }
[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-1 mm", "0 um", "0 um"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "300 um"
thickness  = "5 um"
[[light]]
kind       = "sheet"
wavelength = "561 nm"
power      = "1 mW"
position   = ["-1 mm", "0 um", "0 um"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "300 um"
thickness  = "5 um"
[camera]
position   = ["0 um", "0 um", "2 mm"]
target     = ["0 um", "0 um", "0 um"]
field      = "144 um"
resolution = [14, 12]
numerical_aperture = 0.3
exposure   = "20 ms"
[[film.channel]]
name = "green"
band = { center = "525 nm", width = "50 nm" }
[[film.channel]]
name = "red"
band = { center = "610 nm", width = "50 nm" }
[stack]
along = [0, 0, 1]
start = "-30 um"
stop  = "30 um"
step  = "10 um"
[render]
estimator = "path"
samples = 16
)";

class StackTest : public ProgramTest {
protected:
    StackTest() { write("scene.toml", kStackScene); }

    void write_changed(const std::string& name, const std::string& from, const std::string& to) const {
        std::string text = kStackScene;
        const std::size_t at = text.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        write(name, text.replace(at, from.size(), to));
    }
    /// Runs a shell command in the folder; what it prints (both streams), and fails the test where it fails.
    std::string shell(const std::string& command) const {
        const std::string all = "cd '" + folder().string() + "' && ( " + command + " ) > said.txt 2>&1";
        const int status = std::system(all.c_str());  // NOLINT(cert-env33-c, concurrency-mt-unsafe): other readers
        EXPECT_EQ(status, 0) << command << '\n' << read("said.txt");
        return read("said.txt");
    }
    std::string python(const std::string& arguments) const {
        return shell("/usr/bin/python3 " FLUOVOX_SOURCE_DIR "/tests/cli/read_stack.py " + arguments);
    }
    std::string imagej(const std::string& file) const {
        return shell(
            "java -Djava.awt.headless=true -cp /usr/share/java/ij.jar:/usr/share/java/bsh.jar "
            "bsh.Interpreter " FLUOVOX_SOURCE_DIR "/tests/cli/read_stack.bsh " +
            file);
    }
    std::size_t planes_there(const std::string& name) const {
        std::size_t count = 0;
        std::error_code gone;
        for (const auto& entry : std::filesystem::directory_iterator(folder() / (name + ".planes"), gone)) {
            const std::string file = entry.path().filename().string();
            count += entry.path().extension() == ".plane" && file.front() != '.' ? 1 : 0;
        }
        return count;
    }
    static bool has_imagej() {
        return std::filesystem::exists("/usr/share/java/ij.jar") &&
               std::filesystem::exists("/usr/share/java/bsh.jar") && std::filesystem::exists("/usr/bin/java");
    }
    static bool has_readers() {
        return std::filesystem::exists("/usr/bin/python3") && std::filesystem::exists("/usr/bin/xmllint");
    }
};

}  // namespace fluovox::testing
