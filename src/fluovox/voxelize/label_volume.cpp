#include "fluovox/voxelize/label_volume.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace fluovox {
namespace {

template <class Sample>
Sample sample_at(const unsigned char* samples, std::size_t number, bool swap) {
    std::array<unsigned char, sizeof(Sample)> raw{};
    std::memcpy(raw.data(), samples + number * sizeof(Sample), sizeof(Sample));
    if (swap) std::reverse(raw.begin(), raw.end());
    Sample value{};
    std::memcpy(&value, raw.data(), sizeof(Sample));
    return value;
}

template <class Sample>
void copy_integers(const unsigned char* samples, bool swap, std::span<std::uint64_t> labels) {
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const auto value = sample_at<Sample>(samples, i, swap);
        labels[i] = value > 0 ? static_cast<std::uint64_t>(value) : 0;
    }
}

template <class Sample>
void copy_floats(const unsigned char* samples, bool swap, std::span<std::uint64_t> labels, const std::string& name,
                 SamplePlace place) {
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const auto value = static_cast<double>(sample_at<Sample>(samples, i, swap));
        constexpr double kMost = 9e15;  // beyond, not every whole number is a double
        if (!(value == std::floor(value) && std::abs(value) < kMost)) {
            throw InputError(
                fmt::format("{}: the voxel ({}, {}, {}) is {:g}: labels are whole numbers; threshold or "
                            "round the volume first",
                            name, place.x + static_cast<std::int64_t>(i), place.y, place.z, value));
        }
        labels[i] = value > 0 ? static_cast<std::uint64_t>(value) : 0;
    }
}

void copy_bits(const unsigned char* samples, std::span<std::uint64_t> labels) {
    for (std::size_t i = 0; i < labels.size(); ++i)
        labels[i] = samples[i / 8] >> (7 - i % 8) & 1U;
}

}  // namespace

void to_labels(const unsigned char* samples, SampleFormat type, bool swap, std::span<std::uint64_t> labels,
               const std::string& name, SamplePlace place) {
    using Kind = SampleFormat::Kind;
    if (type.bits == 1) return copy_bits(samples, labels);
    if (type.kind == Kind::Float) {
        if (type.bits == 32) return copy_floats<float>(samples, swap, labels, name, place);
        return copy_floats<double>(samples, swap, labels, name, place);
    }
    const bool is_signed = type.kind == Kind::Signed;
    switch (type.bits) {
        case 8:
            return is_signed ? copy_integers<std::int8_t>(samples, swap, labels)
                             : copy_integers<std::uint8_t>(samples, swap, labels);
        case 16:
            return is_signed ? copy_integers<std::int16_t>(samples, swap, labels)
                             : copy_integers<std::uint16_t>(samples, swap, labels);
        case 32:
            return is_signed ? copy_integers<std::int32_t>(samples, swap, labels)
                             : copy_integers<std::uint32_t>(samples, swap, labels);
        default:
            return is_signed ? copy_integers<std::int64_t>(samples, swap, labels)
                             : copy_integers<std::uint64_t>(samples, swap, labels);
    }
}

double um_per_named_unit(std::string_view unit) {
    static constexpr std::array<std::pair<std::string_view, double>, 22> kUnits = {
        {{"um", 1},           {"\xc2\xb5m", 1},     {"\xce\xbcm", 1},    {"\xb5m", 1},
         {"\\u00b5m", 1},     {"micron", 1},        {"microns", 1},      {"micrometer", 1},
         {"micrometers", 1},  {"micrometre", 1},    {"micrometres", 1},  {"nm", 1e-3},
         {"nanometer", 1e-3}, {"nanometers", 1e-3}, {"nanometre", 1e-3}, {"nanometres", 1e-3},
         {"mm", 1e3},         {"millimeter", 1e3},  {"cm", 1e4},         {"m", 1e6},
         {"inch", 25400},     {"angstrom", 1e-4}}};
    const std::string wanted = lower_case(unit);
    for (const auto& [name, um] : kUnits)
        if (name == wanted) return um;
    return 0;
}

void require_possible_size(const LabelVolumeHeader& header, std::size_t file_bytes, double strongest,
                           const std::string& name) {
    double bytes = header.type.bits / 8.0;
    for (const std::int64_t side : header.size) {
        constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max() / 2;
        if (side < 1 || side > kMost) throw InputError(fmt::format("{}: has {} voxels along one axis", name, side));
        bytes *= static_cast<double>(side);
    }
    if (bytes <= strongest * static_cast<double>(file_bytes)) return;
    throw InputError(fmt::format("{}: is truncated or damaged: it says it holds {} x {} x {} voxels, but has {} bytes",
                                 name, header.size[0], header.size[1], header.size[2], file_bytes));
}

LabelVolumeHeader parse_label_header(const LabelVolumeFile& file) {
    if (file.bytes.empty()) throw InputError(file.name + ": is empty");
    return file.is_tiff ? parse_tiff_header(file) : parse_nrrd_header(file);
}

void read_label_slices(const LabelVolumeFile& file, const LabelVolumeHeader& header, const SliceSink& sink) {
    if (file.is_tiff) return read_tiff_slices(file, header, sink);
    read_nrrd_slices(file, header, sink);
}

}  // namespace fluovox
