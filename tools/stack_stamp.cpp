#include "stack_stamp.h"

#include "fluovox/core/digest.h"
#include "fluovox/core/error.h"
#include "fluovox/image/png.h"
#include "fluovox/image/stack_file.h"

#include "json_or_null.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <system_error>

namespace fluovox::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::optional<double> number_in(const Json& json) {
    if (json.is_null()) return std::nullopt;
    return json.get<double>();
}

/// The files themselves, each with the name that counts: none, or that inside its folder.
std::vector<std::pair<fs::path, std::string>> files_in(const std::vector<fs::path>& paths) {
    std::vector<std::pair<fs::path, std::string>> files;
    for (const fs::path& path : paths) {
        std::error_code ignored;
        if (!fs::is_directory(path, ignored)) {
            files.emplace_back(path, "");
            continue;
        }
        for (const fs::path& file : files_of_zarr(path))
            files.emplace_back(file, file.lexically_relative(path).generic_string());
    }
    return files;
}

std::uintmax_t size_of(const fs::path& file) {
    std::error_code failure;
    const std::uintmax_t bytes = fs::file_size(file, failure);
    if (failure) throw InputError(fmt::format("{}: {}", file.string(), failure.message()));
    return bytes;
}

}  // namespace

std::string to_json(const StackStamp& stamp) {
    Json parts = Json::object();
    for (const auto& [name, content] : stamp.parts)
        parts[name] = {{"bytes", content.bytes}, {"sha256", content.digest}};
    Json planes = Json::array();
    for (const PlaneFigures& plane : stamp.planes) {
        planes.push_back({json_or_null(plane.median_relative_error), json_or_null(plane.bright_relative_error),
                          plane.max_value, plane.nan_count, plane.bound_violations, plane.is_dark});
    }
    return Json{{"key", stamp.key}, {"parts", parts}, {"planes", planes}}.dump(-1, ' ', true);
}

std::optional<StackStamp> load_stamp(const fs::path& projection) try {
    const std::optional<std::string> text = load_png_remark(projection, kStampRemark);
    if (!text) return std::nullopt;
    const Json json = Json::parse(*text);
    StackStamp stamp;
    stamp.key = json.at("key");
    for (const auto& [name, content] : json.at("parts").items())
        stamp.parts[name] = {content.at("bytes"), content.at("sha256")};
    for (const Json& plane : json.at("planes")) {
        PlaneFigures figures;
        figures.median_relative_error = number_in(plane.at(0));
        figures.bright_relative_error = number_in(plane.at(1));
        figures.max_value = plane.at(2);
        figures.nan_count = plane.at(3);
        figures.bound_violations = plane.at(4);
        figures.is_dark = plane.at(5);
        stamp.planes.push_back(figures);
    }
    return stamp;
} catch (const nlohmann::json::exception&) {
    return std::nullopt;
}

Content content_of(const std::vector<fs::path>& paths) {
    Content content;
    Digest digest;
    for (const auto& [file, name] : files_in(paths)) {
        const std::uintmax_t bytes = size_of(file);
        content.bytes += bytes;
        digest.add(fmt::format("{} {}\n", name, bytes));
        digest.add_file(file);
    }
    content.digest = digest.finish();
    return content;
}

bool still_holds(const std::vector<fs::path>& paths, const Content& written) try {
    std::uintmax_t bytes = 0;
    for (const auto& [file, name] : files_in(paths))
        bytes += size_of(file);
    return bytes == written.bytes && content_of(paths).digest == written.digest;
} catch (const InputError&) {
    return false;
} catch (const fs::filesystem_error&) {
    return false;
}

}  // namespace fluovox::tools
