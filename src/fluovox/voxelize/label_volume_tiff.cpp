#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/core/utf8.h"
#include "fluovox/voxelize/label_volume.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <charconv>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <utility>

// TIFF stacks, one slice a page; voxel sizes as ImageJ (in the description and the resolution of the page) and
// OME-TIFF (in XML in the description) write them.

namespace fluovox {
namespace {

/// libtiff reads from memory through these.
struct Source {
    std::string_view bytes;
    std::size_t at = 0;
    std::string complaint;
};

tmsize_t read_source(thandle_t handle, void* to, tmsize_t count) {
    auto& source = *static_cast<Source*>(handle);
    const std::size_t left = source.at < source.bytes.size() ? source.bytes.size() - source.at : 0;
    const std::size_t taken = std::min(left, static_cast<std::size_t>(count));
    std::copy_n(source.bytes.begin() + static_cast<std::ptrdiff_t>(source.bytes.size() - left), taken,
                static_cast<char*>(to));
    source.at += taken;
    return static_cast<tmsize_t>(taken);
}

tmsize_t write_source(thandle_t /*handle*/, void* /*from*/, tmsize_t /*count*/) {
    return -1;
}

toff_t seek_source(thandle_t handle, toff_t offset, int from) {
    auto& source = *static_cast<Source*>(handle);
    if (from == SEEK_CUR) offset += source.at;
    if (from == SEEK_END) offset += source.bytes.size();
    source.at = static_cast<std::size_t>(offset);
    return offset;
}

int close_source(thandle_t /*handle*/) {
    return 0;
}

toff_t source_size(thandle_t handle) {
    return static_cast<Source*>(handle)->bytes.size();
}

int note_error(TIFF* /*tiff*/, void* user, const char* /*module*/, const char* format, va_list arguments) {
    auto& source = *static_cast<Source*>(user);
    std::array<char, 300> text{};
    std::vsnprintf(text.data(), text.size(), format, arguments);
    if (source.complaint.empty()) source.complaint = text.data();
    return 1;
}

int pass_over(TIFF* /*tiff*/, void* /*user*/, const char* /*module*/, const char* /*format*/, va_list /*arguments*/) {
    return 1;
}

class TiffFile {
public:
    explicit TiffFile(const LabelVolumeFile& file) : name_(file.name), source_{file.bytes, 0, {}} {
        TIFFOpenOptions* const options = TIFFOpenOptionsAlloc();
        constexpr tmsize_t kMostAtOnce = tmsize_t{1} << 32;
        TIFFOpenOptionsSetMaxSingleMemAlloc(options, kMostAtOnce);
        TIFFOpenOptionsSetErrorHandlerExtR(options, note_error, &source_);
        TIFFOpenOptionsSetWarningHandlerExtR(options, pass_over, nullptr);
        // "m": not mapped, since it is in memory already.
        tiff_ = TIFFClientOpenExt("labels", "rm", &source_, read_source, write_source, seek_source, close_source,
                                  source_size, nullptr, nullptr, options);
        TIFFOpenOptionsFree(options);
        if (tiff_ == nullptr) fail("is not a TIFF file that can be read");
    }
    TiffFile(const TiffFile&) = delete;
    TiffFile& operator=(const TiffFile&) = delete;
    ~TiffFile() {
        if (tiff_ != nullptr) TIFFClose(tiff_);
    }

    TIFF* get() const { return tiff_; }
    template <class Value>
    Value tag(std::uint32_t number, Value otherwise) const {
        TIFFGetFieldDefaulted(tiff_, number, &otherwise);  // NOLINT(*-vararg): libtiff's way
        return otherwise;
    }
    std::string text(std::uint32_t number) const {
        char* text = nullptr;
        return TIFFGetField(tiff_, number, &text) == 1 && text != nullptr ? text : "";  // NOLINT(*-vararg)
    }
    [[noreturn]] void fail(const std::string& message) const {
        throw InputError(name_ + ": " + message +
                         (source_.complaint.empty() ? std::string() : " (" + source_.complaint + ")"));
    }
    bool complained() const { return !source_.complaint.empty(); }

private:
    std::string name_;
    Source source_;
    TIFF* tiff_ = nullptr;
};

/// What all pages must have in common.
struct PageFormat {
    std::uint32_t width = 0, height = 0;
    std::uint16_t bits = 1, kind = SAMPLEFORMAT_UINT, samples = 1, compression = COMPRESSION_NONE, photometric = 0;

