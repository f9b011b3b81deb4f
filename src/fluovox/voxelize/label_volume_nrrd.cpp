#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/label_volume.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

// The format: https://teem.sourceforge.net/nrrd/format.html

namespace fluovox {
namespace {

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front()))
        text.remove_prefix(1);
    while (!text.empty() && blank(text.back()))
        text.remove_suffix(1);
    return text;
}

/// Words between blanks; what is in quotes or brackets is one.
std::vector<std::string> words(std::string_view text) {
    std::vector<std::string> found;
    std::string word;
    char until = '\0';
    const auto finish = [&] {
        if (!word.empty()) found.push_back(std::exchange(word, {}));
    };
    for (const char c : text) {
        if (until != '\0') {
            if (c != until) {
                word += c;
                continue;
            }
            until = '\0';
            found.push_back(std::exchange(word, {}));
        } else if (c == '"' || c == '(') {
            finish();
            until = c == '"' ? '"' : ')';
        } else if (c == ' ' || c == '\t') {
            finish();
        } else {
            word += c;
        }
    }
    finish();
    return found;
}

class NrrdHeader {
public:
    explicit NrrdHeader(const LabelVolumeFile& file) : file_(file) {
        std::string_view rest = file.bytes;
        if (!rest.starts_with("NRRD000")) throw InputError(file.name + ":1: is not a NRRD file");
        for (long long line_number = 1;; ++line_number) {
            const auto end = rest.find('\n');
            const std::string_view line = trimmed(rest.substr(0, end));
            rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
            if (line.empty() && line_number > 1) break;
            const auto colon = line.find(": ");
            if (line_number > 1 && line.front() != '#' && line.find(":=") == std::string_view::npos) {
                if (colon == std::string_view::npos) {
                    throw InputError(fmt::format("{}:{}: is not a field of a NRRD header", file.name, line_number));
                }
                fields_[lower_case(trimmed(line.substr(0, colon)))] = trimmed(line.substr(colon + 2));
            }
            if (end == std::string_view::npos) break;
        }
        data_ = rest;
    }

    std::string_view data() const { return data_; }
    std::string field(const std::string& name) const {
        const auto at = fields_.find(name);
        return at == fields_.end() ? std::string() : at->second;
    }
    /// A field that may be written with or without a blank.
    std::string field(const std::string& name, const std::string& other) const {
        const std::string text = field(name);
        return text.empty() ? field(other) : text;
    }
    [[noreturn]] void fail(const std::string& message) const { throw InputError(file_.name + ": " + message); }

    double number(const std::string& text, const std::string& field) const {
        double value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && end == text.data() + text.size()) return value;
        fail(fmt::format("{}: \"{}\" is not a number", field, text));
    }
    std::int64_t integer(const std::string& text, const std::string& field) const {
        std::int64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error == std::errc() && end == text.data() + text.size()) return value;
        fail(fmt::format("{}: \"{}\" is not a whole number", field, text));
    }

private:
    LabelVolumeFile file_;
    std::map<std::string, std::string> fields_;
    std::string_view data_;
};

