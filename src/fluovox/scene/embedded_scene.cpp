#include "fluovox/scene/embedded_scene.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/stack_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <system_error>

namespace fluovox {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

bool ends_with_any(const std::string& name, std::initializer_list<const char*> endings) {
    return std::any_of(endings.begin(), endings.end(), [&](const char* ending) { return name.ends_with(ending); });
}

bool has(const Json& table, const char* key, const Json& value) {
    return table.contains(key) && table.at(key) == value;
}

// What `to_json` says besides, or says twice, and the readers of scene files would refuse.
void drop_what_is_said_for_readers(Json& scene) {
    for (Json& medium : scene["medium"]) {
        medium.erase("dye_data");
        if (medium.contains("dye") && has(medium, "name", medium["dye"])) medium.erase("name");  // so by default
        if (medium.contains("phase_function")) medium.erase("anisotropy");
    }
    for (Json& light : scene["light"]) {
        if (has(light, "pivot_deg", Json::array())) light.erase("pivot_deg");
        const bool collimated = has(light, "numerical_aperture", 0.0);
        if (collimated && !has(light, "two_sided", true) && !light.contains("pivot_deg")) light.erase("waist");
    }
    if (scene.contains("film") && scene["film"].contains("channel")) {
        for (Json& channel : scene["film"]["channel"]) {
            if (has(channel, "counts_photons", false)) channel.erase("counts_photons");
        }
    }
}

// A value of TOML in one line; keys without a value are left out.
std::string toml_of(const Json& json) {
    if (!json.is_structured()) return json.dump(-1, ' ', true, Json::error_handler_t::replace);
    std::string text = json.is_array() ? "[" : "{";
    const char* separator = " ";
    for (const auto& [key, value] : json.items()) {
        if (value.is_null()) continue;
        text += separator;
        if (json.is_object()) text += Json(key).dump() + " = ";
        text += toml_of(value);
        separator = ", ";
    }
    return text + (json.is_array() ? " ]" : " }");
}

}  // namespace

std::optional<std::string> embedded_scene(const fs::path& file) {
    std::string name = lower_case(file.string());
    while (name.ends_with('/'))
        name.pop_back();
    if (!ends_with_any(name, {".exr", ".tif", ".tiff", ".zarr"})) return std::nullopt;
    std::error_code ignored;
    const bool is_image = name.ends_with(".exr") && fs::exists(file, ignored);
    std::string scene = is_image ? load_exr(file).provenance.scene_json : StackFile(file).info().scene_json;
    if (scene.empty()) throw InputError(file.string() + ": holds no scene");
    return scene;
}

bool is_scene_json(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    return first != std::string::npos && text[first] == '{';
}

std::string scene_file_of_json(const std::string& json, const std::string& file) {
    Json scene = Json::parse(json, nullptr, false);
    if (!scene.is_object()) throw SceneError({file, 1, 1}, "begins like JSON, and is not");
    std::string text;
    try {
        drop_what_is_said_for_readers(scene);
    } catch (const Json::exception&) {
        throw SceneError({file, 1, 1}, "is JSON, but no scene as check --print writes it");
    }
    for (const auto& [key, value] : scene.items()) {
        if (!value.is_null()) text += Json(key).dump() + " = " + toml_of(value) + '\n';
    }
    return text;
}

}  // namespace fluovox
