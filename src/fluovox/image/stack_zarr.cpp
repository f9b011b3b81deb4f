#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/image/imagej_metadata.h"
#include "fluovox/image/stack_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kSmallest = 96;  // pixels; levels end where the longer side is at most twice this
constexpr int kLevel = 1;      // of zlib: fast

static_assert(std::endian::native == std::endian::little, "chunks are written as they are in memory");

void write_file(const fs::path& file, const char* data, std::size_t size) {
    std::error_code ignored;
    fs::create_directories(file.parent_path(), ignored);
    std::ofstream out(file, std::ios::binary);
    out.write(data, static_cast<std::streamsize>(size));
    out.close();
    if (!out) throw OutputError(fmt::format("{}: could not be written: {}", file.string(), std::strerror(errno)));
}

void write_json(const fs::path& file, const Json& json) {
    const std::string text = json.dump(2, ' ', true, Json::error_handler_t::replace) + '\n';
    write_file(file, text.data(), text.size());
}

/// One size of the picture pyramid.
struct Level {
    int width = 0, height = 0;
    double scale = 1;  // of level 0 in one pixel
};

std::vector<Level> levels_of(const StackInfo& info) {
    std::vector<Level> levels = {{info.width, info.height, 1}};
    while (std::max(levels.back().width, levels.back().height) > 2 * kSmallest) {
        const Level& last = levels.back();
        levels.push_back({(last.width + 1) / 2, (last.height + 1) / 2, 2 * last.scale});
    }
    return levels;
}

/// Half as wide and high: means of blocks of four, or (labels cannot be averaged) the first of each.
std::vector<float> halved(const std::vector<float>& values, const Level& from, const Level& to, bool labels) {
    std::vector<float> result;
    result.reserve(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height));
    for (int y = 0; y < to.height; ++y) {
        for (int x = 0; x < to.width; ++x) {
            float sum = 0;
            int count = 0;
            for (int j = 2 * y; j < std::min(2 * y + 2, from.height); ++j) {
                for (int i = 2 * x; i < std::min(2 * x + 2, from.width); ++i) {
                    sum += values[static_cast<std::size_t>(j) * static_cast<std::size_t>(from.width) +
                                  static_cast<std::size_t>(i)];
                    ++count;
                    if (labels) break;
                }
                if (labels) break;
            }
            result.push_back(sum / static_cast<float>(count));
        }
    }
    return result;
}

class Group {
public:
    Group(fs::path folder, const StackInfo& info, bool labels)
        : folder_(std::move(folder)), info_(info), labels_(labels), levels_(levels_of(info)) {}

    /// Gives for each channel what viewers show at first.
    std::vector<DisplayRange> write_planes(const PlaneSource& source) const {
        DisplayRanges seen(info_);
        for (std::size_t level = 0; level < levels_.size(); ++level)
            write_array(level);
        std::vector<float> values(info_.pixels());
        for (int plane = 0; plane < info_.planes; ++plane) {
            for (int channel = 0; channel < static_cast<int>(info_.channels.size()); ++channel) {
                values.resize(info_.pixels());
                source(plane, channel, values);
                seen.add(channel, values);
                for (std::size_t level = 0; level < levels_.size(); ++level) {
                    if (level > 0) values = halved(values, levels_[level - 1], levels_[level], labels_);
                    write_chunk(folder_ / fmt::format("{}/{}/{}/0/0", level, channel, plane), values);
                }
            }
        }
        std::vector<DisplayRange> ranges;
        ranges.reserve(info_.channels.size());
        for (int channel = 0; channel < static_cast<int>(info_.channels.size()); ++channel)
            ranges.push_back(seen.range(channel));
        return ranges;
    }

    Json multiscale() const {
        Json datasets = Json::array();
        for (std::size_t level = 0; level < levels_.size(); ++level) {
            const double pixel_um = info_.pixel_um * levels_[level].scale;
            Json places = {{{"type", "scale"}, {"scale", {1.0, info_.step_um, pixel_um, pixel_um}}}};
            if (info_.origin_um) {
                // The middle of a pixel that stands for a block is the block's.
                const double inset_um = 0.5 * (pixel_um - info_.pixel_um);
                const Vec3 first = *info_.origin_um;
                places.push_back(
                    {{"type", "translation"}, {"translation", {0.0, first.z, first.y + inset_um, first.x + inset_um}}});
            }
            datasets.push_back({{"path", std::to_string(level)}, {"coordinateTransformations", places}});
        }
        const auto space = [](const char* name) {
            return Json{{"name", name}, {"type", "space"}, {"unit", "micrometer"}};
        };
        return {{"version", "0.4"},
                {"name", info_.title},
                {"axes", {{{"name", "c"}, {"type", "channel"}}, space("z"), space("y"), space("x")}},
                {"datasets", datasets},
                {"type", labels_ ? "nearest" : "mean"}};
    }

private:
    void write_array(std::size_t level) const {
        const Level& size = levels_[level];
        const char* type = info_.type == SampleType::UInt16 ? "<u2" : "<f4";
        write_json(folder_ / std::to_string(level) / ".zarray",
                   {{"zarr_format", 2},
                    {"shape", {info_.channels.size(), info_.planes, size.height, size.width}},
                    {"chunks", {1, 1, size.height, size.width}},
                    {"dtype", type},
                    {"compressor", {{"id", "zlib"}, {"level", kLevel}}},
                    {"fill_value", 0},
                    {"order", "C"},
                    {"filters", nullptr},
                    {"dimension_separator", "/"}});
    }

