#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/image/imagej_metadata.h"
#include "fluovox/image/stack_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <vector>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

// ImageJ reads the first directory only and takes the images to lie one behind the other, which libtiff cannot write:
// it puts a directory behind each. So the few bytes around the pixels are made here. TIFF 6.0.

static_assert(std::endian::native == std::endian::little, "pixels are written as they are in memory");

constexpr double kMostBytes = 4294967295.0;  // offsets have 32 bits
constexpr std::uint32_t kHeader = 8;

enum Tag : std::uint16_t {
    kSubfile = 254,
    kWidth = 256,
    kHeight = 257,
    kBits = 258,
    kCompression = 259,
    kPhotometric = 262,
    kDescription = 270,
    kStripOffset = 273,
    kSamples = 277,
    kRows = 278,
    kStripBytes = 279,
    kXResolution = 282,
    kYResolution = 283,
    kResolutionUnit = 296,
    kSampleFormat = 339,
    kMetadataSizes = 50838,
    kMetadata = 50839,
};
enum FieldType : std::uint16_t { kByte = 1, kAscii = 2, kShort = 3, kLong = 4, kRational = 5 };

class Bytes {
public:
    void put16(std::uint32_t value) {
        text_ += static_cast<char>(value & 0xFFU);
        text_ += static_cast<char>((value >> 8U) & 0xFFU);
    }
    void put32(std::uint32_t value) {
        put16(value & 0xFFFFU);
        put16(value >> 16U);
    }
    void entry(Tag tag, FieldType type, std::uint32_t count, std::uint32_t value) {
        put16(tag);
        put16(type);
        put32(count);
        put32(value);
    }
    void append(const std::string& text) { text_ += text; }
    const std::string& text() const { return text_; }

private:
    std::string text_;
};

/// What ImageJ 1.x looks for in the description.
std::string description_of(const StackInfo& info, const DisplayRange& range) {
    const std::size_t channels = info.channels.size();
    std::string text = fmt::format("ImageJ=1.53t\nimages={}\n", channels * static_cast<std::size_t>(info.planes));
    if (channels > 1) text += fmt::format("channels={}\n", channels);
    text += fmt::format("slices={}\nhyperstack=true\n", info.planes);
    constexpr std::size_t kMostComposite = 7;
    if (channels > 1) text += fmt::format("mode={}\n", channels <= kMostComposite ? "composite" : "grayscale");
    text += fmt::format("unit=um\nspacing={}\nloop=false\nmin={}\nmax={}\n", info.step_um, range.low, range.high);
    text += '\0';
    return text;
}

/// Where things lie in the file: header and first directory, resolution, pixels, the directories of the other images
/// (for readers that are not ImageJ), and at last what is known only when the pixels are: metadata and description.
struct Layout {
    static constexpr std::uint32_t kEntries = 15;
    static constexpr std::uint32_t kFirstEntries = kEntries + 2;
    static constexpr std::uint32_t directory_bytes(std::uint32_t entries) { return 2 + 12 * entries + 4; }

    std::uint32_t resolution = kHeader + directory_bytes(kFirstEntries);
    std::uint32_t pixels = resolution + 8;
    std::uint32_t image_bytes = 0, images = 0;
    std::uint32_t sizes = 0, metadata = 0, description = 0;
    std::uint32_t size_count = 0, metadata_bytes = 0, description_bytes = 0;

    Layout(const StackInfo& info, const ImageJMetadata& block, const std::string& text)
        : image_bytes(static_cast<std::uint32_t>(info.pixels() * info.bytes_per_sample())),
          images(static_cast<std::uint32_t>(info.channels.size()) * static_cast<std::uint32_t>(info.planes)),
          sizes(directory(images)),
          metadata(sizes + 4 * static_cast<std::uint32_t>(block.sizes.size())),
          description(metadata + static_cast<std::uint32_t>(block.bytes.size() + block.bytes.size() % 2)),
          size_count(static_cast<std::uint32_t>(block.sizes.size())),
          metadata_bytes(static_cast<std::uint32_t>(block.bytes.size())),
          description_bytes(static_cast<std::uint32_t>(text.size())) {}

    std::uint32_t end_of_pixels() const { return pixels + images * image_bytes; }
    /// Offsets are even.
    std::uint32_t directory(std::uint32_t image) const {
        if (image == 0) return kHeader;
        return end_of_pixels() + end_of_pixels() % 2 + (image - 1) * directory_bytes(kEntries);
    }
};