SampleFormat sample_type(const NrrdHeader& header) {
    using Kind = SampleFormat::Kind;
    static const std::map<std::string, SampleFormat> kTypes = {{"signed char", {Kind::Signed, 8}},
                                                               {"int8", {Kind::Signed, 8}},
                                                               {"int8_t", {Kind::Signed, 8}},
                                                               {"uchar", {Kind::Unsigned, 8}},
                                                               {"unsigned char", {Kind::Unsigned, 8}},
                                                               {"uint8", {Kind::Unsigned, 8}},
                                                               {"uint8_t", {Kind::Unsigned, 8}},
                                                               {"short", {Kind::Signed, 16}},
                                                               {"short int", {Kind::Signed, 16}},
                                                               {"signed short", {Kind::Signed, 16}},
                                                               {"signed short int", {Kind::Signed, 16}},
                                                               {"int16", {Kind::Signed, 16}},
                                                               {"int16_t", {Kind::Signed, 16}},
                                                               {"ushort", {Kind::Unsigned, 16}},
                                                               {"unsigned short", {Kind::Unsigned, 16}},
                                                               {"unsigned short int", {Kind::Unsigned, 16}},
                                                               {"uint16", {Kind::Unsigned, 16}},
                                                               {"uint16_t", {Kind::Unsigned, 16}},
                                                               {"int", {Kind::Signed, 32}},
                                                               {"signed int", {Kind::Signed, 32}},
                                                               {"int32", {Kind::Signed, 32}},
                                                               {"int32_t", {Kind::Signed, 32}},
                                                               {"uint", {Kind::Unsigned, 32}},
                                                               {"unsigned int", {Kind::Unsigned, 32}},
                                                               {"uint32", {Kind::Unsigned, 32}},
                                                               {"uint32_t", {Kind::Unsigned, 32}},
                                                               {"longlong", {Kind::Signed, 64}},
                                                               {"long long", {Kind::Signed, 64}},
                                                               {"long long int", {Kind::Signed, 64}},
                                                               {"signed long long", {Kind::Signed, 64}},
                                                               {"signed long long int", {Kind::Signed, 64}},
                                                               {"int64", {Kind::Signed, 64}},
                                                               {"int64_t", {Kind::Signed, 64}},
                                                               {"ulonglong", {Kind::Unsigned, 64}},
                                                               {"unsigned long long", {Kind::Unsigned, 64}},
                                                               {"unsigned long long int", {Kind::Unsigned, 64}},
                                                               {"uint64", {Kind::Unsigned, 64}},
                                                               {"uint64_t", {Kind::Unsigned, 64}},
                                                               {"float", {Kind::Float, 32}},
                                                               {"double", {Kind::Float, 64}}};
    const std::string name = lower_case(header.field("type"));
    const auto at = kTypes.find(name);
    if (at == kTypes.end()) header.fail(fmt::format("type: \"{}\" is no type of label", name));
    return at->second;
}

Vec3 vector_of(const NrrdHeader& header, const std::string& text, const std::string& field) {
    std::string spaced = text;
    std::replace(spaced.begin(), spaced.end(), ',', ' ');
    const std::vector<std::string> parts = words(spaced);
    if (parts.size() != 3) header.fail(fmt::format("{}: ({}) has not three numbers", field, text));
    Vec3 v;
    for (int axis = 0; axis < 3; ++axis)
        v[axis] = header.number(parts[static_cast<std::size_t>(axis)], field);
    return v;
}

/// Axes of the file that are the volume's x, y, z: all that are longer than one voxel, and as many others as it takes.
std::vector<std::size_t> volume_axes(const NrrdHeader& header, LabelVolumeHeader& volume) {
    const std::int64_t dimension = header.integer(header.field("dimension"), "dimension");
    const std::vector<std::string> sizes = words(header.field("sizes"));
    constexpr std::int64_t kMostAxes = 16;
    if (dimension < 2 || dimension > kMostAxes || sizes.size() != static_cast<std::size_t>(dimension)) {
        header.fail(fmt::format("is no volume: dimension {}, sizes \"{}\"", dimension, header.field("sizes")));
    }
    std::vector<std::size_t> axes;
    std::size_t spare = sizes.size() > 3 ? sizes.size() - 3 : 0;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
        if (spare > 0 && header.integer(sizes[i], "sizes") == 1) {
            --spare;
        } else {
            axes.push_back(i);
        }
    }
    if (axes.size() > 3) {
        header.fail("has more than three axes (" + header.field("sizes") +
                    "): several channels, times or layers; save the one that is wanted by itself");
    }
    volume.size = {1, 1, 1};
    for (std::size_t i = 0; i < axes.size(); ++i)
        volume.size[i] = header.integer(sizes[axes[i]], "sizes");
    return axes;
}

/// The unit that all of `names` are; 0 when there is none.
double common_unit(const NrrdHeader& header, const std::vector<std::string>& names) {
    double unit = 0;
    for (const std::string& name : names) {
        const double um = um_per_named_unit(name);
        if (um == 0) continue;
        if (unit != 0 && um != unit) header.fail("has axes in different units");
        unit = um;
    }
    return unit;
}

