#include "fluovox/image/plane_store.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/core/text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kHeader = 512;  // bytes of JSON and spaces before the values
constexpr const char* kKeyFile = "stack.key";
constexpr const char* kLockFile = "lock";

// JSON has no number for what is not known: null.
nlohmann::json json_of(std::optional<double> value) {
    return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

std::optional<double> number_in(const nlohmann::json& json, const char* key) {
    const nlohmann::json& value = json.at(key);
    if (value.is_null()) return std::nullopt;
    return value.get<double>();
}

/// Of two runs that shared a folder, each would take away what the other works with.
FileLock make_and_lock(const fs::path& folder) {
    std::error_code failure;
    fs::create_directory(folder, failure);
    if (!fs::is_directory(folder, failure)) {
        require_writable(folder);
        throw OutputError(fmt::format("{}: cannot be made a folder", folder.string()));
    }
    try {
        if (std::optional<FileLock> lock = FileLock::take(folder / kLockFile)) return std::move(*lock);
    } catch (const OutputError&) {
        if (fs::is_directory(folder, failure)) throw;
        return make_and_lock(folder);  // another run has ended and taken its folder away just now
    }
    throw OutputError(
        fmt::format("{}: another run is at work on this stack: wait until it ends, stop it (what it has finished is "
                    "kept), or choose another -o",
                    folder.string()));
}

std::vector<fs::path> entries_but_lock(const fs::path& folder) {
    std::vector<fs::path> entries;
    std::error_code failure;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, failure)) {
        if (entry.path().filename() != kLockFile) entries.push_back(entry.path());
    }
    return entries;
}

}  // namespace

PlaneStore::PlaneStore(const fs::path& folder, const std::string& key, std::size_t values_per_plane, bool overwrite)
    : folder_(folder), lock_(make_and_lock(folder)), values_per_plane_(values_per_plane) {
    std::error_code failure;
    const fs::path key_file = folder / kKeyFile;
    if (fs::is_regular_file(key_file, failure) && load_text(key_file) == key) return;
    const std::vector<fs::path> others = entries_but_lock(folder);
    if (!others.empty() && !overwrite) {
        throw UsageError(
            fmt::format("{} holds planes of other work (another scene, seed, version or format): "
                        "remove it, choose another -o, or add --overwrite",
                        folder.string()));
    }
    for (const fs::path& other : others)
        fs::remove_all(other, failure);
    write_text_file(key_file, key);
}

fs::path PlaneStore::file_of(int plane) const {
    return folder_ / fmt::format("{:05}.plane", plane);
}

bool PlaneStore::has(int plane) const {
    std::error_code failure;
    const auto size = fs::file_size(file_of(plane), failure);
    return !failure && size == kHeader + values_per_plane_ * sizeof(float);
}

void PlaneStore::save(int plane, std::span<const float> values, const PlaneFigures& figures) const {
    const nlohmann::json json = {{"median_relative_error", json_of(figures.median_relative_error)},
                                 {"bright_relative_error", json_of(figures.bright_relative_error)},
                                 {"max_value", figures.max_value},
                                 {"seconds", json_of(figures.seconds)},
                                 {"nan_count", figures.nan_count},
                                 {"bound_violations", figures.bound_violations},
                                 {"is_dark", figures.is_dark}};
    std::string header = json.dump();
    header.resize(kHeader, ' ');
    write_atomically(file_of(plane), [&](const fs::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out.write(header.data(), static_cast<std::streamsize>(header.size()));
        out.write(reinterpret_cast<const char*>(values.data()),  // NOLINT(*-reinterpret-cast): bytes
                  static_cast<std::streamsize>(values.size_bytes()));
        out.close();
        if (!out) throw OutputError(fmt::format("{}: {}", file_of(plane).string(), std::strerror(errno)));
    });
}

PlaneFigures PlaneStore::figures(int plane) const try {
    std::string header(kHeader, ' ');
    std::ifstream in(file_of(plane), std::ios::binary);
    in.read(header.data(), static_cast<std::streamsize>(header.size()));
    const auto json = nlohmann::json::parse(header);
    return {number_in(json, "median_relative_error"),
            number_in(json, "bright_relative_error"),
            json.at("max_value"),
            number_in(json, "seconds"),
            json.at("nan_count"),
            json.at("bound_violations"),
            json.at("is_dark")};
} catch (const nlohmann::json::exception&) {
    throw InputError(fmt::format("{}: is damaged: remove it and run again", file_of(plane).string()));
}

void PlaneStore::load(int plane, std::size_t first, std::span<float> values) const {
    std::ifstream in(file_of(plane), std::ios::binary);
    in.seekg(static_cast<std::streamoff>(kHeader + first * sizeof(float)));
    in.read(reinterpret_cast<char*>(values.data()),  // NOLINT(*-reinterpret-cast): bytes
            static_cast<std::streamsize>(values.size_bytes()));
    if (!in) throw InputError(fmt::format("{}: is damaged: remove it and run again", file_of(plane).string()));
}

void PlaneStore::remove() const {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

double PlaneStore::plane_bytes() const {
    return static_cast<double>(kHeader + values_per_plane_ * sizeof(float));
}

}  // namespace fluovox
