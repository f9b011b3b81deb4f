#include "fluovox/image/png.h"

#include "fluovox/core/atomic_file.h"

#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <csetjmp>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

namespace fluovox {
namespace {

/// What libpng is given; libpng leaves by longjmp on an error, so nothing here may need a destructor.
struct Encoding {
    png_structp png = nullptr;
    png_infop info = nullptr;
    png_uint_32 width = 0;
    png_uint_32 height = 0;
    int bits = 8;
    const png_byte* const* rows = nullptr;
    png_textp remarks = nullptr;
    int remark_count = 0;
};

void append(png_structp png, png_bytep data, std::size_t size) {
    bool done = false;
    try {
        auto* const bytes = static_cast<std::string*>(png_get_io_ptr(png));
        bytes->insert(bytes->end(), data, data + size);
        done = true;
    } catch (const std::exception&) {  // must not pass through C
    }
    if (!done) png_error(png, "no memory");
}

void flush(png_structp /*png*/) {}
void quiet(png_structp /*png*/, png_const_charp /*message*/) {}

bool encode(const Encoding& e) {
    if (setjmp(png_jmpbuf(e.png)) != 0) return false;  // NOLINT(cert-err52-cpp): libpng's only way to fail
    png_set_IHDR(e.png, e.info, e.width, e.height, e.bits, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(e.png, e.info, PNG_sRGB_INTENT_PERCEPTUAL);
    if (e.remark_count > 0) png_set_text(e.png, e.info, e.remarks, e.remark_count);
    png_write_info(e.png, e.info);
    if (e.bits == 16) png_set_swap(e.png);  // PNG is big-endian
    // libpng 1.6 takes the rows as const only one at a time.
    for (png_uint_32 y = 0; y < e.height; ++y)
        png_write_row(e.png, e.rows[y]);
    png_write_end(e.png, e.info);
    return true;
}

std::vector<png_text> as_png_text(const PngRemarks& remarks) {
    std::vector<png_text> texts(remarks.size());
    for (std::size_t i = 0; i < remarks.size(); ++i) {
        texts[i].compression = PNG_TEXT_COMPRESSION_NONE;
        texts[i].key = const_cast<char*>(remarks[i].first.c_str());    // NOLINT(*-const-cast): read only, C API
        texts[i].text = const_cast<char*>(remarks[i].second.c_str());  // NOLINT(*-const-cast)
        texts[i].text_length = remarks[i].second.size();
    }
    return texts;
}

template <typename Sample>
std::string encode_picture(const BasicPicture<Sample>& picture, const PngRemarks& remarks) {
    const auto row_samples = 3 * static_cast<std::size_t>(std::max(picture.width, 0));
    if (picture.width <= 0 || picture.height <= 0 ||
        picture.rgb.size() != row_samples * static_cast<std::size_t>(picture.height)) {
        throw std::invalid_argument("to_png: the picture has no pixels, or not three samples for each");
    }
    std::vector<const png_byte*> rows;
    rows.reserve(static_cast<std::size_t>(picture.height));
    for (int y = 0; y < picture.height; ++y)
        rows.push_back(reinterpret_cast<const png_byte*>(picture.at(0, y)));  // NOLINT(*-reinterpret-cast): raw bytes
    std::vector<png_text> texts = as_png_text(remarks);

    std::string bytes;
    Encoding e;
    e.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, quiet);
    e.info = e.png != nullptr ? png_create_info_struct(e.png) : nullptr;
    if (e.info == nullptr) {
        png_destroy_write_struct(&e.png, nullptr);
        throw std::bad_alloc();
    }
    png_set_write_fn(e.png, &bytes, append, flush);
    e.width = static_cast<png_uint_32>(picture.width);
    e.height = static_cast<png_uint_32>(picture.height);
    e.bits = 8 * static_cast<int>(sizeof(Sample));
    e.rows = rows.data();
    e.remarks = texts.data();
    e.remark_count = static_cast<int>(texts.size());
    const bool done = encode(e);
    png_destroy_write_struct(&e.png, &e.info);
    if (!done) throw std::runtime_error("libpng could not encode the picture");
    return bytes;
}

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = at; i < at + 4; ++i)
        value = (value << 8U) | static_cast<unsigned char>(bytes[i]);
    return value;
}

}  // namespace

std::string to_png(const Picture& picture, const PngRemarks& remarks) {
    return encode_picture(picture, remarks);
}

std::string to_png(const Picture16& picture, const PngRemarks& remarks) {
    return encode_picture(picture, remarks);
}

void save_png(const std::filesystem::path& path, const Picture& picture, const PngRemarks& remarks) {
    write_text_file(path, to_png(picture, remarks));
}

void save_png(const std::filesystem::path& path, const Picture16& picture, const PngRemarks& remarks) {
    write_text_file(path, to_png(picture, remarks));
}

// A signature, then chunks: length, name, data, check sum of name and data; IEND is the last. ISO/IEC 15948.
std::optional<std::string> load_png_remark(const std::filesystem::path& path, const std::string& keyword) {
    constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
    constexpr std::size_t kAround = 12;  // bytes of a chunk beside its data
    std::ifstream in(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (bytes.compare(0, kSignature.size(), kSignature) != 0) return std::nullopt;
    std::optional<std::string> remark;
    for (std::size_t at = kSignature.size(); bytes.size() - at >= kAround;) {
        const std::size_t size = number_at(bytes, at);
        if (size > bytes.size() - at - kAround) return std::nullopt;
        const std::string_view body = std::string_view(bytes).substr(at + 4, 4 + size);
        const auto* data = reinterpret_cast<const Bytef*>(body.data());  // NOLINT(*-reinterpret-cast): bytes
        if (crc32(0, data, static_cast<uInt>(body.size())) != number_at(bytes, at + 8 + size)) return std::nullopt;
        const std::string_view text = body.substr(4);
        const bool wanted = body.substr(0, 4) == "tEXt" && text.size() > keyword.size() &&
                            text.substr(0, keyword.size()) == keyword && text[keyword.size()] == '\0';
        if (wanted) remark = std::string(text.substr(keyword.size() + 1));
        at += size + kAround;
        if (body.substr(0, 4) == "IEND") return at == bytes.size() ? remark : std::nullopt;
    }
    return std::nullopt;
}

}  // namespace fluovox