    void write_chunk(const fs::path& file, const std::vector<float>& values) const {
        std::vector<std::uint16_t> counts;
        const void* data = values.data();
        std::size_t bytes = values.size() * sizeof(float);
        if (info_.type == SampleType::UInt16) {
            for (const float value : values)
                counts.push_back(to_count(value, info_.value_per_count));
            data = counts.data();
            bytes = counts.size() * sizeof(std::uint16_t);
        }
        uLongf size = compressBound(static_cast<uLong>(bytes));
        std::vector<char> packed(size);
        const int result = compress2(reinterpret_cast<Bytef*>(packed.data()), &size,  // NOLINT(*-reinterpret-cast)
                                     static_cast<const Bytef*>(data), static_cast<uLong>(bytes), kLevel);
        if (result != Z_OK) throw OutputError(fmt::format("{}: could not be compressed", file.string()));
        write_file(file, packed.data(), size);
    }

    fs::path folder_;
    const StackInfo& info_;
    bool labels_;
    std::vector<Level> levels_;
};

Json channel_json(const StackInfo& info, const std::vector<DisplayRange>& ranges) {
    const double top = info.type == SampleType::UInt16 ? info.max_value / info.value_per_count : info.max_value;
    Json channels = Json::array();
    for (std::size_t i = 0; i < info.channels.size(); ++i) {
        const StackChannel& channel = info.channels[i];
        channels.push_back({{"label", channel.name},
                            {"color", fmt::format("{:06X}", channel.rgb)},
                            {"active", true},
                            {"window",
                             {{"min", 0.0},
                              {"max", std::max(top, ranges[i].high)},
                              {"start", ranges[i].low},
                              {"end", ranges[i].high}}}});
    }
    return channels;
}

void write_labels(const fs::path& folder, const StackInfo& image, const StackLabels& labels) {
    StackInfo info = image;
    info.channels = {StackChannel{}};
    info.type = SampleType::UInt16;
    info.value_per_count = 1;
    info.title = labels.name;
    write_json(folder / "labels" / ".zgroup", {{"zarr_format", 2}});
    write_json(folder / "labels" / ".zattrs", {{"labels", {labels.name}}});
    const fs::path to = folder / "labels" / labels.name;
    const Group group(to, info, true);
    write_json(to / ".zgroup", {{"zarr_format", 2}});
    write_json(to / ".zattrs", {{"multiscales", {group.multiscale()}},
                                {"image-label", {{"version", "0.4"}, {"source", {{"image", "../../"}}}}}});
    group.write_planes(labels.source);
}

void write_zarr(const fs::path& folder, const StackInfo& info, const PlaneSource& source,
                const std::optional<StackLabels>& labels) {
    const Group group(folder, info, false);
    write_json(folder / ".zgroup", {{"zarr_format", 2}});
    const Json channels = channel_json(info, group.write_planes(source));
    write_json(folder / ".zattrs", {{"multiscales", {group.multiscale()}},
                                    {"omero", {{"version", "0.4"}, {"name", info.title}, {"channels", channels}}},
                                    {"fluovox", {{"stack", Json::parse(to_json(info))}, {"scene", info.scene_json}}}});
    if (labels) write_labels(folder, info, *labels);
}

// Names at the top of a folder that write_zarr makes.
bool is_ours(const std::string& name) {
    return name == ".zattrs" || name == ".zgroup" || name == "labels" ||
           std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

bool is_written_by_us(const fs::path& folder) {
    std::ifstream in(folder / ".zattrs");
    const Json attributes = Json::parse(in, nullptr, false);
    return attributes.is_object() && attributes.contains("fluovox");
}

}  // namespace

void require_replaceable_zarr(const fs::path& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return;
    if (!fs::is_directory(path, ignored))
        throw OutputError(path.string() + ": is there already and no OME-Zarr folder");
    const fs::directory_iterator entries(path, ignored);
    if (entries == fs::directory_iterator()) return;
    if (!is_written_by_us(path)) {
        throw OutputError(path.string() + ": is a folder with other things in it; name one that is not there yet");
    }
    for (const fs::directory_entry& entry : entries) {
        const std::string name = entry.path().filename().string();
        if (!is_ours(name)) {
            throw OutputError(
                fmt::format("{}: \"{}\" in it is not of the stack that would be replaced", path.string(), name));
        }
    }
}

std::vector<fs::path> files_of_zarr(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, ignored)) {
        const fs::path inside = entry.path().lexically_relative(folder);
        const bool ours = std::all_of(inside.begin(), inside.end(),
                                      [](const fs::path& part) { return part == ".zarray" || is_ours(part.string()); });
        if (ours && entry.is_regular_file(ignored)) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

void save_ome_zarr(const fs::path& path, const StackInfo& info, const PlaneSource& source,
                   const std::optional<StackLabels>& labels) {
    const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
    require_writable(parent / ".fluovox");
    require_replaceable_zarr(path);
    const std::string name = fmt::format(".{}.{}", path.filename().string(), ::getpid());
    const fs::path fresh = parent / (name + ".new");
    const fs::path old = parent / (name + ".old");
    std::error_code ignored;
    try {
        write_zarr(fresh, info, source, labels);
    } catch (...) {
        fs::remove_all(fresh, ignored);
        throw;
    }
    // A folder cannot take the place of another in one step: the old one steps aside first.
    std::error_code failure;
    if (fs::exists(path)) fs::rename(path, old, failure);
    if (!failure) fs::rename(fresh, path, failure);
    if (failure) {
        // Back in its place, unless another run has put its own there meanwhile.
        if (fs::exists(old, ignored)) fs::rename(old, path, ignored);
        if (fs::exists(path, ignored)) fs::remove_all(old, ignored);
        fs::remove_all(fresh, ignored);
        throw OutputError(path.string() + ": " + failure.message());
    }
    fs::remove_all(old, ignored);
}

}  // namespace fluovox
