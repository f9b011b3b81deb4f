#pragma once

#include <tiffio.h>
#include <unistd.h>
#include <zlib.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

// Small volumes of labels as files of every kind.
namespace fluovox::testing {

constexpr std::array<int, 3> kLabelSize = {20, 17, 11};

/// Label 7 in a block with whole leaves in it, 300 in a corner, 0 elsewhere.
inline std::uint16_t label_at(int x, int y, int z) {
    if (x >= 2 && x < 19 && y >= 1 && y < 16 && z < 9) return 7;
    return x >= 18 && y >= 15 && z >= 9 ? 300 : 0;
}
constexpr int kSevens = 17 * 15 * 9;
constexpr int kThreeHundreds = 2 * 2 * 2;

template <class Sample>
std::vector<Sample> label_samples() {
    std::vector<Sample> samples;
    for (int z = 0; z < kLabelSize[2]; ++z)
        for (int y = 0; y < kLabelSize[1]; ++y)
            for (int x = 0; x < kLabelSize[0]; ++x)
                samples.push_back(static_cast<Sample>(label_at(x, y, z)));
    return samples;
}

template <class Sample>
std::string as_bytes(const std::vector<Sample>& samples) {
    const auto* const bytes = reinterpret_cast<const char*>(samples.data());  // NOLINT(*-reinterpret-cast): bytes
    return {bytes, samples.size() * sizeof(Sample)};
}

inline std::string contents(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

struct TiffStyle {
    const char* mode = "w";  ///< "wb": big endian, "w8": 64-bit offsets
    std::uint16_t compression = COMPRESSION_NONE;
    bool tiles = false;
    bool floats = false;
    std::string description = {};
    float pixels_per_unit = 0.0F;
};

inline void describe_page(TIFF* tiff, const TiffStyle& style, bool first) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kLabelSize[0]);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kLabelSize[1]);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, style.floats ? 32 : 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, style.floats ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, style.compression);
    if (style.pixels_per_unit > 0) {
        TIFFSetField(tiff, TIFFTAG_XRESOLUTION, static_cast<double>(style.pixels_per_unit));
        TIFFSetField(tiff, TIFFTAG_YRESOLUTION, static_cast<double>(style.pixels_per_unit));
        TIFFSetField(tiff, TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
    }
    if (first && !style.description.empty()) TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, style.description.c_str());
    if (style.tiles) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
    }
}

template <class Sample>
void write_rows(TIFF* tiff, int z) {
    for (int y = 0; y < kLabelSize[1]; ++y) {
        std::vector<Sample> row;
        for (int x = 0; x < kLabelSize[0]; ++x)
            row.push_back(static_cast<Sample>(label_at(x, y, z)));
        TIFFWriteScanline(tiff, row.data(), static_cast<std::uint32_t>(y), 0);
    }
}

inline void write_tiles(TIFF* tiff, int z) {
    for (int y = 0; y < kLabelSize[1]; y += 16) {
        for (int x = 0; x < kLabelSize[0]; x += 16) {
            std::vector<std::uint16_t> tile;
            for (int v = y; v < y + 16; ++v)
                for (int u = x; u < x + 16; ++u)
                    tile.push_back(u < kLabelSize[0] && v < kLabelSize[1] ? label_at(u, v, z) : std::uint16_t{9});
            TIFFWriteTile(tiff, tile.data(), static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0, 0);
        }
    }
}

/// A stack written by libtiff.
inline std::string tiff_bytes(const TiffStyle& style) {
    const auto file =
        std::filesystem::temp_directory_path() / ("fluovox_labels_" + std::to_string(::getpid()) + ".tif");
    TIFF* const tiff = TIFFOpen(file.c_str(), style.mode);
    for (int z = 0; z < kLabelSize[2]; ++z) {
        describe_page(tiff, style, z == 0);
        if (style.tiles) {
            write_tiles(tiff, z);
        } else if (style.floats) {
            write_rows<float>(tiff, z);
        } else {
            write_rows<std::uint16_t>(tiff, z);
        }
        TIFFWriteDirectory(tiff);
    }
    TIFFClose(tiff);
    std::string bytes = contents(file);
    std::filesystem::remove(file);
    return bytes;
}

inline std::string deflated(const std::string& bytes) {
    std::string out(compressBound(bytes.size()), '\0');
    uLongf size = out.size();
    const auto* const from = reinterpret_cast<const Bytef*>(bytes.data());      // NOLINT(*-reinterpret-cast): bytes
    compress(reinterpret_cast<Bytef*>(out.data()), &size, from, bytes.size());  // NOLINT(*-reinterpret-cast): bytes
    out.resize(size);
    return out;
}

/// A NRRD file; `fields` are further lines of the header.
inline std::string nrrd_bytes(const std::string& encoding, const std::string& fields,
                              const std::string& type = "uint16", std::string data = {}) {
    if (data.empty()) data = as_bytes(label_samples<std::uint16_t>());
    return "NRRD0005\n# a volume\ntype: " + type + "\ndimension: 3\nsizes: 20 17 11\nencoding: " + encoding +
           "\nendian: little\n" + fields + "\n" + (encoding == "gzip" ? deflated(data) : data);
}

}  // namespace fluovox::testing