void put_directory(Bytes& out, const StackInfo& info, const Layout& at, std::uint32_t image) {
    constexpr std::uint32_t kUnsigned = 1;
    constexpr std::uint32_t kFloat = 3;
    const bool counts = info.type == SampleType::UInt16;
    out.put16(image == 0 ? Layout::kFirstEntries : Layout::kEntries);
    out.entry(kSubfile, kLong, 1, 0);
    out.entry(kWidth, kLong, 1, static_cast<std::uint32_t>(info.width));
    out.entry(kHeight, kLong, 1, static_cast<std::uint32_t>(info.height));
    out.entry(kBits, kShort, 1, counts ? 16 : 32);
    out.entry(kCompression, kShort, 1, 1);
    out.entry(kPhotometric, kShort, 1, 1);
    out.entry(kDescription, kAscii, at.description_bytes, at.description);
    out.entry(kStripOffset, kLong, 1, at.pixels + image * at.image_bytes);
    out.entry(kSamples, kShort, 1, 1);
    out.entry(kRows, kLong, 1, static_cast<std::uint32_t>(info.height));
    out.entry(kStripBytes, kLong, 1, at.image_bytes);
    out.entry(kXResolution, kRational, 1, at.resolution);
    out.entry(kYResolution, kRational, 1, at.resolution);
    out.entry(kResolutionUnit, kShort, 1, 1);
    out.entry(kSampleFormat, kShort, 1, counts ? kUnsigned : kFloat);
    if (image == 0) {
        out.entry(kMetadataSizes, kLong, at.size_count, at.sizes);
        out.entry(kMetadata, kByte, at.metadata_bytes, at.metadata);
    }
    out.put32(image + 1 < at.images ? at.directory(image + 1) : 0);
}

/// Pixels per micrometre as a fraction of whole numbers; exact for sizes with few digits.
void put_resolution(Bytes& out, double pixel_um) {
    constexpr double kMost = 4e9;
    double pixels = 1;
    while (pixels * 10 < kMost && pixels * 10 * pixel_um < kMost)
        pixels *= 10;
    out.put32(static_cast<std::uint32_t>(pixels));
    out.put32(static_cast<std::uint32_t>(std::lround(std::clamp(pixels * pixel_um, 1.0, kMost))));
}

/// All up to the pixels.
std::string head_of(const StackInfo& info, const Layout& at) {
    Bytes head;
    head.append("II");
    head.put16(42);
    head.put32(at.directory(0));
    put_directory(head, info, at, 0);
    put_resolution(head, info.pixel_um);
    return head.text();
}

/// All behind them.
std::string tail_of(const StackInfo& info, const Layout& at, const ImageJMetadata& metadata, const std::string& text) {
    Bytes tail;
    if (at.end_of_pixels() % 2 != 0) tail.append(std::string(1, '\0'));
    for (std::uint32_t image = 1; image < at.images; ++image)
        put_directory(tail, info, at, image);
    for (const std::uint32_t size : metadata.sizes)
        tail.put32(size);
    tail.append(metadata.bytes);
    if (metadata.bytes.size() % 2 != 0) tail.append(std::string(1, '\0'));
    tail.append(text);
    return tail.text();
}

/// Gives the range of values of each channel.
std::vector<DisplayRange> write_pixels(std::ofstream& out, const StackInfo& info, const PlaneSource& source) {
    const auto channels = static_cast<int>(info.channels.size());
    DisplayRanges seen(info);
    std::vector<float> values(info.pixels());
    std::vector<std::uint16_t> counts(info.type == SampleType::UInt16 ? info.pixels() : 0);
    for (int plane = 0; plane < info.planes; ++plane) {
        for (int channel = 0; channel < channels; ++channel) {
            source(plane, channel, values);
            seen.add(channel, values);
            const void* data = values.data();
            for (std::size_t i = 0; i < counts.size(); ++i)
                counts[i] = to_count(values[i], info.value_per_count);
            if (!counts.empty()) data = counts.data();
            out.write(static_cast<const char*>(data),
                      static_cast<std::streamsize>(info.pixels() * info.bytes_per_sample()));
        }
    }
    std::vector<DisplayRange> ranges;
    ranges.reserve(info.channels.size());
    for (int channel = 0; channel < channels; ++channel)
        ranges.push_back(seen.range(channel));
    return ranges;
}

/// More than the file needs beside its pixels.
double bytes_beside_pixels(const StackInfo& info, const ImageJMetadata& metadata) {
    const double images = static_cast<double>(info.channels.size()) * info.planes;
    constexpr double kHeadAndDescription = 4096;
    return images * Layout::directory_bytes(Layout::kEntries) + 4 * static_cast<double>(metadata.sizes.size()) +
           static_cast<double>(metadata.bytes.size()) + kHeadAndDescription;
}

}  // namespace

void save_imagej_tiff(const fs::path& path, const StackInfo& info, const PlaneSource& source) {
    // Of the same size as the one that is written.
    const ImageJMetadata sketch = imagej_metadata(info, std::vector<DisplayRange>(info.channels.size()));
    if (info.bytes() + bytes_beside_pixels(info, sketch) > kMostBytes) {
        throw OutputError(
            fmt::format("{}: plain ImageJ reads no TIFF over 4 GB, and this one would have {:.1f} GB: "
                        "write an .ome.tif, or --type uint16",
                        path.string(), info.bytes() / 1e9));
    }
    write_atomically(path, [&](const fs::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        const auto write = [&](const std::string& bytes) {
            out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        };
        write(head_of(info, Layout(info, sketch, {})));
        const std::vector<DisplayRange> ranges = write_pixels(out, info, source);
        const ImageJMetadata metadata = imagej_metadata(info, ranges);
        const std::string text = description_of(info, ranges.front());
        const Layout layout(info, metadata, text);
        write(tail_of(info, layout, metadata, text));
        out.seekp(0);
        write(head_of(info, layout));
        out.close();
        if (!out) throw OutputError(fmt::format("{}: could not be written: {}", path.string(), std::strerror(errno)));
    });
}

}  // namespace fluovox
