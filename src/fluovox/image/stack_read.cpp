#include "fluovox/image/stack_read.h"

#include "fluovox/core/error.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/stack_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>

namespace fluovox {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

[[noreturn]] void fail(const fs::path& path, const std::string& why) {
    throw InputError(fmt::format("{}: {}", path.string(), why));
}

bool starts_as_tiff(const fs::path& file) {
    std::array<char, 4> start{};
    std::ifstream(file, std::ios::binary).read(start.data(), start.size());
    const std::string_view seen(start.data(), start.size());
    using namespace std::string_view_literals;
    const auto marks = {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv};
    return std::find(marks.begin(), marks.end(), seen) != marks.end();
}

/// What a plane's name has before `exr_plane_ending`; for any other name of an .exr, the name without its ending.
std::optional<fs::path> exr_stem(const fs::path& path) {
    if (path.extension() != ".exr") return std::nullopt;
    std::string stem = path.stem().string();
    const std::size_t end = stem.find_last_not_of("0123456789");
    constexpr std::size_t kDigits = 4;
    if (end != std::string::npos && end > 0 && stem[end] == '-' && stem.size() - end > kDigits) stem.resize(end);
    return path.parent_path() / stem;
}

/// The planes of a stack as they lie in their files, the last one that was asked for in memory.
class ExrPlanes {
public:
    explicit ExrPlanes(fs::path stem) : stem_(std::move(stem)) {
        const Json note = load(0);
        info_ = checked_stack_info(note.at("stack").dump(), file(0));
        info_.scene_json = note.at("scene");
    }

    const StackInfo& info() const { return info_; }

    void read(int plane, int channel, std::span<float> values) {
        if (plane != plane_) {
            const Json note = load(plane);
            const StackInfo here = checked_stack_info(note.at("stack").dump(), file(plane));
            if (to_json(here) != to_json(info_)) fail(file(plane), "is of another stack than " + file(0).string());
        }
        const std::span<const float> mean = image_.mean_plane(0, channel);
        std::copy(mean.begin(), mean.end(), values.begin());
    }

private:
    fs::path file(int plane) const { return stem_.string() + exr_plane_ending(plane); }

    Json load(int plane) {
        image_ = load_exr(file(plane));
        plane_ = plane;
        Json note = Json::parse(image_.provenance.stack_note, nullptr, false);
        if (!note.is_object() || !note.contains("stack") || !note.contains("scene") || !note.contains("plane"))
            fail(file(plane), "is an image of its own, or of an earlier version, and no plane of a stack");
        if (note.at("plane") != plane) fail(file(plane), "is another plane of its stack than its name says");
        const Json& size = note.at("stack").at("size");
        if (size.at(0) != image_.width || size.at(1) != image_.height ||
            note.at("stack").at("channels").size() != image_.film.channels.size())
            fail(file(plane), "has another size than the stack that it says it is of");
        return note;
    }

    fs::path stem_;
    StackInfo info_;
    RenderedImage image_;
    int plane_ = -1;
};

OpenStack open_stack(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) return open_zarr_stack(path);
    const std::optional<fs::path> stem = exr_stem(path);
    const bool is_plane = stem && stem->filename() != path.stem() && fs::exists(path, ignored);
    if (stem && (is_plane || fs::exists(stem->string() + exr_plane_ending(0), ignored))) return open_exr_stack(*stem);
    if (!fs::exists(path, ignored)) fail(path, "there is no such file");
    if (!fs::is_regular_file(path, ignored) || !starts_as_tiff(path))
        fail(path, std::string("is no stack that can be read: those are ") + kStacksRead);
    return open_tiff_stack(path);
}

}  // namespace

StackInfo checked_stack_info(const std::string& json, const fs::path& path) try {
    StackInfo info = stack_info_from_json(json);
    if (info.width < 1 || info.height < 1 || info.planes < 1 || info.channels.empty())
        fail(path, "its description of the stack is damaged");
    return info;
} catch (const nlohmann::json::exception&) {
    fail(path, "its description of the stack is damaged");
}

std::string exr_plane_ending(int plane) {
    return fmt::format("-{:04}.exr", plane);
}

std::string exr_plane_note(const StackInfo& info, int plane) {
    const Json json = {{"plane", plane}, {"stack", Json::parse(to_json(info))}, {"scene", info.scene_json}};
    return json.dump(-1, ' ', true, Json::error_handler_t::replace);
}

OpenStack open_exr_stack(const fs::path& stem) try {
    const auto planes = std::make_shared<ExrPlanes>(stem);
    return {planes->info(),
            [planes, stem](int plane, int channel, std::span<float> values) { planes->read(plane, channel, values); }};
} catch (const nlohmann::json::exception&) {
    fail(stem.string() + exr_plane_ending(0), "its description of the stack is damaged");
}

StackFile::StackFile(const fs::path& path) {
    OpenStack stack = open_stack(path);
    info_ = std::move(stack.info);
    source_ = std::move(stack.source);
}

void StackFile::read(int plane, int channel, std::span<float> values) {
    source_(plane, channel, values);
}

}  // namespace fluovox
