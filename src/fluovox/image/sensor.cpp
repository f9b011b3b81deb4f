#include "fluovox/image/sensor.h"

#include "fluovox/core/error.h"
#include "fluovox/core/rng.h"
#include "fluovox/core/text.h"
#include "fluovox/spectral/photons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace fluovox {
namespace {

/// Our keyed numbers for the distributions of the standard library.
class Bits {
public:
    using result_type = std::uint32_t;

    explicit Bits(Rng rng) : rng_(rng) {}
    static constexpr result_type min() { return 0; }
    static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }
    result_type operator()() { return static_cast<result_type>(0x1.0p32 * rng_.uniform()); }

private:
    Rng rng_;
};

constexpr std::uint64_t kStream = 0x53454e534f52ULL;  // so that noise never repeats the numbers of the rendering

std::vector<Sensor> presets() {
    Sensor ideal;
    ideal.name = "ideal";

    // Of the order of what makers of scientific cameras state for such chips.
    Sensor scmos;
    scmos.name = "scmos";
    scmos.quantum_efficiency = 0.8;
    scmos.dark_electrons_per_s = 0.06;
    scmos.full_well_electrons = 30000;
    scmos.read_noise_electrons = 1.6;
    scmos.counts_per_electron = 2.17;
    scmos.offset_counts = 100;

    Sensor emccd;
    emccd.name = "emccd";
    emccd.quantum_efficiency = 0.9;
    emccd.dark_electrons_per_s = 0.001;
    emccd.spurious_electrons = 0.005;
    emccd.full_well_electrons = 180000;
    emccd.em_gain = 300;
    emccd.read_noise_electrons = 50;
    emccd.counts_per_electron = 0.08;
    emccd.offset_counts = 500;
    return {ideal, scmos, emccd};
}

}  // namespace

Sensor sensor_preset(std::string_view name) {
    for (const Sensor& sensor : presets()) {
        if (sensor.name == name) return sensor;
    }
    throw InputError(
        fmt::format("there is no camera \"{}\"{}", name, did_you_mean(std::string(name), sensor_presets())));
}

std::vector<std::string> sensor_presets() {
    std::vector<std::string> names;
    for (const Sensor& sensor : presets())
        names.push_back(sensor.name);
    return names;
}

double photons_per_value(const StackInfo& info, int channel, double exposure_s) {
    if (info.quantity == "expected photons") return exposure_s / info.exposure_s;
    if (info.quantity != "radiance")
        throw InputError(fmt::format("a stack of {} says nothing about photons: give one of radiance", info.quantity));
    if (!(info.numerical_aperture > 0)) {
        throw InputError(
            "a camera without an aperture (camera.numerical_aperture = 0) collects no light: give the "
            "scene one");
    }
    const StackChannel& seen = info.channels[static_cast<std::size_t>(channel)];
    const double sine = info.numerical_aperture / info.immersion_index;
    const double pixel_m = info.pixel_um * 1e-6;
    double photons = std::numbers::pi * sine * sine * pixel_m * pixel_m * exposure_s;
    if (seen.width_nm > 0) photons *= seen.width_nm;
    if (!seen.counts_photons) photons /= photon_energy_J(seen.light_nm());
    return photons;
}

Exposed expose(const Sensor& sensor, const Exposure& exposure, const PixelPlace& place) {
    Bits bits(Rng(place.seed ^ kStream, place.page, place.pixel));
    const double mean = std::max(0.0, exposure.photons) * exposure.efficiency +
                        sensor.dark_electrons_per_s * exposure.seconds + sensor.spurious_electrons;
    Exposed result;
    constexpr double kMostCounted = 1e15;  // beyond, the distribution's whole numbers end
    if (mean > kMostCounted) {
        result.electrons = mean;
    } else if (mean > 0) {
        result.electrons = static_cast<double>(std::poisson_distribution<long long>(mean)(bits));
    }
    if (result.electrons >= sensor.full_well_electrons) {
        result.electrons = sensor.full_well_electrons;
        result.is_full = true;
    }
    double read = result.electrons;
    // Multiplied electrons: Basden, Haniff & Mackay, Mon. Not. R. Astron. Soc. 345 (2003) 985.
    if (sensor.em_gain > 1 && read > 0) read = std::gamma_distribution<double>(read, sensor.em_gain)(bits);
    if (sensor.read_noise_electrons > 0) read += std::normal_distribution<double>(0, sensor.read_noise_electrons)(bits);
    const double most = std::ldexp(1.0, sensor.bits) - 1;
    const double count = std::round(read * sensor.counts_per_electron + sensor.offset_counts);
    result.is_full = result.is_full || count >= most;
    result.count = static_cast<std::uint16_t>(std::clamp(count, 0.0, most));
    return result;
}

}  // namespace fluovox
