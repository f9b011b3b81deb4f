#include "fluovox/image/apng.h"

#include "fluovox/core/atomic_file.h"

#include <zlib.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace fluovox {
namespace {

// A PNG file is a signature and chunks: length, name, data, check sum. ISO/IEC 15948; the chunks acTL, fcTL and fdAT
// as in the third edition.
constexpr std::size_t kSignature = 8;
constexpr std::size_t kAround = 12;  // bytes of a chunk beside its data

std::string number(std::uint32_t value, int bytes = 4) {
    std::string text;
    for (int i = bytes - 1; i >= 0; --i)
        text += static_cast<char>((value >> (8U * static_cast<unsigned>(i))) & 0xFFU);
    return text;
}

std::uint32_t number_at(std::string_view bytes) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value = (value << 8U) | static_cast<unsigned char>(bytes[static_cast<std::size_t>(i)]);
    return value;
}

std::string chunk(std::string_view name, const std::string& data) {
    const std::string body = std::string(name) + data;
    const auto* bytes = reinterpret_cast<const Bytef*>(body.data());  // NOLINT(*-reinterpret-cast): bytes
    const auto sum = static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(body.size())));
    return number(static_cast<std::uint32_t>(data.size())) + body + number(sum);
}

std::string frame_control(const Picture& frame, std::uint32_t sequence, int delay_ms) {
    return chunk("fcTL", number(sequence) + number(static_cast<std::uint32_t>(frame.width)) +
                             number(static_cast<std::uint32_t>(frame.height)) + number(0) + number(0) +
                             number(static_cast<std::uint32_t>(delay_ms), 2) + number(1000, 2) + number(0, 1) +
                             number(0, 1));
}

}  // namespace

std::string to_apng(const std::vector<Picture>& frames, int delay_ms) {
    if (frames.empty()) throw std::invalid_argument("an animation needs frames");
    std::string out;
    std::uint32_t sequence = 0;
    for (const Picture& frame : frames) {
        if (frame.width != frames.front().width || frame.height != frames.front().height)
            throw std::invalid_argument("the frames of an animation have one size");
        const std::string png = to_png(frame);
        const bool first = &frame == &frames.front();
        if (first) out = png.substr(0, kSignature);
        bool controlled = false;
        for (std::size_t at = kSignature; at + kAround <= png.size();) {
            const std::size_t size = number_at(std::string_view(png).substr(at));
            const std::string name = png.substr(at + 4, 4);
            const bool data = name == "IDAT";
            if (data && !controlled) {
                controlled = true;
                if (first) out += chunk("acTL", number(static_cast<std::uint32_t>(frames.size())) + number(0));
                out += frame_control(frame, sequence++, delay_ms);
            }
            if (first && name != "IEND") out += png.substr(at, size + kAround);
            if (!first && data) out += chunk("fdAT", number(sequence++) + png.substr(at + 8, size));
            at += size + kAround;
        }
    }
    return out + chunk("IEND", "");
}

void save_apng(const std::filesystem::path& path, const std::vector<Picture>& frames, int delay_ms) {
    write_text_file(path, to_apng(frames, delay_ms));
}

}  // namespace fluovox