void read_steps(const NrrdHeader& header, const std::vector<std::size_t>& axes, LabelVolumeHeader& volume) {
    volume.missing = "how large its voxels are";
    const std::vector<std::string> directions = words(header.field("space directions"));
    const std::vector<std::string> spacings = words(header.field("spacings"));
    std::array<Vec3, 3> steps = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    if (axes.size() < 3) {
        volume.missing = "how thick its single slice is";
        return;
    }
    for (std::size_t i = 0; i < axes.size(); ++i) {
        const auto axis = static_cast<int>(i);
        if (directions.size() > axes[i] && directions[axes[i]] != "none") {
            steps[i] = vector_of(header, directions[axes[i]], "space directions");
        } else if (directions.empty() && spacings.size() > axes[i]) {
            steps[i] = Vec3{};
            steps[i][axis] = header.number(spacings[axes[i]], "spacings");
        } else {
            return;
        }
    }
    const double volume_of_step = std::abs(dot(steps[0], cross(steps[1], steps[2])));
    const double box = length(steps[0]) * length(steps[1]) * length(steps[2]);
    constexpr double kFlat = 1e-6;
    if (!(box > 0 && std::isfinite(box) && volume_of_step > kFlat * box)) {
        header.fail("has voxels of no volume: check \"" +
                    std::string(directions.empty() ? "spacings" : "space directions") + "\"");
    }
    volume.steps = steps;
    const bool in_space = !directions.empty();
    volume.um_per_unit = common_unit(header, words(header.field(in_space ? "space units" : "units")));
    if (volume.um_per_unit == 0) volume.um_per_unit = common_unit(header, words(header.field("space units")));
    volume.missing = "in which unit the size of its voxels is";
    const std::vector<std::string> origin = words(header.field("space origin"));
    if (in_space && origin.size() == 1) volume.first = vector_of(header, origin.front(), "space origin");
}

/// The bytes of the samples, from raw or compressed data, a piece at a time.
class SampleStream {
public:
    SampleStream(std::string_view data, bool compressed, std::string name)
        : data_(data), compressed_(compressed), name_(std::move(name)) {
        if (!compressed_) return;
        constexpr int kGzipOrZlib = 15 + 32;
        if (inflateInit2(&stream_, kGzipOrZlib) != Z_OK) throw InputError(name_ + ": cannot be decompressed");
    }
    SampleStream(const SampleStream&) = delete;
    SampleStream& operator=(const SampleStream&) = delete;
    ~SampleStream() {
        if (compressed_) inflateEnd(&stream_);
    }

    void read(unsigned char* bytes, std::size_t count) {
        if (!compressed_) {
            if (data_.size() < count) truncated();
            std::copy_n(data_.begin(), count, bytes);
            data_.remove_prefix(count);
            return;
        }
        while (count > 0) {
            constexpr std::size_t kPiece = 1U << 30U;
            const std::size_t in = std::min(data_.size(), kPiece);
            const std::size_t out = std::min(count, kPiece);
            // zlib takes its input by a pointer that is not const, and doesn't write there.
            stream_.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(data_.data()));  // NOLINT
            stream_.avail_in = static_cast<uInt>(in);
            stream_.next_out = bytes;
            stream_.avail_out = static_cast<uInt>(out);
            const int state = inflate(&stream_, Z_NO_FLUSH);
            const std::size_t done = out - stream_.avail_out;
            data_.remove_prefix(in - stream_.avail_in);
            bytes += done;
            count -= done;
            if (state == Z_STREAM_END && count > 0) {
                // A file may be made of several compressed parts.
                if (data_.empty() || inflateReset(&stream_) != Z_OK) truncated();
            } else if (state != Z_OK && state != Z_STREAM_END) {
                if (state == Z_BUF_ERROR) truncated();
                throw InputError(name_ + ": its compressed data are damaged");
            }
        }
    }

private:
    [[noreturn]] void truncated() const {
        throw InputError(name_ + ": is truncated: it ends before all voxels are read");
    }

    std::string_view data_;
    bool compressed_;
    std::string name_;
    z_stream stream_{};
};

/// Numbers as text.
void read_text_slices(std::string_view data, const LabelVolumeHeader& volume, const std::string& name,
                      const SliceSink& sink) {
    std::vector<std::uint64_t> labels(volume.slice_voxels());
    const auto blank = [](char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == ','; };
    for (std::int64_t z = 0; z < volume.size[2]; ++z) {
        for (std::uint64_t& label : labels) {
            while (!data.empty() && blank(data.front()))
                data.remove_prefix(1);
            double value = 0;
            const auto [end, error] = std::from_chars(data.data(), data.data() + data.size(), value);
            if (error != std::errc()) throw InputError(name + ": is truncated, or holds something that is no number");
            if (!(value == std::floor(value)) || std::abs(value) > 9e15) {
                throw InputError(fmt::format("{}: holds {:g} in slice {}: labels are whole numbers", name, value, z));
            }
            label = value > 0 ? static_cast<std::uint64_t>(value) : 0;
            data.remove_prefix(static_cast<std::size_t>(end - data.data()));
        }
        if (!sink(z, labels)) return;
    }
}

