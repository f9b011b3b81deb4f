#include "fluovox/core/text.h"
#include "fluovox/core/version.h"

#include "commands.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

namespace {

using fluovox::ExitCode;
using fluovox::tools::Command;

// In the order of a first session; each is a file of this folder.
constexpr auto kCommands = std::to_array<Command>({
    {"demo", "writes a built-in specimen and its scene", fluovox::tools::run_demo},
    {"check", "read and resolve a scene, print it with every default", fluovox::tools::run_check},
    {"render", "the image of a scene", fluovox::tools::run_render},
    {"voxelize", "meshes to a VDB grid of dye concentration", fluovox::tools::run_voxelize},
    {"info", "what is in a grid file, or in an image: its scene too", fluovox::tools::run_info},
    {"fluence", "photons from the lights: fluence, absorbed dose and the energy budget", fluovox::tools::run_fluence},
    {"dyes", "the dyes it knows, one dye's numbers and spectra, tissue", fluovox::tools::run_dyes},
    {"spectrum", "the spectral response of an image, against its dye's emission", fluovox::tools::run_spectrum},
    {"sensor", "what a camera makes of a stack: photons, electrons, noise, counts", fluovox::tools::run_sensor},
    {"diff", "are two renders the same within their noise?", fluovox::tools::run_diff},
});

void print_help() {
    std::puts("fluovox: fluorescence in scattering media, from mesh to microscope image\n\nCommands:");
    for (const Command& command : kCommands)
        std::printf("  %-10s %s\n", command.name, command.summary);
    std::puts(
        "\nEach takes --help, with examples first.\n"
        "Exit codes: 0 ok, 1 different (diff), 2 usage, 3 invalid scene, 4 bad input data, 5 output not written,\n"
        "70 internal error, 75 stopped cleanly: planes of a stack that were finished are kept, nothing else is.");
}

ExitCode run(const std::vector<std::string>& arguments) {
    const std::string name = arguments.empty() ? "--help" : arguments.front();
    if (name == "--help" || name == "-h" || name == "help") {
        print_help();
        return arguments.empty() ? ExitCode::Usage : ExitCode::Ok;
    }
    if (name == "--version") {
        std::printf("fluovox %s\n", fluovox::version());
        return ExitCode::Ok;
    }
    const auto* const command =
        std::find_if(kCommands.begin(), kCommands.end(), [&](const Command& c) { return c.name == name; });
    if (command == kCommands.end()) {
        std::vector<std::string> names;
        names.reserve(kCommands.size());
        for (const Command& known : kCommands)
            names.emplace_back(known.name);
        throw fluovox::UsageError("no command \"" + name + '"' + fluovox::did_you_mean(name, names) +
                                  " (fluovox --help lists them)");
    }
    return command->run({arguments.begin() + 1, arguments.end()});
}

// A file opened while one of them is closed would take its number, and be written to as if it were the terminal.
void open_standard_streams() {
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
        if (fcntl(stream, F_GETFD) == -1 && open("/dev/null", O_RDWR) != stream) return;
    }
}

// Results that a full disk swallowed must not pass for results.
void require_printed() {
    std::cout.flush();
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return;
    throw fluovox::OutputError("the results could not be written to the standard output (is its disk full?)");
}

}  // namespace

int main(int argc, char** argv) {
    open_standard_streams();
    try {
        const ExitCode code = run({argv + 1, argv + argc});
        require_printed();
        return static_cast<int>(code);
    } catch (const fluovox::SceneError& e) {
        std::fprintf(stderr, "%s\n", fluovox::printable(e.what()).c_str());
        return static_cast<int>(e.code());
    } catch (const fluovox::Error& e) {
        std::fprintf(stderr, "fluovox: error: %s\n", fluovox::printable(e.what()).c_str());
        return static_cast<int>(e.code());
    } catch (const std::bad_alloc&) {
        std::fputs("fluovox: error: not enough memory\n", stderr);
        return static_cast<int>(ExitCode::Input);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "fluovox: internal error: %s\n", fluovox::printable(e.what()).c_str());
        return static_cast<int>(ExitCode::Internal);
    }
}
