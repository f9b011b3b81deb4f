#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
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
};
enum FieldType : std::uint16_t { kAscii = 2, kShort = 3, kLong = 4, kRational = 5 };

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
std::string description_of(const StackInfo& info) {
    const std::size_t channels = info.channels.size();
    std::string text = fmt::format("ImageJ=1.53t\nimages={}\n", channels * static_cast<std::size_t>(info.planes));
    if (channels > 1) text += fmt::format("channels={}\n", channels);
    text += fmt::format("slices={}\nhyperstack=true\n", info.planes);
    constexpr std::size_t kMostComposite = 7;
    if (channels > 1) text += fmt::format("mode={}\n", channels <= kMostComposite ? "composite" : "grayscale");
    text += fmt::format("unit=um\nspacing={}\nloop=false\n", info.step_um);
    const double top = info.type == SampleType::UInt16 ? info.max_value / info.value_per_count : info.max_value;
    if (top > 0) text += fmt::format("min=0\nmax={}\n", top);
    text += '\0';
    if (text.size() % 2 != 0) text += '\0';  // what follows begins at an even place
    return text;
}

/// Where things lie in the file.
struct Layout {
    std::uint32_t entries = 15;
    std::uint32_t directory_bytes = 2 + 12 * entries + 4;
    std::uint32_t description = kHeader + directory_bytes;
    std::uint32_t resolution = 0, pixels = 0;
    std::uint32_t image_bytes = 0, images = 0;

    Layout(const StackInfo& info, std::size_t description_bytes)
        : resolution(description + static_cast<std::uint32_t>(description_bytes)),
          pixels(resolution + 8),
          image_bytes(static_cast<std::uint32_t>(info.pixels() * info.bytes_per_sample())),
          images(static_cast<std::uint32_t>(info.channels.size()) * static_cast<std::uint32_t>(info.planes)) {}

    /// Directories of the other images, for readers that are not ImageJ, follow the pixels.
    std::uint32_t directory(std::uint32_t image) const {
        if (image == 0) return kHeader;
        const std::uint32_t end = pixels + images * image_bytes;
        return end + end % 2 + (image - 1) * directory_bytes;
    }
};

void put_directory(Bytes& out, const StackInfo& info, const Layout& at, std::uint32_t description_bytes,
                   std::uint32_t image) {
    constexpr std::uint32_t kUnsigned = 1;
    constexpr std::uint32_t kFloat = 3;
    const bool counts = info.type == SampleType::UInt16;
    out.put16(at.entries);
    out.entry(kSubfile, kLong, 1, 0);
    out.entry(kWidth, kLong, 1, static_cast<std::uint32_t>(info.width));
    out.entry(kHeight, kLong, 1, static_cast<std::uint32_t>(info.height));
    out.entry(kBits, kShort, 1, counts ? 16 : 32);
    out.entry(kCompression, kShort, 1, 1);
    out.entry(kPhotometric, kShort, 1, 1);
    out.entry(kDescription, kAscii, description_bytes, at.description);
    out.entry(kStripOffset, kLong, 1, at.pixels + image * at.image_bytes);
    out.entry(kSamples, kShort, 1, 1);
    out.entry(kRows, kLong, 1, static_cast<std::uint32_t>(info.height));
    out.entry(kStripBytes, kLong, 1, at.image_bytes);
    out.entry(kXResolution, kRational, 1, at.resolution);
    out.entry(kYResolution, kRational, 1, at.resolution);
    out.entry(kResolutionUnit, kShort, 1, 1);
    out.entry(kSampleFormat, kShort, 1, counts ? kUnsigned : kFloat);
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

void write_pixels(std::ofstream& out, const StackInfo& info, const PlaneSource& source) {
    std::vector<float> values(info.pixels());
    std::vector<std::uint16_t> counts(info.type == SampleType::UInt16 ? info.pixels() : 0);
    for (int plane = 0; plane < info.planes; ++plane) {
        for (int channel = 0; channel < static_cast<int>(info.channels.size()); ++channel) {
            source(plane, channel, values);
            const void* data = values.data();
            for (std::size_t i = 0; i < counts.size(); ++i)
                counts[i] = to_count(values[i], info.value_per_count);
            if (!counts.empty()) data = counts.data();
            out.write(static_cast<const char*>(data),
                      static_cast<std::streamsize>(info.pixels() * info.bytes_per_sample()));
        }
    }
}

}  // namespace

void save_imagej_tiff(const fs::path& path, const StackInfo& info, const PlaneSource& source) {
    const std::string description = description_of(info);
    constexpr double kBesidePixels = 8192;
    const double images = static_cast<double>(info.channels.size()) * info.planes;
    if (info.bytes() + images * 256 + kBesidePixels > kMostBytes) {
        throw OutputError(
            fmt::format("{}: plain ImageJ reads no TIFF over 4 GB, and this one would have {:.1f} GB: "
                        "write an .ome.tif, or --type uint16",
                        path.string(), info.bytes() / 1e9));
    }
    const Layout at(info, description.size());
    const auto description_bytes = static_cast<std::uint32_t>(description.size());
    Bytes head;
    head.append("II");
    head.put16(42);
    head.put32(at.directory(0));
    put_directory(head, info, at, description_bytes, 0);
    head.append(description);
    put_resolution(head, info.pixel_um);
    Bytes tail;
    if ((at.pixels + at.images * at.image_bytes) % 2 != 0) tail.append(std::string(1, '\0'));
    for (std::uint32_t image = 1; image < at.images; ++image)
        put_directory(tail, info, at, description_bytes, image);
    write_atomically(path, [&](const fs::path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out.write(head.text().data(), static_cast<std::streamsize>(head.text().size()));
        write_pixels(out, info, source);
        out.write(tail.text().data(), static_cast<std::streamsize>(tail.text().size()));
        out.close();
        if (!out) throw OutputError(fmt::format("{}: could not be written: {}", path.string(), std::strerror(errno)));
    });
}

}  // namespace fluovox
