#include "image_info.h"

#include "fluovox/core/quantity.h"
#include "fluovox/core/text.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/stack_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>

namespace fluovox::tools {
namespace {

using Json = nlohmann::ordered_json;

Json scene_of(const std::string& text) {
    const Json scene = Json::parse(text, nullptr, false);
    return scene.is_discarded() ? Json() : scene;
}

void print_json(const Json& json) {
    fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_scene(const std::string& file, const std::string& scene) {
    if (scene.empty()) throw InputError(file + ": holds no scene");
    fmt::print("{}\n", scene);
}

std::string film_text(const FilmSpec& film) {
    if (film.is_spectral)
        return fmt::format("{} bins from {:g} to {:g} nm", film.channels.size(), film.from_nm, film.to_nm);
    std::vector<std::string> names;
    for (const FilmChannel& channel : film.channels)
        names.push_back(channel.name);
    return fmt::format("channels {}", fmt::join(names, ", "));
}

Json image_json(const std::string& file, const RenderedImage& image) {
    Json channels = Json::array();
    for (const FilmChannel& channel : image.film.channels)
        channels.push_back(channel.name);
    const Provenance& from = image.provenance;
    return {{"file", file},
            {"width", image.width},
            {"height", image.height},
            {"channels", channels},
            {"unit", image.film.unit == FilmUnit::Photons ? "photons" : "watts"},
            {"layers", image.layers},
            {"estimator", from.estimator},
            {"samples", from.samples},
            {"seed", from.seed},
            {"dyes", from.dyes},
            {"fluovox_version", image.version},
            {"nan_count", image.nan_count},
            {"bound_violations", image.bound_violations},
            {"scene", scene_of(from.scene_json)}};
}

void print_image(const std::string& file, const RenderedImage& image) {
    const Provenance& from = image.provenance;
    fmt::print("{}: an image of {} x {} pixels\n", file, image.width, image.height);
    const std::string title = scene_of(from.scene_json).value("title", "");
    if (!title.empty()) fmt::print("  title         {}\n", title);
    fmt::print("  film          {}, in {}\n", film_text(image.film),
               image.film.unit == FilmUnit::Photons ? "photons" : "watts");
    fmt::print("  layers        {}\n", fmt::join(image.layers, ", "));
    if (!from.dyes.empty()) fmt::print("  dyes          {}\n", fmt::join(from.dyes, ", "));
    fmt::print("  made by       fluovox {}, estimator {}, {} samples per pixel, seed {}\n", image.version,
               from.estimator, from.samples, from.seed);
    if (image.nan_count > 0) fmt::print("  not finite    {} samples\n", image.nan_count);
    if (image.bound_violations > 0)
        fmt::print("  biased        a bound was exceeded {} times\n", image.bound_violations);
    fmt::print("  scene         inside: --scene prints it\n");
}

std::string channel_text(const StackChannel& channel) {
    std::string text = channel.name;
    if (!channel.dye.empty()) text += ", " + channel.dye;
    if (channel.excitation_nm > 0) text += fmt::format(", excited at {:g} nm", channel.excitation_nm);
    if (channel.emission_nm > 0) text += fmt::format(", seen at {:.6g} nm", channel.emission_nm);
    return text;
}

void print_stack(const std::string& file, const StackInfo& stack) {
    fmt::print("{}: a stack of {} planes of {} x {} pixels\n", file, stack.planes, stack.width, stack.height);
    if (!stack.title.empty()) fmt::print("  title         {}\n", stack.title);
    fmt::print("  voxel size    {:g} x {:g} x {:g} um\n", stack.pixel_um, stack.pixel_um, stack.step_um);
    for (const StackChannel& channel : stack.channels)
        fmt::print("  channel       {}\n", channel_text(channel));
    fmt::print("  values        {}{}{}, {}\n", stack.quantity, stack.unit.empty() ? "" : " in ", stack.unit,
               stack.type == SampleType::UInt16 ? "16 bits" : "float");
    if (stack.numerical_aperture > 0) {
        fmt::print("  aperture      {:g} in index {:g}\n", stack.numerical_aperture, stack.immersion_index);
    }
    if (stack.exposure_s > 0) fmt::print("  exposure      {}\n", format_quantity(stack.exposure_s, Dimension::Time));
    if (!stack.scene_json.empty()) fmt::print("  scene         inside: --scene prints it\n");
}

}  // namespace

bool is_image_name(const std::string& file) {
    const std::string name = lower_case(file);
    static constexpr std::array kEndings = {".exr", ".tif", ".tiff", ".zarr", ".zarr/"};
    return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* ending) { return name.ends_with(ending); });
}

void print_image_info(const CommonOptions& common, const std::string& file, bool scene) {
    std::error_code ignored;
    if (lower_case(file).ends_with(".exr") && std::filesystem::exists(file, ignored)) {
        const RenderedImage image = load_exr(file);
        if (scene) return print_scene(file, image.provenance.scene_json);
        if (common.json) return print_json(image_json(file, image));
        return print_image(file, image);
    }
    const StackFile stack(file);
    const StackInfo& info = stack.info();
    if (scene) return print_scene(file, info.scene_json);
    if (!common.json) return print_stack(file, info);
    Json json = {{"file", file}, {"stack", Json::parse(to_json(info))}};
    json["scene"] = scene_of(info.scene_json);
    print_json(json);
}

}  // namespace fluovox::tools
