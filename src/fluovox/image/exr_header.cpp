#include "fluovox/image/exr_header.h"

#include "fluovox/image/exr.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <stdexcept>

namespace fluovox {
namespace {

// A dot separates layers in EXR, so it cannot be part of a name.
std::string undotted(std::string name) {
    std::replace(name.begin(), name.end(), '.', '_');
    return name;
}

std::string base_of_total(const FilmSpec& spec) {
    if (!spec.is_spectral) return "";
    return spec.unit == FilmUnit::Photons ? "photons." : "S0.";
}

}  // namespace

std::string exr_channel_name(const FilmSpec& spec, const std::string& layer, const std::string& channel,
                             bool variance) {
    std::string prefix;
    if (layer == kTotalLayer) {
        prefix = variance ? "" : base_of_total(spec);
    } else if (layer == kElasticLayer || layer == kFluorescenceLayer) {
        prefix = layer + ".";
    } else {
        prefix = "dye." + undotted(layer) + ".";
    }
    const std::string name = channel == exr::kAllChannels ? channel : undotted(channel);
    return (variance ? "variance." : "") + prefix + name;
}

namespace exr {

using nlohmann::json;

std::string film_to_json(const FilmSpec& spec, const std::vector<std::string>& layers) {
    json channels = json::array();
    for (const FilmChannel& channel : spec.channels) {
        channels.push_back(
            {{"name", channel.name},
             {"center_nm", channel.center_nm},
             {"counts_photons", channel.counts_photons},
             {"response",
              {{"wavelengths_nm", channel.response.wavelengths_nm()}, {"values", channel.response.values()}}}});
    }
    const json film = {{"spectral", spec.is_spectral}, {"from_nm", spec.from_nm},
                       {"to_nm", spec.to_nm},          {"unit", spec.unit == FilmUnit::Photons ? "photons" : "watts"},
                       {"per_dye", spec.per_dye},      {"layers", layers},
                       {"channels", channels}};
    return film.dump(-1, ' ', false, json::error_handler_t::replace);
}

FilmAndLayers film_from_json(const std::string& text) {
    const json film = json::parse(text);
    FilmAndLayers result;
    result.layers = film.at("layers").get<std::vector<std::string>>();
    FilmSpec& spec = result.spec;
    spec.is_spectral = film.at("spectral").get<bool>();
    spec.from_nm = film.at("from_nm").get<double>();
    spec.to_nm = film.at("to_nm").get<double>();
    spec.unit = film.at("unit").get<std::string>() == "photons" ? FilmUnit::Photons : FilmUnit::Watts;
    spec.per_dye = film.at("per_dye").get<bool>();
    for (const json& entry : film.at("channels")) {
        FilmChannel channel;
        channel.name = entry.at("name").get<std::string>();
        channel.center_nm = entry.at("center_nm").get<double>();
        channel.counts_photons = entry.at("counts_photons").get<bool>();
        auto wavelengths_nm = entry.at("response").at("wavelengths_nm").get<std::vector<double>>();
        auto values = entry.at("response").at("values").get<std::vector<double>>();
        if (!values.empty()) channel.response = Spectrum(std::move(wavelengths_nm), std::move(values));
        spec.channels.push_back(std::move(channel));
    }
    if (result.layers.empty() || spec.channels.empty()) throw std::invalid_argument("no layers or channels");
    return result;
}

std::string names_to_json(const std::vector<std::string>& names) {
    return json(names).dump(-1, ' ', false, json::error_handler_t::replace);
}

std::vector<std::string> names_from_json(const std::string& text) {
    return json::parse(text).get<std::vector<std::string>>();
}

}  // namespace exr
}  // namespace fluovox
