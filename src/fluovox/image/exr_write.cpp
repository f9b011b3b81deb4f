#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/core/version.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/exr_header.h"
#include "fluovox/image/preview.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <set>
#include <stdexcept>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

/// Remembers a failed write: OpenEXR's own stream loses those of its last bytes (a full disk).
class CheckedStream final : public Imf::OStream {
public:
    explicit CheckedStream(const fs::path& path) : Imf::OStream(path.c_str()), out_(path, std::ios::binary) { check(); }

    void write(const char* bytes, int size) override {
        out_.write(bytes, size);
        check();
    }
    std::uint64_t tellp() override { return static_cast<std::uint64_t>(out_.tellp()); }
    void seekp(std::uint64_t position) override { out_.seekp(static_cast<std::streamoff>(position)); }
    void close() {
        if (out_.is_open()) out_.close();
        check();
    }
    const std::string& failure() const { return failure_; }

private:
    void check() {
        if (out_) return;
        if (failure_.empty()) failure_ = errno != 0 ? std::strerror(errno) : "writing failed";
        throw std::runtime_error(failure_);
    }

    std::ofstream out_;
    std::string failure_;
};

/// One channel of the file and where its values come from.
struct Plane {
    std::string name;
    std::function<float(int pixel)> value;
};

std::vector<Plane> make_planes(const Film& film, const FilmSpec& spec, double unit, const Preview& preview) {
    std::vector<Plane> planes;
    for (int layer = 0; layer < static_cast<int>(film.layers().size()); ++layer) {
        const std::string& layer_name = film.layers()[static_cast<std::size_t>(layer)];
        for (int channel = 0; channel < film.channels(); ++channel) {
            const FilmChannel& c = spec.channels[static_cast<std::size_t>(channel)];
            planes.push_back({exr_channel_name(spec, layer_name, c.name, false), [&film, layer, channel](int pixel) {
                                  return static_cast<float>(film.mean(layer, pixel, channel));
                              }});
            planes.push_back(
                {exr_channel_name(spec, layer_name, c.name, true), [&film, layer, channel, unit](int pixel) {
                     return stored_variance(film.variance_of_mean(layer, pixel, channel), unit);
                 }});
        }
    }
    for (int layer = 0; layer < static_cast<int>(film.layers().size()); ++layer) {
        const std::string& layer_name = film.layers()[static_cast<std::size_t>(layer)];
        planes.push_back({exr_channel_name(spec, layer_name, exr::kAllChannels, true), [&film, layer, unit](int pixel) {
                              return stored_variance(film.variance_of_mean_of_all(layer, pixel), unit);
                          }});
    }
    static constexpr std::array kPreviewNames = {"R", "G", "B"};
    const bool taken = std::any_of(planes.begin(), planes.end(), [](const Plane& plane) {
        return plane.name == "R" || plane.name == "G" || plane.name == "B";
    });
    for (std::size_t i = 0; i < 3 && !taken; ++i) {
        planes.push_back({kPreviewNames[i],
                          [&preview, i](int pixel) { return preview.rgb[3 * static_cast<std::size_t>(pixel) + i]; }});
    }
    return planes;
}

struct CountRange {
    std::int64_t least = 0;
    bool differ = false;
};

CountRange range_of_counts(const Film& film) {
    CountRange range{film.count(0), false};
    for (int pixel = 1; pixel < film.pixels(); ++pixel) {
        range.differ = range.differ || film.count(pixel) != film.count(0);
        range.least = std::min(range.least, film.count(pixel));
    }
    return range;
}

std::string radiance_units(const FilmSpec& spec) {
    const bool photons = spec.unit == FilmUnit::Photons;
    const std::string energy = photons ? "photon.s^-1" : "W";
    return energy + ".m^-2.sr^-1" + (spec.is_spectral ? ".nm^-1" : "");
}

