#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/core/version.h"
#include "fluovox/image/imagej_metadata.h"
#include "fluovox/image/ome_xml.h"
#include "fluovox/image/stack_file.h"
#include "fluovox/image/stack_read.h"
#include "fluovox/image/tiff_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

constexpr double kClassicLimit = 4294967296.0;  // offsets of a plain TIFF have 32 bits
constexpr double kBytesPerPage = 512;           // directory and tables, rather too many

double file_bytes(const StackInfo& info, std::size_t description) {
    const double pages = static_cast<double>(info.channels.size()) * info.planes;
    return info.bytes() + kBytesPerPage * pages + static_cast<double>(description);
}

/// Writes pages one after the other.
class Pages {
public:
    Pages(fs::path shown, const fs::path& file, const char* mode, const StackInfo& info)
        : shown_(std::move(shown)), tiff_(file, mode), info_(info), values_(info.pixels()) {
        if (!tiff_.is_open()) fail();
        if (info.type == SampleType::UInt16) counts_.resize(info.pixels());
    }

    void add(const PlaneSource& source, int plane, int channel, const std::string& description) {
        source(plane, channel, values_);
        set_tags(description);
        void* data = values_.data();
        if (info_.type == SampleType::UInt16) {
            for (std::size_t i = 0; i < values_.size(); ++i)
                counts_[i] = to_count(values_[i], info_.value_per_count);
            data = counts_.data();
        }
        const auto bytes = static_cast<tmsize_t>(info_.pixels() * info_.bytes_per_sample());
        errno = 0;
        if (TIFFWriteRawStrip(tiff_.get(), 0, data, bytes) != bytes || TIFFWriteDirectory(tiff_.get()) != 1) fail();
    }

private:
    template <class... Values>
    void set(std::uint32_t tag, Values... values) {
        if (TIFFSetField(tiff_.get(), tag, values...) != 1) fail();  // NOLINT(*-vararg): the library's interface
    }

