#include "fluovox/image/stack_info.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace fluovox {

namespace {
using Json = nlohmann::ordered_json;
}

std::string to_json(const StackInfo& info) {
    Json channels = Json::array();
    for (const StackChannel& channel : info.channels) {
        channels.push_back({{"name", channel.name},
                            {"dye", channel.dye},
                            {"excitation_nm", channel.excitation_nm},
                            {"emission_nm", channel.emission_nm},
                            {"width_nm", channel.width_nm},
                            {"counts_photons", channel.counts_photons},
                            {"has_efficiency", channel.has_efficiency},
                            {"rgb", channel.rgb},
                            {"photon_nm", channel.photon_nm}});
    }
    Json positions = Json::array();
    for (const Vec3 p : info.positions_um)
        positions.push_back({p.x, p.y, p.z});
    Json origin = nullptr;
    if (info.origin_um) origin = {info.origin_um->x, info.origin_um->y, info.origin_um->z};
    const Json json = {{"title", info.title},
                       {"size", {info.width, info.height, info.planes}},
                       {"channels", channels},
                       {"pixel_um", info.pixel_um},
                       {"step_um", info.step_um},
                       {"positions_um", positions},
                       {"origin_um", origin},
                       {"angle_deg", info.angle_deg},
                       {"numerical_aperture", info.numerical_aperture},
                       {"immersion_index", info.immersion_index},
                       {"blur_um", info.blur_um},
                       {"exposure_s", info.exposure_s},
                       {"quantity", info.quantity},
                       {"unit", info.unit},
                       {"type", info.type == SampleType::UInt16 ? "uint16" : "float32"},
                       {"value_per_count", info.value_per_count},
                       {"significant_bits", info.significant_bits},
                       {"max_value", info.max_value},
                       {"key", info.key}};
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

StackInfo stack_info_from_json(const std::string& text) {
    const Json json = Json::parse(text);
    StackInfo info;
    info.title = json.at("title");
    info.width = json.at("size").at(0);
    info.height = json.at("size").at(1);
    info.planes = json.at("size").at(2);
    for (const Json& channel : json.at("channels")) {
        info.channels.push_back({channel.at("name"), channel.at("dye"), channel.at("excitation_nm"),
                                 channel.at("emission_nm"), channel.at("width_nm"), channel.at("counts_photons"),
                                 channel.at("has_efficiency"), channel.at("rgb"), channel.value("photon_nm", 0.0)});
    }
    for (const Json& p : json.at("positions_um"))
        info.positions_um.push_back({p.at(0), p.at(1), p.at(2)});
    info.pixel_um = json.at("pixel_um");
    info.step_um = json.at("step_um");
    const Json origin = json.value("origin_um", Json());
    if (!origin.is_null()) info.origin_um = Vec3{origin.at(0), origin.at(1), origin.at(2)};
    info.angle_deg = json.at("angle_deg");
    info.numerical_aperture = json.at("numerical_aperture");
    info.immersion_index = json.at("immersion_index");
    info.blur_um = json.at("blur_um");
    info.exposure_s = json.at("exposure_s");
    info.quantity = json.at("quantity");
    info.unit = json.at("unit");
    info.type = json.at("type") == "uint16" ? SampleType::UInt16 : SampleType::Float32;
    info.value_per_count = json.at("value_per_count");
    info.significant_bits = json.at("significant_bits");
    info.max_value = json.at("max_value");
    info.key = json.at("key");
    return info;
}

std::uint16_t to_count(float value, double value_per_count) {
    const double count = std::round(static_cast<double>(value) / value_per_count);
    return static_cast<std::uint16_t>(std::min(std::fmax(count, 0.0), 65535.0));  // fmax makes 0 of a NaN
}

}  // namespace fluovox