Imf::Header make_header(const Film& film, const FilmSpec& spec, const Provenance& provenance, double unit) {
    Imf::Header header(film.width(), film.height());
    header.compression() = Imf::ZIP_COMPRESSION;
    const auto put = [&header](const char* name, const std::string& value) {
        header.insert(name, Imf::StringAttribute(value));
    };
    if (spec.is_spectral && spec.unit == FilmUnit::Watts) {
        put("spectralLayoutVersion", "1.0");
        put("emissiveUnits", "W.m^-2.sr^-1");
    }
    put(exr::kVersion, version());
    put(exr::kScene, provenance.scene_json);
    put(exr::kSeed, std::to_string(provenance.seed));
    put(exr::kSamples, std::to_string(provenance.samples));
    put(exr::kEstimator, provenance.estimator);
    put(exr::kDyes, exr::names_to_json(provenance.dyes));
    put(exr::kFilm, exr::film_to_json(spec, film.layers()));
    put(exr::kCount, std::to_string(range_of_counts(film).least));
    put(exr::kVarianceUnit, fmt::format("{}", unit));
    if (film.shares_samples()) {
        header.insert(exr::kRegionVariances, Imf::FloatVectorAttribute(stored_variances_of_regions(film, unit)));
    }
    put(exr::kNanCount, std::to_string(film.nan_count()));
    put(exr::kBoundViolations, std::to_string(film.bound_violations()));
    if (!provenance.stack_note.empty()) put(exr::kStack, provenance.stack_note);
    put(exr::kRadianceUnits, radiance_units(spec));
    return header;
}

/// Strips of lines, so that a large film is never held twice.
void write_pixels(Imf::OutputFile& file, int width, int height, const std::vector<Plane>& planes) {
    constexpr int kStrip = 64;  // a multiple of the 16 lines that are compressed together
    const auto strip_values = static_cast<std::size_t>(width) * kStrip;
    std::vector<float> strip(planes.size() * strip_values);
    for (int first = 0; first < height; first += kStrip) {
        const int rows = std::min(kStrip, height - first);
        Imf::FrameBuffer buffer;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            float* const values = strip.data() + i * strip_values;
            for (int k = 0; k < rows * width; ++k)
                values[k] = planes[i].value(first * width + k);
            const Imath::Box2i window({0, first}, {width - 1, first + rows - 1});
            buffer.insert(planes[i].name, Imf::Slice::Make(Imf::FLOAT, values, window));
        }
        file.setFrameBuffer(buffer);
        file.writePixels(rows);
    }
}

void write_file(const fs::path& temporary, const Imf::Header& header, const std::vector<Plane>& planes) {
    CheckedStream stream(temporary);
    {
        Imf::OutputFile file(stream, header);
        const Imath::Box2i& window = header.dataWindow();
        write_pixels(file, window.max.x + 1, window.max.y + 1, planes);
    }  // writes the table of lines, and swallows what goes wrong there
    if (!stream.failure().empty()) throw std::runtime_error(stream.failure());
    stream.close();
}

}  // namespace

void save_exr(const fs::path& path, const Film& film, const FilmSpec& spec, const Provenance& provenance) {
    if (static_cast<int>(spec.channels.size()) != film.channels()) {
        throw std::invalid_argument("save_exr: the film has other channels than its description");
    }
    const double unit = variance_unit(film);
    const Preview preview = make_preview(film, spec);
    std::vector<Plane> planes = make_planes(film, spec, unit, preview);
    if (range_of_counts(film).differ) {
        planes.push_back({exr::kCountChannel, [&film](int pixel) { return static_cast<float>(film.count(pixel)); }});
    }
    Imf::Header header = make_header(film, spec, provenance, unit);
    header.insert(exr::kPreview, Imf::StringAttribute(preview.exposure));
    std::set<std::string> names;
    for (const Plane& plane : planes) {
        if (!names.insert(plane.name).second) throw std::invalid_argument("save_exr: two channels " + plane.name);
        header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
    }
    write_atomically(path, [&](const fs::path& temporary) {
        try {
            write_file(temporary, header, planes);
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& e) {
            throw OutputError(path.string() + ": could not be written: " + e.what());
        }
    });
}

}  // namespace fluovox
