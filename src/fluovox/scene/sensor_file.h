#pragma once

#include "fluovox/image/sensor.h"

#include <filesystem>
#include <optional>

namespace fluovox {

/// A camera file: the sensor, and the exposure where the file says one.
struct SensorFile {
    Sensor sensor;
    std::optional<double> exposure_s;
};

/// Reads a TOML file: `preset` (another's values to start from), `name`, `quantum_efficiency` (a number, or a CSV file
/// of wavelength and efficiency), `dark_current` (electrons per second), `spurious_charge`, `full_well`, `em_gain`,
/// `read_noise` (all in electrons), `gain` (counts per electron), `offset` (counts), `bits`, `exposure` ("20 ms").
/// Throws SceneError with the place of what is wrong, InputError for a file that cannot be read.
SensorFile load_sensor_file(const std::filesystem::path& file);

}  // namespace fluovox
