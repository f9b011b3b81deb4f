#include "fluovox/image/sensor.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/progress.h"
#include "fluovox/core/quantity.h"
#include "fluovox/image/stack_file.h"
#include "fluovox/scene/sensor_file.h"

#include "commands.h"
#include "render_stack.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExamples =
    "  fluovox sensor stack.ome.tif -o noisy.ome.tif --camera scmos --exposure 20ms\n"
    "  fluovox sensor stack.ome.tif -o noisy2.ome.tif --camera mycamera.toml --seed 2    another realisation\n"
    "  fluovox sensor stack.ome.zarr -o noisy.ome.zarr --camera emccd\n"
    "  fluovox sensor stack.exr -o noisy.tif --camera emccd --format imagej     of stack-0000.exr, stack-0001.exr "
    "...\n";

struct Camera {
    Sensor sensor;
    double exposure_s = 0;
};

/// A preset by its name, otherwise a file; the exposure from the option, the file or the stack.
Camera choose_camera(const CommandLine& line, const StackInfo& stack) {
    const std::string wanted = line.values()["camera"].as<std::string>();
    const std::vector<std::string> presets = sensor_presets();
    Camera camera;
    std::optional<double> exposure_s;
    if (std::find(presets.begin(), presets.end(), wanted) != presets.end()) {
        camera.sensor = sensor_preset(wanted);
    } else if (!fs::exists(wanted) && fs::path(wanted).extension().empty()) {
        line.fail(fmt::format("--camera \"{}\" is neither a file nor one of: {}", wanted, fmt::join(presets, ", ")));
    } else {
        const SensorFile file = load_sensor_file(wanted);
        camera.sensor = file.sensor;
        exposure_s = file.exposure_s;
    }
    if (line.values().count("exposure") > 0) {
        try {
            exposure_s = parse_quantity(line.values()["exposure"].as<std::string>(), Dimension::Time);
        } catch (const std::invalid_argument& e) {
            line.fail(fmt::format("--exposure: {}", e.what()));
        }
        if (!(*exposure_s > 0)) line.fail("--exposure must be above 0");
    }
    camera.exposure_s = exposure_s.value_or(stack.exposure_s);
    if (!(camera.exposure_s > 0))
        line.fail("how long is the exposure? The stack does not say (camera.exposure): add --exposure 20ms");
    return camera;
}

/// What a camera makes of a stack, page by page.
class Exposure {
public:
    Exposure(StackFile& stack, const Camera& camera, std::uint64_t seed)
        : stack_(&stack), camera_(&camera), seed_(seed) {}

    void operator()(int plane, int channel, std::span<float> values) {
        stack_->read(plane, channel, values);
        const StackInfo& info = stack_->info();
        const StackChannel& seen = info.channels[static_cast<std::size_t>(channel)];
        const double photons = photons_per_value(info, channel, camera_->exposure_s);
        const double efficiency = seen.has_efficiency ? 1 : camera_->sensor.efficiency_at(seen.light_nm());
        const auto page =
            static_cast<std::uint64_t>(plane) * info.channels.size() + static_cast<std::uint64_t>(channel);
        const float brightest = *std::max_element(values.begin(), values.end());
        most_electrons_ = std::max(most_electrons_, efficiency * photons * static_cast<double>(brightest));
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, values.size(), 1024), [&](const auto& range) {
            std::int64_t full = 0;
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const Exposed pixel =
                    expose(camera_->sensor, {photons * static_cast<double>(values[i]), efficiency, camera_->exposure_s},
                           {seed_, page, i});
                values[i] = pixel.count;
                full += pixel.is_full ? 1 : 0;
            }
            full_ += full;
        });
        pixels_ += static_cast<std::int64_t>(values.size());
    }

    double full_share() const {
        return pixels_ > 0 ? static_cast<double>(full_.load()) / static_cast<double>(pixels_) : 0;
    }

    /// That brings the brightest pixel to four fifths of what the sensor can hold.
    double better_exposure_s() const {
        const Sensor& sensor = camera_->sensor;
        const double range = (std::ldexp(1.0, sensor.bits) - 1 - sensor.offset_counts) / sensor.counts_per_electron;
        return camera_->exposure_s * 0.8 * std::min(sensor.full_well_electrons, range / sensor.em_gain) /
               most_electrons_;
    }