    bool operator==(const PageFormat&) const = default;
};

PageFormat page_format(const TiffFile& tiff) {
    PageFormat page;
    page.width = tiff.tag<std::uint32_t>(TIFFTAG_IMAGEWIDTH, 0);
    page.height = tiff.tag<std::uint32_t>(TIFFTAG_IMAGELENGTH, 0);
    page.bits = tiff.tag<std::uint16_t>(TIFFTAG_BITSPERSAMPLE, 1);
    page.kind = tiff.tag<std::uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
    page.samples = tiff.tag<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1);
    page.compression = tiff.tag<std::uint16_t>(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
    page.photometric = tiff.tag<std::uint16_t>(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    return page;
}

/// Small pictures of the same thing, and masks of transparency, are no slices.
bool is_slice(const TiffFile& tiff) {
    return (tiff.tag<std::uint32_t>(TIFFTAG_SUBFILETYPE, 0) & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
}

SampleFormat sample_type(const TiffFile& tiff, const PageFormat& page) {
    using Kind = SampleFormat::Kind;
    if (page.samples != 1 || page.photometric == PHOTOMETRIC_RGB) {
        tiff.fail(fmt::format("has {} values a pixel: labels are one value each (a colour picture, or channels?)",
                              page.samples));
    }
    SampleFormat type;
    type.bits = page.bits;
    type.kind = page.kind == SAMPLEFORMAT_IEEEFP ? Kind::Float
                                                 : (page.kind == SAMPLEFORMAT_INT ? Kind::Signed : Kind::Unsigned);
    const bool whole = type.bits == 8 || type.bits == 16 || type.bits == 32 || type.bits == 64;
    const bool known = type.kind == Kind::Float ? type.bits >= 32 && whole : whole || type.bits == 1;
    if (!known || page.kind > SAMPLEFORMAT_VOID) tiff.fail(fmt::format("has samples of {} bits", page.bits));
    return type;
}

/// Bytes that a kind of compression can make of one; lossy ones are refused.
double strongest(const TiffFile& tiff, std::uint16_t compression) {
    switch (compression) {
        case COMPRESSION_NONE:
            return 1;
        case COMPRESSION_PACKBITS:
            return 64;
        case COMPRESSION_LZW:
        case COMPRESSION_DEFLATE:
        case COMPRESSION_ADOBE_DEFLATE:
            return 1500;
        case COMPRESSION_ZSTD:
        case COMPRESSION_LZMA:
        case COMPRESSION_CCITTRLE:
        case COMPRESSION_CCITTFAX3:
        case COMPRESSION_CCITTFAX4:
            return 50'000;
        default:
            tiff.fail(
                fmt::format("is compressed in a way (TIFF compression {}) that may change labels; save it with "
                            "none, LZW or deflate",
                            compression));
    }
}

double to_double(std::string_view text) {
    double value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

/// The value after `key` in "key=value\n" text of ImageJ; empty when there is none.
std::string_view imagej_value(std::string_view text, std::string_view key) {
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view line = text.substr(at, end - at);
        if (line.starts_with(key) && line.size() > key.size() && line[key.size()] == '=') {
            return line.substr(key.size() + 1);
        }
        at = end + 1;
    }
    return {};
}

/// A text of XML with its characters by number (`&#181;`, `&#xB5;`, as writers of plain ASCII have them) as UTF-8.
std::string without_references(std::string_view text) {
    std::string plain;
    while (!text.empty()) {
        const std::size_t end = text.starts_with("&#") ? text.find(';') : std::string_view::npos;
        const bool hexadecimal = text.size() > 2 && (text[2] == 'x' || text[2] == 'X');
        const std::size_t begin = hexadecimal ? 3 : 2;
        unsigned number = 0;
        if (end != std::string_view::npos && begin < end) {
            const auto digits = text.substr(begin, end - begin);
            std::from_chars(digits.data(), digits.data() + digits.size(), number, hexadecimal ? 16 : 10);
        }
        constexpr unsigned kLastCharacter = 0x10ffff;
        if (number > 0 && number <= kLastCharacter)
            append_utf8(plain, static_cast<char32_t>(number));
        else
            plain += text.front();
        text.remove_prefix(number > 0 && number <= kLastCharacter ? end + 1 : 1);
    }
    return plain;
}

/// An attribute of the first <Pixels> element of OME-XML; empty when there is none.
std::string_view ome_value(std::string_view text, const std::string& key) {
    for (const char* element : {"<Pixels ", "<OME:Pixels ", "<ome:Pixels "}) {
        const auto begin = text.find(element);
        if (begin == std::string_view::npos) continue;
        const std::string_view tag = text.substr(begin, text.find('>', begin) - begin);
        auto at = tag.find(' ' + key + "=\"");
        if (at == std::string_view::npos) return {};
        at += key.size() + 3;
        return tag.substr(at, tag.find('"', at) - at);
    }
    return {};
}

void set_steps(LabelVolumeHeader& volume, const Vec3& size, double um_per_unit) {
    if (!(size.x > 0 && size.y > 0 && size.z > 0)) return;
    volume.steps = std::array<Vec3, 3>{Vec3{size.x, 0, 0}, Vec3{0, size.y, 0}, Vec3{0, 0, size.z}};
    volume.um_per_unit = um_per_unit;
    volume.missing = "in which unit the size of its voxels is";
}

/// Pixels per unit, as a size; 0 when the page doesn't say.
double pixel_size(const TiffFile& tiff, std::uint32_t tag) {
    const auto resolution = static_cast<double>(tiff.tag<float>(tag, 0));
    return resolution > 0 ? 1 / resolution : 0;
}

/// Reads what ImageJ wrote; the number of slices that it names.
std::int64_t read_imagej(const TiffFile& tiff, std::string_view text, LabelVolumeHeader& volume) {
    for (const char* many : {"channels", "frames"}) {
        if (to_double(imagej_value(text, many)) > 1) {
            tiff.fail(fmt::format("has {} {}; save the one with the labels by itself",
                                  std::string(imagej_value(text, many)), many));
        }
    }
    const std::string_view unit = imagej_value(text, "unit");
    double um = um_per_named_unit(unit);
    // Without a unit of its own, that of the page's resolution.
    const auto page_unit = tiff.tag<std::uint16_t>(TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
    if (um == 0 && page_unit == RESUNIT_CENTIMETER && unit.empty()) um = um_per_named_unit("cm");
    double spacing = to_double(imagej_value(text, "spacing"));
    if (!(spacing > 0) && um > 0) volume.missing = "how far apart its slices are";
    set_steps(volume, {pixel_size(tiff, TIFFTAG_XRESOLUTION), pixel_size(tiff, TIFFTAG_YRESOLUTION), spacing}, um);
    const double images = to_double(imagej_value(text, "images"));
    constexpr double kMost = 1e9;
    return images > 0 && images < kMost ? static_cast<std::int64_t>(images) : 1;
}

std::int64_t read_ome(const TiffFile& tiff, std::string_view text, LabelVolumeHeader& volume) {
    for (const char* many : {"SizeC", "SizeT"}) {
        if (to_double(ome_value(text, many)) > 1) {
            tiff.fail(fmt::format("has {} = {}; save the channel and time with the labels by itself", many,
                                  std::string(ome_value(text, many))));
        }
    }
    Vec3 size_um;
    bool known = true;
    for (int axis = 0; axis < 3; ++axis) {
        const std::string key = std::string("PhysicalSize") + "XYZ"[axis];
        const std::string unit = without_references(ome_value(text, key + "Unit"));
        const double um = unit.empty() ? 1 : um_per_named_unit(unit);  // micrometres unless it says otherwise
        size_um[axis] = to_double(ome_value(text, key)) * (um > 0 ? um : 1);
        known = known && um > 0;
    }
    set_steps(volume, size_um, known ? 1 : 0);
    return static_cast<std::int64_t>(std::clamp(to_double(ome_value(text, "SizeZ")), 1.0, 1e9));
}

/// Decodes one page, in strips or tiles.
class PageReader {
public:
    PageReader(const TiffFile& tiff, const LabelVolumeHeader& volume, std::string name)
        : tiff_(tiff),
          volume_(volume),
          name_(std::move(name)),
          width_(static_cast<std::uint32_t>(volume.size[0])),
          height_(static_cast<std::uint32_t>(volume.size[1])) {}

    void read(std::int64_t z, std::vector<std::uint64_t>& labels) {
        const bool tiled = TIFFIsTiled(tiff_.get()) != 0;
        std::uint32_t across = width_;
        std::uint32_t down = std::min(tiff_.tag<std::uint32_t>(TIFFTAG_ROWSPERSTRIP, height_), height_);
        if (tiled) {
            across = tiff_.tag<std::uint32_t>(TIFFTAG_TILEWIDTH, 0);
            down = tiff_.tag<std::uint32_t>(TIFFTAG_TILELENGTH, 0);
        }
        if (across == 0 || down == 0) tiff_.fail("is damaged: its tiles have no size");
        const std::size_t row_bytes = volume_.type.bytes(across);
        constexpr std::size_t kMostBytes = std::size_t{1} << 32U;
        if (down > kMostBytes / row_bytes) tiff_.fail("is damaged: its strips or tiles are far too large");
        for (std::uint32_t y = 0; y < height_; y += down) {
            for (std::uint32_t x = 0; x < width_; x += across) {
                const std::uint32_t rows = tiled ? down : std::min(down, height_ - y);
                bytes_.assign(row_bytes * rows, 0);
                decode(tiled, x, y, z);
                copy(x, y, z, {across, std::min(down, height_ - y)}, labels);
                if (height_ - y <= down && width_ - x <= across) return;
                if (width_ - x <= across) break;
            }
            if (height_ - y <= down) return;
        }
    }

private:
    void decode(bool tiled, std::uint32_t x, std::uint32_t y, std::int64_t z) {
        TIFF* const tiff = tiff_.get();
        const auto size = static_cast<tmsize_t>(bytes_.size());
        const tmsize_t got = tiled ? TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, 0), bytes_.data(), size)
                                   : TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, 0), bytes_.data(), size);
        if (got != size) tiff_.fail(fmt::format("is truncated or damaged in slice {}", z));
    }
    void copy(std::uint32_t x, std::uint32_t y, std::int64_t z, std::pair<std::uint32_t, std::uint32_t> tile,
              std::vector<std::uint64_t>& labels) const {
        const auto& [across, rows] = tile;
        const std::size_t columns = std::min(across, width_ - x);
        const std::size_t row_bytes = volume_.type.bytes(across);
        for (std::uint32_t row = 0; row < rows; ++row) {
            const std::span to(labels.data() + static_cast<std::size_t>(y + row) * width_ + x, columns);
            // libtiff has swapped the bytes already.
            to_labels(bytes_.data() + row * row_bytes, volume_.type, false, to, name_, {x, y + row, z});
        }
    }

