// Speed and memory, as one table: what tools/bench.sh prints.

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/core/progress.h"
#include "fluovox/specimen/write_specimen.h"

#include "cases.h"
#include "measure.h"
#include "table.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace fluovox;         // NOLINT(google-build-using-namespace): a program, not a header
using namespace fluovox::bench;  // NOLINT(google-build-using-namespace)

constexpr const char* kUsage =
    "usage: fluovox_bench [--json FILE] [--only elastic|photons|neuron|fluorescence|sheet] [--write FOLDER]\n"
    "  --json FILE     also writes the figures\n"
    "  --only GROUP    only these rows\n"
    "  --write FOLDER  only writes the scenes, of all groups or of one, for `fluovox render`\n"
    "Exit codes: 0 all targets met, 1 one is missed, 2 wrong options, 5 a file could not be written.\n";

constexpr std::array<std::string_view, 5> kGroups = {"elastic", "photons", "neuron", "fluorescence", "sheet"};

struct Options {
    fs::path json, write;
    std::string only;
    bool help = false;

    bool wants(const char* group) const { return only.empty() || only == group; }
};

Options parse(const std::vector<std::string>& arguments) {
    Options options;
    for (std::size_t i = 0; i < arguments.size(); i += 2) {
        const std::string& key = arguments[i];
        if (key == "--help" || key == "-h") {
            options.help = true;
            return options;
        }
        if (key != "--json" && key != "--only" && key != "--write") throw UsageError(key + ": unknown\n" + kUsage);
        if (i + 1 == arguments.size() || arguments[i + 1].empty()) throw UsageError(key + " needs a value\n" + kUsage);
        const std::string& value = arguments[i + 1];
        if (key == "--json") options.json = value;
        if (key == "--write") options.write = value;
        if (key == "--only") options.only = value;
    }
    if (!options.only.empty() && std::find(kGroups.begin(), kGroups.end(), options.only) == kGroups.end()) {
        throw UsageError(
            fmt::format("--only {}: there is no such group; they are {}", options.only, fmt::join(kGroups, ", ")));
    }
    if (!options.json.empty() && !options.write.empty())
        throw UsageError("--write measures nothing, so that there is nothing for --json: leave one out");
    return options;
}

void make_folder(const fs::path& folder) {
    std::error_code failure;
    fs::create_directories(folder, failure);
    if (failure) {
        throw OutputError(
            fmt::format("{}: cannot be made a folder ({}); name another one", folder.string(), failure.message()));
    }
    require_writable(folder / "neuron.toml");
}

void write_demo(const char* name, const fs::path& folder) {
    make_folder(folder / name);
    measure(2, 1, [&] {
        NoProgress silent;
        write_specimen(name, (folder / name).string(), DemoSettings{}, silent);
        return Figures{};
    });
}

/// Where nothing is measured, what the groups make for themselves is written as well.
void write_all(const fs::path& folder, const Options& options) {
    make_folder(folder);
    // In processes of their own, so that memory is that of the runs alone.
    if (options.wants("neuron") || options.wants("fluorescence")) write_demo("neuron", folder);
    if (options.wants("fluorescence")) write_cuvette(folder);
    if (options.wants("sheet") && !options.write.empty()) write_demo("lightsheet-neuron", folder);
    if (!options.wants("elastic")) return;
    measure(2, 1, [&] {
        write_scenes(folder);
        std::fflush(stdout);
        return Figures{};
    });
}

bool run(const Options& options) {
    if (options.help) {
        fmt::print("{}", kUsage);
        return true;
    }
    if (!options.write.empty()) {
        if (options.only == "photons")
            throw UsageError("--write: the group photons has no files, its scene is in the bench; leave --only out");
        write_all(options.write, options);
        return true;
    }
    if (!options.json.empty()) require_writable(options.json);  // not after minutes
    const fs::path folder = fs::temp_directory_path() / fmt::format("fluovox_bench_{}", ::getpid());
    write_all(folder, options);
    Table table;
    if (options.wants("elastic")) report_elastic(folder, table);
    if (options.wants("photons")) report_photons(folder, table);
    if (options.wants("neuron") || options.wants("fluorescence")) report_neuron(folder / "neuron", table);
    if (options.wants("fluorescence")) report_fluorescence(folder, folder / "neuron", table);
    if (options.wants("sheet")) report_sheet(folder, table);
    fs::remove_all(folder);
    if (!options.json.empty()) table.save_json(options.json);
    return table.finish();
}

}  // namespace

int main(int argc, char** argv) try { return run(parse({argv + 1, argv + argc})) ? 0 : 1; } catch (const Error& e) {
    fmt::print(stderr, "bench: {}\n", e.what());
    return static_cast<int>(e.code());
} catch (const std::exception& e) {
    fmt::print(stderr, "bench: {}\n", e.what());
    return static_cast<int>(ExitCode::Internal);
}
