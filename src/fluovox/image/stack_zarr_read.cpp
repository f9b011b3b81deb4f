#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/image/stack_read.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <vector>

namespace fluovox {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

[[noreturn]] void fail(const fs::path& path, const std::string& why) {
    throw InputError(fmt::format("{}: {}", path.string(), why));
}

/// The array of the full size must be as `save_ome_zarr` writes it: other programs may have packed it anew.
void require_our_array(const fs::path& folder, const StackInfo& info) {
    const fs::path file = folder / "0" / ".zarray";
    const Json array = Json::parse(load_text(file), nullptr, false);
    if (!array.is_object()) fail(file, "is damaged");
    const Json shape = {info.channels.size(), info.planes, info.height, info.width};
    const Json chunks = {1, 1, info.height, info.width};
    const char* const type = info.type == SampleType::UInt16 ? "<u2" : "<f4";
    const Json compressor = array.value("compressor", Json());
    const bool ours = array.value("shape", Json()) == shape && array.value("chunks", Json()) == chunks &&
                      array.value("dtype", Json()) == type && array.value("order", Json()) == "C" &&
                      array.value("dimension_separator", Json()) == "/" && array.value("filters", Json()).is_null() &&
                      compressor.is_object() && compressor.value("id", Json()) == "zlib";
    if (!ours)
        fail(file, "is not as fluovox wrote it (another size, chunks or compression): only such a stack is read");
}

std::vector<char> load_bytes(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) fail(file, "is missing: the stack is not whole");
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Unpacks a chunk of exactly `bytes` bytes; zlib's checksum finds damage.
void load_chunk(const fs::path& file, void* into, std::size_t bytes) {
    const std::vector<char> packed = load_bytes(file);
    auto size = static_cast<uLongf>(bytes);
    const int result = uncompress(static_cast<Bytef*>(into), &size,
                                  reinterpret_cast<const Bytef*>(packed.data()),  // NOLINT(*-reinterpret-cast)
                                  static_cast<uLong>(packed.size()));
    if (result != Z_OK || size != bytes) fail(file, "is damaged");
}

}  // namespace

OpenStack open_zarr_stack(const fs::path& folder) {
    const fs::path file = folder / ".zattrs";
    std::error_code ignored;
    if (!fs::exists(file, ignored))
        fail(folder, std::string("is a folder, but no OME-Zarr: what can be read is ") + kStacksRead);
    const Json attributes = Json::parse(load_text(file), nullptr, false);
    const Json ours = attributes.is_object() ? attributes.value("fluovox", Json()) : Json();
    if (!ours.is_object() || !ours.contains("stack")) fail(folder, "is not a stack that fluovox wrote as .ome.zarr");
    OpenStack stack;
    stack.info = checked_stack_info(ours.at("stack").dump(), file);
    const Json scene = ours.value("scene", Json());
    if (scene.is_string()) stack.info.scene_json = scene;
    require_our_array(folder, stack.info);
    stack.source = [folder, info = stack.info, counts = std::vector<std::uint16_t>()](int plane, int channel,
                                                                                      std::span<float> values) mutable {
        const fs::path chunk = folder / fmt::format("0/{}/{}/0/0", channel, plane);
        if (info.type == SampleType::Float32) return load_chunk(chunk, values.data(), values.size_bytes());
        counts.resize(values.size());
        load_chunk(chunk, counts.data(), counts.size() * sizeof(std::uint16_t));
        std::transform(counts.begin(), counts.end(), values.begin(),
                       [&](std::uint16_t count) { return static_cast<float>(count * info.value_per_count); });
    };
    return stack;
}

}  // namespace fluovox