std::string_view skip_lines(std::string_view data, std::int64_t lines) {
    for (; lines > 0 && !data.empty(); --lines) {
        const auto end = data.find('\n');
        data = end == std::string_view::npos ? std::string_view() : data.substr(end + 1);
    }
    return data;
}

}  // namespace

namespace {

/// Where a header's samples are, and as what.
struct NrrdData {
    MappedBytes detached;
    std::string_view bytes;
    bool compressed = false;
    bool text = false;
};

/// Throws where they cannot be as many as the header says.
NrrdData find_data(const NrrdHeader& header, const LabelVolumeFile& file, const LabelVolumeHeader& volume) {
    NrrdData data;
    data.bytes = header.data();
    const std::string other = header.field("data file", "datafile");
    if (!other.empty()) {
        if (other.starts_with("LIST") || other.find('%') != std::string::npos) {
            header.fail("its data are in many files; join them into one first");
        }
        data.detached = MappedBytes(file.folder / other);
        data.bytes = data.detached.bytes();
    }
    const std::string encoding = lower_case(header.field("encoding"));
    data.compressed = encoding == "gzip" || encoding == "gz";
    data.text = encoding == "text" || encoding == "txt" || encoding == "ascii";
    if (!data.compressed && !data.text && encoding != "raw") {
        header.fail("encoding \"" + encoding + "\" is not known; save it as raw or gzip");
    }
    constexpr double kStrongestGzip = 1040;
    constexpr double kOneDigit = 8;
    const double strongest = data.compressed ? kStrongestGzip : (data.text ? kOneDigit : 1);
    require_possible_size(volume, data.bytes.size(), strongest, file.name);
    return data;
}

}  // namespace

LabelVolumeHeader parse_nrrd_header(const LabelVolumeFile& file) {
    const NrrdHeader header(file);
    LabelVolumeHeader volume;
    volume.type = sample_type(header);
    const std::vector<std::size_t> axes = volume_axes(header, volume);
    read_steps(header, axes, volume);
    // Now, before anybody makes room for its slices.
    find_data(header, file, volume);
    return volume;
}

void read_nrrd_slices(const LabelVolumeFile& file, const LabelVolumeHeader& volume, const SliceSink& sink) {
    const NrrdHeader header(file);
    const NrrdData found = find_data(header, file, volume);
    std::string_view data = found.bytes;
    const bool compressed = found.compressed;
    const auto skip = [&](const std::string& name, const std::string& short_name) {
        const std::string count = header.field(name, short_name);
        return count.empty() ? 0 : header.integer(count, name);
    };
    data = skip_lines(data, skip("line skip", "lineskip"));
    std::int64_t bytes_to_skip = skip("byte skip", "byteskip");
    const std::size_t slice_bytes = volume.type.bytes(volume.slice_voxels());
    if (bytes_to_skip == -1 && !compressed) {
        const std::size_t all = slice_bytes * static_cast<std::size_t>(volume.size[2]);
        bytes_to_skip = data.size() < all ? 0 : static_cast<std::int64_t>(data.size() - all);
    }
    if (bytes_to_skip < 0) header.fail("byte skip: must not be negative");
    if (found.text) return read_text_slices(data, volume, file.name, sink);

    SampleStream stream(data, compressed, file.name);
    std::vector<unsigned char> bytes;
    constexpr std::int64_t kPiece = 1 << 20;
    while (bytes_to_skip > 0) {
        bytes.resize(static_cast<std::size_t>(std::min(bytes_to_skip, kPiece)));
        stream.read(bytes.data(), bytes.size());
        bytes_to_skip -= static_cast<std::int64_t>(bytes.size());
    }
    const bool big = lower_case(header.field("endian")) == "big";
    const bool swap = big != (std::endian::native == std::endian::big);
    bytes.resize(slice_bytes);
    std::vector<std::uint64_t> labels(volume.slice_voxels());
    for (std::int64_t z = 0; z < volume.size[2]; ++z) {
        stream.read(bytes.data(), bytes.size());
        for (std::int64_t y = 0; y < volume.size[1]; ++y) {
            const auto row = static_cast<std::size_t>(y * volume.size[0]);
            const std::span to(labels.data() + row, static_cast<std::size_t>(volume.size[0]));
            to_labels(bytes.data() + volume.type.bytes(row), volume.type, swap, to, file.name, {0, y, z});
        }
        if (!sink(z, labels)) return;
    }
}

}  // namespace fluovox
