#include "fluovox/image/apng.h"

#include "fluovox/core/atomic_file.h"

#include <zlib.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

/// Says how many frames there are, and that they are shown for ever.
std::string animation_control(std::size_t frames) {
    constexpr std::uint32_t for_ever = 0;
    return chunk("acTL", number(static_cast<std::uint32_t>(frames)) + number(for_ever));
}

std::string frame_control(const Picture& frame, std::uint32_t sequence, int delay_ms) {
    return chunk("fcTL", number(sequence) + number(static_cast<std::uint32_t>(frame.width)) +
                             number(static_cast<std::uint32_t>(frame.height)) + number(0) + number(0) +
                             number(static_cast<std::uint32_t>(delay_ms), 2) + number(1000, 2) + number(0, 1) +
                             number(0, 1));
}

/// A chunk where it stands in a file.
struct ChunkView {
    std::string_view name, data, whole;
};

std::vector<ChunkView> chunks_of(std::string_view png) {
    std::vector<ChunkView> chunks;
    for (std::size_t at = kSignature; at + kAround <= png.size();) {
        const std::size_t size = number_at(png.substr(at));
        chunks.push_back({png.substr(at + 4, 4), png.substr(at + 8, size), png.substr(at, size + kAround)});
        at += size + kAround;
    }
    return chunks;
}

constexpr std::string_view kData = "IDAT";
constexpr std::string_view kEnd = "IEND";

/// A picture's file, but for its end, as the beginning of an animation.
std::string first_frame(const std::string& png, const std::string& control) {
    std::string out = png.substr(0, kSignature);
    bool controlled = false;
    for (const ChunkView& chunk : chunks_of(png)) {
        if (chunk.name == kData && !std::exchange(controlled, true)) out += control;
        if (chunk.name != kEnd) out += chunk.whole;
    }
    return out;
}

/// The data of a picture's file as that of a later frame.
std::string later_frame(const std::string& png, std::uint32_t& sequence) {
    std::string out;
    for (const ChunkView& part : chunks_of(png)) {
        if (part.name == kData) out += chunk("fdAT", number(sequence++) + std::string(part.data));
    }
    return out;
}

}  // namespace

std::string to_apng(const std::vector<Picture>& frames, int delay_ms) {
    if (frames.empty()) throw std::invalid_argument("an animation needs frames");
    std::string out;
    std::uint32_t sequence = 0;
    for (const Picture& frame : frames) {
        if (frame.width != frames.front().width || frame.height != frames.front().height)
            throw std::invalid_argument("the frames of an animation have one size");
        const std::string control = frame_control(frame, sequence++, delay_ms);
        if (out.empty()) {
            out = first_frame(to_png(frame), animation_control(frames.size()) + control);
        } else {
            out += control + later_frame(to_png(frame), sequence);
        }
    }
    return out + chunk(kEnd, "");
}

void save_apng(const std::filesystem::path& path, const std::vector<Picture>& frames, int delay_ms) {
    write_text_file(path, to_apng(frames, delay_ms));
}

}  // namespace fluovox
