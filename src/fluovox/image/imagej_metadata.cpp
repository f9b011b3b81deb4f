#include "fluovox/image/imagej_metadata.h"

#include "fluovox/core/utf8.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace fluovox {
namespace {

// Laid out as ImageJ's own TiffEncoder does: "IJIJ", then a type and a number of parts for each kind, all as integers
// of the file's byte order; then the parts, whose sizes (the head's first) are the other tag. Texts are UTF-16.
constexpr std::uint32_t kMagic = 0x494a494a;   // "IJIJ"
constexpr std::uint32_t kInfo = 0x696e666f;    // "info"
constexpr std::uint32_t kLabels = 0x6c61626c;  // "labl"
constexpr std::uint32_t kRanges = 0x72616e67;  // "rang"
constexpr std::uint32_t kColors = 0x6c757473;  // "luts"
constexpr std::size_t kHead = 4;               // bytes before the first kind
constexpr std::size_t kKind = 8;               // bytes of a kind

constexpr std::string_view kStackKey = "fluovox stack: ";
constexpr std::string_view kSceneKey = "\nfluovox scene: ";

// Floats order like the whole numbers of the same bits; the leading half of these is a count to within 1/128.
constexpr unsigned kDropped = 16;
constexpr std::size_t kBins = 0x8000;

std::size_t bin_of(float value) {
    return std::bit_cast<std::uint32_t>(value) >> kDropped;
}

/// The end of a bin.
float top_of(std::size_t bin) {
    return std::bit_cast<float>(static_cast<std::uint32_t>((bin + 1) << kDropped) - 1U);
}

template <class T>
void put(std::string& bytes, T value) {
    static_assert(std::endian::native == std::endian::little);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);  // NOLINT(*-reinterpret-cast): bytes
}

std::string utf16_bytes(std::string_view text) {
    std::string bytes;
    for (const char16_t unit : to_utf16(text))
        put(bytes, unit);
    return bytes;
}

/// 256 steps from black to a colour: all reds, greens, blues.
std::string ramp(std::uint32_t rgb) {
    std::string table;
    for (const unsigned shift : {16U, 8U, 0U}) {
        const std::uint32_t full = (rgb >> shift) & 0xFFU;
        for (std::uint32_t i = 0; i < 256; ++i)
            table += static_cast<char>((full * i + 127) / 255);
    }
    return table;
}

/// Numbers of a block in the order of its file, which its magic tells.
class Reader {
public:
    explicit Reader(std::string_view bytes) : bytes_(bytes), little_(bytes.starts_with("JIJI")) {}

    bool is_metadata() const { return little_ || bytes_.starts_with("IJIJ"); }
    std::uint32_t number(std::size_t at, std::size_t bytes = 4) const {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i)
            value = value << 8U | static_cast<unsigned char>(bytes_[little_ ? at + bytes - 1 - i : at + i]);
        return value;
    }
    std::string text(std::size_t at, std::size_t bytes) const {
        std::u16string wide;
        for (std::size_t i = 0; i + 1 < bytes; i += 2)
            wide += static_cast<char16_t>(number(at + i, 2));
        return to_utf8(wide);
    }

private:
    std::string_view bytes_;
    bool little_;
};

}  // namespace

DisplayRanges::DisplayRanges(const StackInfo& info)
    : value_per_count_(info.type == SampleType::UInt16 ? info.value_per_count : 1),
      labels_(info.quantity == "labels"),
      channels_(info.channels.size()) {
    for (Seen& channel : channels_)
        channel.lit.resize(labels_ ? 0 : kBins);
}

void DisplayRanges::add(int channel, std::span<const float> values) {
    Seen& seen = channels_[static_cast<std::size_t>(channel)];
    for (const float value : values) {
        if (!std::isfinite(value)) continue;
        seen.least = seen.any ? std::min(seen.least, value) : value;
        seen.most = seen.any ? std::max(seen.most, value) : value;
        seen.any = true;
        if (value > 0 && !labels_) ++seen.lit[bin_of(value)];
    }
}