    const TiffFile& tiff_;
    const LabelVolumeHeader& volume_;
    std::string name_;
    std::uint32_t width_, height_;
    std::vector<unsigned char> bytes_;
};

/// ImageJ writes stacks over 4 GB as one page that the others follow, uncompressed.
std::uint64_t start_of_bare_slices(const TiffFile& tiff) {
    const std::uint64_t* offsets = nullptr;
    if (TIFFGetField(tiff.get(), TIFFTAG_STRIPOFFSETS, &offsets) != 1 || offsets == nullptr) {  // NOLINT(*-vararg)
        tiff.fail("is damaged: it does not say where its slices are");
    }
    return offsets[0];
}

}  // namespace

LabelVolumeHeader parse_tiff_header(const LabelVolumeFile& file) {
    const TiffFile tiff(file);
    LabelVolumeHeader volume;
    const PageFormat format = page_format(tiff);
    volume.type = sample_type(tiff, format);
    volume.missing = "how large its voxels are";
    volume.size = {format.width, format.height, 0};
    const std::string text = tiff.text(TIFFTAG_IMAGEDESCRIPTION);
    std::int64_t named = 1;
    if (text.starts_with("ImageJ=")) named = read_imagej(tiff, text, volume);
    if (text.find("Pixels ") != std::string::npos) named = read_ome(tiff, text, volume);
    const double most = strongest(tiff, format.compression);
    do {
        if (!is_slice(tiff)) continue;
        if (page_format(tiff) != format) {
            tiff.fail(fmt::format("has pages that differ in size or kind: the first and number {}", volume.size[2]));
        }
        ++volume.size[2];
    } while (TIFFReadDirectory(tiff.get()) == 1);
    if (tiff.complained()) tiff.fail("is damaged");
    if (volume.size[2] == 1 && named > 1 && format.compression == COMPRESSION_NONE && volume.type.bits >= 8) {
        volume.size[2] = named;
    }
    if (named > volume.size[2]) {
        tiff.fail(fmt::format("says it has {} slices, but {} are here", named, volume.size[2]));
    }
    require_possible_size(volume, file.bytes.size(), most, file.name);
    return volume;
}

