#include "fluovox/scene/scene_description.h"

#include "fluovox/core/text.h"
#include "fluovox/scene/embedded_scene.h"
#include "fluovox/scene/read_scene.h"
#include "fluovox/volume/region_nesting.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace fluovox {
namespace {

constexpr std::size_t kLargestScene = std::size_t{16} << 20;

/// sin(theta) = NA / n cannot reach 1, whatever medium the camera or light is in.
void require_apertures(const SceneTable& root, const SceneDescription& scene) {
    double index = 1;
    for (const MediumDescription& medium : scene.media)
        index = std::max(index, medium.refractive_index.value_or(1));
    const auto require = [&](const SceneTable& table) {
        constexpr const char* kKey = "numerical_aperture";
        const double immersion = table.has("immersion_index") ? table.number("immersion_index") : 1;
        if (immersion != 1 && index != 1)
            table.fail("immersion_index", "is for scenes without refractive_index: there the media say it");
        if (!table.has(kKey) || table.number(kKey) < index * immersion) return;
        if (immersion != 1) table.fail(kKey, fmt::format("must be below {}, the immersion_index", immersion));
        table.fail(kKey, fmt::format("must be below {}, the highest refractive index of the scene", index));
    };
    if (root.has("camera")) require(root.table("camera"));
    for (const SceneTable& light : root.tables("light"))
        require(light);
}

/// Where regions of different refractive index overlap in part it would not be known which one holds.
void require_nested(const SceneDescription& scene) {
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const MediumDescription& a = scene.media[j];
            const MediumDescription& b = scene.media[i];
            if (!a.refractive_index || !b.refractive_index || a.grid || b.grid) continue;
            if (*a.refractive_index == *b.refractive_index) continue;
            const char* const conflict = index_conflict(a.region, b.region);
            if (conflict == nullptr) continue;
            throw SceneError(b.where,
                             fmt::format("\"{}\" and \"{}\" {}, with different refractive indices ({} and {}); put one "
                                         "wholly inside the other, or let them only touch",
                                         a.name, b.name, conflict, *a.refractive_index, *b.refractive_index));
        }
    }
}

void warn_of_what_is_absent(SceneDescription& scene) {
    if (scene.lights.empty()) scene.warnings.emplace_back("the scene has no [[light]]: the image will be black");
    if (scene.media.empty())
        scene.warnings.emplace_back("the scene has no [[medium]]: there is nothing to see but lights");
}

}  // namespace

SceneDescription load_scene_description(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                                        SceneUse use) {
    const std::optional<std::string> of_image = embedded_scene(file);
    return parse_scene_description(of_image ? *of_image : load_text(file), file, overrides, use);
}

SceneDescription parse_scene_description(const std::string& text, const std::filesystem::path& file,
                                         const std::vector<std::string>& overrides, SceneUse use) {
    if (text.size() > kLargestScene) throw SceneError({file.string(), 0, 0}, "is larger than 16 MiB, not a scene");
    const SceneTable root = SceneTable::parse(is_scene_json(text) ? scene_file_of_json(text, file.string()) : text,
                                              file.string(), overrides);
    root.allow_only({"title", "medium", "light", "camera", "film", "stack", "render"});

    ReadContext context{file.parent_path(), {}, {}};
    SceneDescription scene;
    scene.file = file.string();
    scene.title = root.text_or("title", "");
    scene.media = read_media(root, context);
    scene.lights = read_lights(root, context);
    const bool has_view = use == SceneUse::Image || root.has("camera") || root.has("film");
    if (has_view) {
        scene.camera = read_camera(root, context);
        scene.film = read_film(root, context);
    }
    scene.stack = read_stack(root);
    scene.render = read_render(root);
    scene.remarks = std::move(context.remarks);
    scene.warnings = std::move(context.warnings);
    require_nested(scene);
    require_apertures(root, scene);
    if (has_view) {
        require_film_fits(root, scene);
        resolve_blur(root, scene);
    }
    warn_of_what_is_absent(scene);
    return scene;
}

}  // namespace fluovox