    void set_tags(const std::string& description) {
        const auto width = static_cast<std::uint32_t>(info_.width);
        const auto height = static_cast<std::uint32_t>(info_.height);
        set(TIFFTAG_SUBFILETYPE, 0);
        set(TIFFTAG_IMAGEWIDTH, width);
        set(TIFFTAG_IMAGELENGTH, height);
        set(TIFFTAG_ROWSPERSTRIP, height);
        set(TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * info_.bytes_per_sample()));
        set(TIFFTAG_SAMPLEFORMAT, info_.type == SampleType::UInt16 ? SAMPLEFORMAT_UINT : SAMPLEFORMAT_IEEEFP);
        set(TIFFTAG_SAMPLESPERPIXEL, 1);
        set(TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
        set(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        set(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
        set(TIFFTAG_XRESOLUTION, 1 / info_.pixel_um);
        set(TIFFTAG_YRESOLUTION, 1 / info_.pixel_um);
        set(TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
        if (!description.empty()) {
            set(TIFFTAG_IMAGEDESCRIPTION, description.c_str());
            set(TIFFTAG_SOFTWARE, fmt::format("fluovox {}", version()).c_str());
        }
    }

    [[noreturn]] void fail() const {
        // The library says where it failed, the system why.
        const std::string why = errno != 0 || tiff_.message().empty() ? std::strerror(errno) : tiff_.message();
        throw OutputError(fmt::format("{}: could not be written: {}", shown_.string(), why));
    }

    fs::path shown_;
    TiffFile tiff_;
    const StackInfo& info_;
    std::vector<float> values_;
    std::vector<std::uint16_t> counts_;
};

void save_pages(const fs::path& path, const StackInfo& info, const PlaneSource& source, const std::string& description,
                bool big) {
    write_atomically(path, [&](const fs::path& temporary) {
        Pages pages(path, temporary, big ? "w8l" : "wl", info);
        const auto channels = static_cast<int>(info.channels.size());
        for (int plane = 0; plane < info.planes; ++plane) {
            for (int channel = 0; channel < channels; ++channel)
                pages.add(source, plane, channel, plane == 0 && channel == 0 ? description : std::string());
        }
    });
}

/// Reads pages, quickest one after the other.
class PageReader {
public:
    // "c": the one strip of a page is not chopped into many.
    explicit PageReader(const fs::path& path) : path_(path), file_(path, "rc") {
        const auto fail = [&](const std::string& why) { throw InputError(fmt::format("{}: {}", path.string(), why)); };
        if (!file_.is_open()) fail("is no TIFF file, or damaged");
        const ImageJInfo said = description();
        if (said.stack_json.empty())
            fail(std::string("says nothing of how it was rendered: what can be read is ") + kStacksRead);
        info_ = checked_stack_info(said.stack_json, path);
        info_.scene_json = said.scene_json;
        if (!has_size()) fail("has another size than it was written with: another program has changed it");
        if (info_.type == SampleType::UInt16) counts_.resize(info_.pixels());
    }

    const StackInfo& info() const { return info_; }

    void read(int plane, int channel, std::span<float> values) {
        TIFF* tiff = file_.get();
        const auto page = static_cast<std::uint32_t>(plane) * static_cast<std::uint32_t>(info_.channels.size()) +
                          static_cast<std::uint32_t>(channel);
        const auto bytes = static_cast<tmsize_t>(info_.pixels() * info_.bytes_per_sample());
        const bool counts = info_.type == SampleType::UInt16;
        void* into = counts ? static_cast<void*>(counts_.data()) : values.data();
        // The next page is where the last one says; any other is looked for from the first page on.
        const bool found = page == TIFFCurrentDirectory(tiff) + 1U
                               ? TIFFReadDirectory(tiff) == 1
                               : TIFFSetDirectory(tiff, static_cast<tdir_t>(page)) == 1;
        const bool there = found && values.size() == info_.pixels() && TIFFNumberOfStrips(tiff) == 1 &&
                           TIFFReadEncodedStrip(tiff, 0, into, bytes) == bytes;
        if (!there)
            throw InputError(fmt::format("{}: page {} cannot be read: the file is damaged", path_.string(), page));
        for (std::size_t i = 0; counts && i < values.size(); ++i)
            values[i] = static_cast<float>(counts_[i] * info_.value_per_count);
    }

private:
    /// What the file says of itself, as OME-XML or where ImageJ keeps such things.
    ImageJInfo description() {
        TIFF* tiff = file_.get();
        const char* text = nullptr;
        TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text);  // NOLINT(*-vararg): the library's interface
        const std::string xml = text == nullptr ? std::string() : text;
        if (!xml.starts_with("ImageJ=")) return {stack_json_in(xml), scene_json_in(xml)};
        constexpr std::uint32_t kSizes = 50838;
        constexpr std::uint32_t kMetadata = 50839;
        std::uint32_t size_count = 0;
        std::uint32_t byte_count = 0;
        const std::uint32_t* sizes = nullptr;
        const char* bytes = nullptr;
        const bool there = TIFFGetField(tiff, kSizes, &size_count, &sizes) == 1 &&   // NOLINT(*-vararg)
                           TIFFGetField(tiff, kMetadata, &byte_count, &bytes) == 1;  // NOLINT(*-vararg)
        if (!there) return {};
        return imagej_info_in({bytes, byte_count}, {sizes, size_count});
    }

    bool has_size() {
        std::uint32_t width = 0;
        std::uint32_t height = 0;
        std::uint16_t bits = 0;
        TIFFGetField(file_.get(), TIFFTAG_IMAGEWIDTH, &width);    // NOLINT(*-vararg)
        TIFFGetField(file_.get(), TIFFTAG_IMAGELENGTH, &height);  // NOLINT(*-vararg)
        TIFFGetField(file_.get(), TIFFTAG_BITSPERSAMPLE, &bits);  // NOLINT(*-vararg)
        return width == static_cast<std::uint32_t>(info_.width) && height == static_cast<std::uint32_t>(info_.height) &&
               bits == 8 * info_.bytes_per_sample();
    }

    fs::path path_;
    TiffFile file_;
    StackInfo info_;
    std::vector<std::uint16_t> counts_;
};

}  // namespace

void save_ome_tiff(const fs::path& path, const StackInfo& info, const PlaneSource& source) {
    const std::string xml = ome_xml(info);
    save_pages(path, info, source, xml, file_bytes(info, xml.size()) > kClassicLimit);
}

OpenStack open_tiff_stack(const fs::path& path) {
    const auto reader = std::make_shared<PageReader>(path);
    return {reader->info(),
            [reader](int plane, int channel, std::span<float> values) { reader->read(plane, channel, values); }};
}

}  // namespace fluovox