void read_tiff_slices(const LabelVolumeFile& file, const LabelVolumeHeader& volume, const SliceSink& sink) {
    const TiffFile tiff(file);
    std::vector<std::uint64_t> labels(volume.slice_voxels());
    PageReader reader(tiff, volume, file.name);
    std::int64_t z = 0;
    do {
        if (!is_slice(tiff) || z == volume.size[2]) continue;
        reader.read(z, labels);
        if (!sink(z, labels)) return;
        ++z;
    } while (TIFFReadDirectory(tiff.get()) == 1);
    if (z == volume.size[2]) return;
    const std::uint64_t start = z == 1 ? start_of_bare_slices(tiff) : 0;
    const std::size_t slice = volume.type.bytes(volume.slice_voxels());
    const bool swap = TIFFIsByteSwapped(tiff.get()) != 0;
    for (; z < volume.size[2]; ++z) {
        const std::uint64_t at = start + static_cast<std::uint64_t>(z) * slice;
        if (start == 0 || at > file.bytes.size() || file.bytes.size() - at < slice) {
            tiff.fail(fmt::format("is truncated: slice {} of {} is not there", z, volume.size[2]));
        }
        const auto* const bytes = reinterpret_cast<const unsigned char*>(file.bytes.data() + at);  // NOLINT: bytes
        to_labels(bytes, volume.type, swap, labels, file.name, {0, 0, z});
        if (!sink(z, labels)) return;
    }
}

}  // namespace fluovox