DisplayRange DisplayRanges::range(int channel) const {
    const Seen& seen = channels_[static_cast<std::size_t>(channel)];
    if (!(seen.most > 0)) return {};
    if (labels_) return {0, std::round(static_cast<double>(seen.most) / value_per_count_)};
    std::uint64_t lit = 0;
    for (const std::uint64_t count : seen.lit)
        lit += count;
    std::uint64_t above = 0;
    std::size_t bin = kBins - 1;
    while (bin > 0 && (above + seen.lit[bin]) * 1000 <= lit)
        above += seen.lit[bin--];
    const float high = std::min(top_of(bin), seen.most);
    const float low = seen.least > 0 && seen.least < high ? seen.least : 0.0F;
    return {static_cast<double>(low) / value_per_count_, static_cast<double>(high) / value_per_count_};
}

ImageJMetadata imagej_metadata(const StackInfo& info, const std::vector<DisplayRange>& ranges) {
    const std::size_t channels = info.channels.size();
    const std::size_t images = channels * static_cast<std::size_t>(info.planes);
    ImageJMetadata metadata;
    std::string head;
    std::string parts;
    put(head, kMagic);
    metadata.sizes.push_back(0);
    const auto kind = [&](std::uint32_t type, std::size_t count) {
        put(head, type);
        put(head, static_cast<std::uint32_t>(count));
    };
    const auto part = [&](const std::string& bytes) {
        metadata.sizes.push_back(static_cast<std::uint32_t>(bytes.size()));
        parts += bytes;
    };
    kind(kInfo, 1);
    part(utf16_bytes(std::string(kStackKey) + to_json(info) + std::string(kSceneKey) + info.scene_json + '\n'));
    kind(kLabels, images);
    for (std::size_t image = 0; image < images; ++image)
        part(utf16_bytes(info.channels[image % channels].name));
    if (channels > 1) {
        kind(kRanges, 1);
        std::string numbers;
        for (const DisplayRange& range : ranges) {
            put(numbers, range.low);
            put(numbers, range.high);
        }
        part(numbers);
        // Where all are white, ImageJ's own colours tell them apart.
        constexpr std::uint32_t kWhite = 0xFFFFFF;
        const bool white = std::all_of(info.channels.begin(), info.channels.end(),
                                       [](const StackChannel& channel) { return channel.rgb == kWhite; });
        if (!white) {
            kind(kColors, channels);
            for (const StackChannel& channel : info.channels)
                part(ramp(channel.rgb));
        }
    }
    metadata.sizes.front() = static_cast<std::uint32_t>(head.size());
    metadata.bytes = head + parts;
    return metadata;
}

ImageJInfo imagej_info_in(std::string_view metadata, std::span<const std::uint32_t> sizes) {
    const Reader in(metadata);
    if (sizes.empty() || metadata.size() < kHead || !in.is_metadata() || sizes.front() > metadata.size()) return {};
    std::size_t part = 1;
    std::size_t at = sizes.front();
    for (std::size_t kind = kHead; kind + kKind <= sizes.front(); kind += kKind) {
        const std::uint32_t type = in.number(kind);
        const std::uint32_t count = in.number(kind + 4);
        for (std::uint32_t i = 0; i < count; ++i) {
            if (part >= sizes.size() || sizes[part] > metadata.size() - at) return {};
            const std::string text = type == kInfo ? in.text(at, sizes[part]) : std::string();
            if (text.starts_with(kStackKey)) {
                const std::size_t scene = text.find(kSceneKey);
                if (scene == std::string::npos || text.back() != '\n') return {};
                const std::size_t begin = scene + kSceneKey.size();
                return {text.substr(kStackKey.size(), scene - kStackKey.size()),
                        text.substr(begin, text.size() - 1 - begin)};
            }
            at += sizes[part++];
        }
    }
    return {};
}

}  // namespace fluovox
