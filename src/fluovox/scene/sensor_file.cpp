#include "fluovox/scene/sensor_file.h"

#include "fluovox/core/text.h"
#include "fluovox/scene/read_scene.h"
#include "fluovox/scene/scene_table.h"

namespace fluovox {

SensorFile load_sensor_file(const std::filesystem::path& file) {
    const SceneTable table = SceneTable::parse(load_text(file), file.string());
    table.allow_only({"preset", "name", "quantum_efficiency", "dark_current", "spurious_charge", "full_well", "em_gain",
                      "read_noise", "gain", "offset", "bits", "exposure"});
    SensorFile result;
    Sensor& sensor = result.sensor;
    if (table.has("preset")) {
        table.choice("preset", {"ideal", "scmos", "emccd"});
        sensor = sensor_preset(table.text("preset"));
    }
    sensor.name = table.text_or("name", file.stem().string());
    constexpr NumberRange kFraction = {.min = 0, .max = 1, .without_min = true};
    if (table.is_text("quantum_efficiency")) {
        const ReadContext context{file.parent_path(), {}, {}};
        sensor.efficiency = load_table(table, "quantum_efficiency", context, {.min = 0, .max = 1});
    } else {
        sensor.quantum_efficiency = table.number_or("quantum_efficiency", sensor.quantum_efficiency, kFraction);
    }
    const NumberRange some = NumberRange::not_negative();
    const NumberRange positive = NumberRange::positive();
    sensor.dark_electrons_per_s = table.number_or("dark_current", sensor.dark_electrons_per_s, some);
    sensor.spurious_electrons = table.number_or("spurious_charge", sensor.spurious_electrons, some);
    sensor.full_well_electrons = table.number_or("full_well", sensor.full_well_electrons, positive);
    sensor.em_gain = table.number_or("em_gain", sensor.em_gain, {.min = 1, .max = 1e5});
    sensor.read_noise_electrons = table.number_or("read_noise", sensor.read_noise_electrons, some);
    sensor.counts_per_electron = table.number_or("gain", sensor.counts_per_electron, positive);
    sensor.offset_counts = table.number_or("offset", sensor.offset_counts, some);
    if (table.has("bits")) sensor.bits = static_cast<int>(table.integer("bits", 1, 16));
    if (table.has("exposure")) result.exposure_s = table.quantity("exposure", Dimension::Time, NumberRange::positive());
    return result;
}

}  // namespace fluovox
