// Speed and memory, as one table: what tools/bench.sh prints.

#include "fluovox/core/progress.h"
#include "fluovox/specimen/write_specimen.h"

#include "cases.h"
#include "measure.h"
#include "table.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace fluovox;         // NOLINT(google-build-using-namespace): a program, not a header
using namespace fluovox::bench;  // NOLINT(google-build-using-namespace)

constexpr const char* kUsage =
    "usage: fluovox_bench [--json FILE] [--only elastic|photons|fluorescence|neuron|sheet] [--write FOLDER]\n"
    "  --json FILE     also writes the figures\n"
    "  --only GROUP    only these rows\n"
    "  --write FOLDER  only writes the scenes, for `fluovox render`\n";

struct Options {
    fs::path json, write;
    std::string only;
};

Options parse(const std::vector<std::string>& arguments) {
    Options options;
    for (std::size_t i = 0; i < arguments.size(); i += 2) {
        const std::string& key = arguments[i];
        if (i + 1 == arguments.size()) throw std::runtime_error(kUsage);
        if (key == "--json") {
            options.json = arguments[i + 1];
        } else if (key == "--only") {
            options.only = arguments[i + 1];
        } else if (key == "--write") {
            options.write = arguments[i + 1];
        } else {
            throw std::runtime_error(kUsage);
        }
    }
    return options;
}

void write_all(const fs::path& folder, const Options& options) {
    fs::create_directories(folder / "neuron");
    // In processes of their own, so that memory is that of the runs alone.
    measure(2, 1, [&] {
        NoProgress silent;
        write_specimen("neuron", (folder / "neuron").string(), DemoSettings{}, silent);
        return Figures{};
    });
    if (!options.only.empty() && options.only != "elastic") return;
    measure(2, 1, [&] {
        write_scenes(folder);
        std::fflush(stdout);
        return Figures{};
    });
}

bool run(const Options& options) {
    if (!options.write.empty()) {
        write_all(options.write, options);
        return true;
    }
    const fs::path folder = fs::temp_directory_path() / fmt::format("fluovox_bench_{}", ::getpid());
    write_all(folder, options);
    Table table;
    const auto wants = [&](const char* group) { return options.only.empty() || options.only == group; };
    if (wants("elastic")) report_elastic(folder, table);
    if (wants("photons")) report_photons(folder, table);
    if (wants("neuron") || wants("fluorescence")) report_neuron(folder / "neuron", table);
    if (wants("fluorescence")) report_fluorescence(folder, folder / "neuron", table);
    if (wants("sheet")) report_sheet(folder, table);
    fs::remove_all(folder);
    if (!options.json.empty()) table.save_json(options.json);
    return table.finish();
}

}  // namespace

int main(int argc, char** argv) try {
    return run(parse({argv + 1, argv + argc})) ? 0 : 1;
} catch (const std::exception& e) {
    fmt::print(stderr, "bench: {}\n", e.what());
    return 2;
}