private:
    StackFile* stack_;
    const Camera* camera_;
    std::uint64_t seed_;
    std::atomic<std::int64_t> full_ = 0;
    std::int64_t pixels_ = 0;
    double most_electrons_ = 0;  // expected, of the brightest pixel
};

StackInfo info_of_counts(const StackInfo& stack, const Camera& camera, std::uint64_t seed) {
    StackInfo info = stack;
    info.quantity = fmt::format("counts of camera {}, noise seed {}", camera.sensor.name, seed);
    info.unit = "";
    info.type = SampleType::UInt16;
    info.value_per_count = 1;
    info.significant_bits = camera.sensor.bits;
    info.max_value = (1 << camera.sensor.bits) - 1;
    info.exposure_s = camera.exposure_s;
    info.key = fmt::format("{} sensor {} {}", stack.key, camera.sensor.name, seed);
    return info;
}

}  // namespace

ExitCode run_sensor(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox sensor STACK -o NOISY.ome.tif --camera scmos|emccd|ideal|FILE [options]", kExamples);
    auto add = line.options().add_options();
    add("stack", po::value<std::string>()->value_name("STACK"),
        "a stack of radiance or expected photons that render wrote: .ome.tif, .tif of ImageJ, .ome.zarr, planes of "
        ".exr");
    add("output,o", po::value<std::string>()->value_name("NOISY.ome.tif"), "the counts; .ome.zarr likewise");
    add("camera", po::value<std::string>()->value_name("NAME|FILE"), "a preset (scmos, emccd, ideal) or a TOML file");
    add("exposure", po::value<std::string>()->value_name("TIME"), "instead of the camera file's or the stack's: 20ms");
    add("seed", po::value<std::int64_t>()->default_value(1)->value_name("N"),
        "of the noise: another one, another image");
    add("format", po::value<std::string>()->value_name("NAME"), "ome-tiff, imagej or ome-zarr (default: by the name)");
    line.positional("stack", 1);
    if (!line.parse(arguments)) return ExitCode::Ok;
    if (line.values().count("stack") == 0) line.fail("which stack?");
    if (line.values().count("output") == 0) line.fail("where to? -o NOISY.ome.tif");
    if (line.values().count("camera") == 0) line.fail("which camera? --camera scmos");
    const fs::path output = line.values()["output"].as<std::string>();
    const std::optional<StackFormat> format = stack_format(line, output);
    if (!format || *format == StackFormat::Exr) line.fail("the counts are written as .ome.tif or .ome.zarr");
    if (*format == StackFormat::OmeZarr) {
        require_replaceable_zarr(output);
    } else {
        require_writable(output);
    }

    StackFile stack(line.values()["stack"].as<std::string>());
    const Camera camera = choose_camera(line, stack.info());
    const auto seed = static_cast<std::uint64_t>(line.at_least("seed", 0));
    StackInfo info = info_of_counts(stack.info(), camera, seed);
    Exposure exposure(stack, camera, seed);
    const PlaneSource source = [&](int plane, int channel, std::span<float> values) {
        exposure(plane, channel, values);
    };
    if (*format == StackFormat::OmeTiff) save_ome_tiff(output, info, source);
    if (*format == StackFormat::ImageJ) save_imagej_tiff(output, info, source);
    if (*format == StackFormat::OmeZarr) save_ome_zarr(output, info, source);
    constexpr double kWorthSaying = 1e-3;
    if (exposure.full_share() > kWorthSaying) {
        warn(line.common(),
             fmt::format(
                 "{:.3g} % of the pixels are saturated (full well {:.6g} electrons, {} bits): lower the exposure "
                 "from {} to about {:.2g} s",
                 100 * exposure.full_share(), camera.sensor.full_well_electrons, camera.sensor.bits,
                 format_quantity(camera.exposure_s, Dimension::Time), exposure.better_exposure_s()));
    }
    if (line.common().json) {
        const nlohmann::ordered_json json = {{"outputs", {output.string()}},
                                             {"camera", camera.sensor.name},
                                             {"exposure_s", camera.exposure_s},
                                             {"seed", seed},
                                             {"saturated_share", exposure.full_share()}};
        fmt::print("{}\n", json.dump(2));
    } else {
        fmt::print("{}\n", output.string());
    }
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
