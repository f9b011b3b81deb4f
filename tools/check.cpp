#include "fluovox/core/quantity.h"
#include "fluovox/core/text.h"
#include "fluovox/scene/scene_description.h"
#include "fluovox/scene/stack.h"
#include "fluovox/volume/grid_info.h"

#include "commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace fluovox::tools {
namespace {

std::string length(double um) {
    return format_quantity(um, Dimension::Length);
}
std::string wavelength(double nm) {
    return format_quantity(nm, Dimension::Wavelength);
}
std::string point(Vec3 p) {
    return fmt::format("({:g}, {:g}, {:g}) um", p.x, p.y, p.z);
}

struct RegionText {
    std::string operator()(const Everywhere& /*all*/) const { return "everywhere"; }
    std::string operator()(const BoxRegion& box) const {
        return fmt::format("box from {} to {}", point(box.min), point(box.max));
    }
    std::string operator()(const SphereRegion& sphere) const {
        return fmt::format("sphere at {}, radius {}", point(sphere.center), length(sphere.radius));
    }
    std::string operator()(const CylinderRegion& cylinder) const {
        return fmt::format("cylinder from {} to {}, radius {}", point(cylinder.from), point(cylinder.to),
                           length(cylinder.radius));
    }
    std::string operator()(const SlabRegion& slab) const {
        return fmt::format("slab, {} from {} to {}", "xyz"[slab.axis], length(slab.min), length(slab.max));
    }
};

struct CoefficientText {
    std::string operator()(double per_um) const { return format_quantity(per_um, Dimension::PerLength); }
    std::string operator()(const PowerLaw& law) const {
        return fmt::format("{} at {} (exponent {})", format_quantity(law.value_per_um, Dimension::PerLength),
                           wavelength(law.at_nm), law.exponent);
    }
    std::string operator()(const Spectrum& table) const {
        return fmt::format("a table from {} to {}", wavelength(table.first_nm()), wavelength(table.last_nm()));
    }
};

std::string medium_text(const MediumDescription& medium) {
    std::string text = medium.name + ": ";
    if (medium.dye) {
        text += medium.dye->name == medium.name ? "dye, " : "dye " + medium.dye->name + ", ";
        if (!medium.grid) text += format_quantity(medium.concentration_uM, Dimension::Concentration) + ", ";
    } else {
        text += fmt::format("host, scattering {}, absorption {}, g {:g}, ",
                            std::visit(CoefficientText{}, medium.scattering),
                            std::visit(CoefficientText{}, medium.absorption), mean_cosine(medium.phase));
    }
    if (medium.refractive_index) text += fmt::format("index {:g}, ", *medium.refractive_index);
    if (!medium.grid) return text + std::visit(RegionText{}, medium.region);
    return text + "grid " + medium.grid->written + (medium.grid->name.empty() ? "" : " [" + medium.grid->name + ']');
}

struct LightText {
    std::string operator()(const SheetLight& sheet) const {
        return fmt::format("sheet at {}, {} wide, {} thick", point(sheet.position), length(sheet.width_um),
                           length(sheet.thickness_um));
    }
    std::string operator()(const BeamLight& beam) const {
        return fmt::format("beam at {}, radius {}", point(beam.position), length(beam.radius_um));
    }
    std::string operator()(const PointLight& light) const { return "point at " + point(light.position); }
    std::string operator()(const RectangleLight& light) const {
        return fmt::format("rectangle at {}, {} by {}", point(light.center), length(light.width_um),
                           length(light.height_um));
    }
    std::string operator()(const UniformLight& light) const {
        return "uniform, " + format_quantity(light.radiance_W_per_m2_sr, Dimension::Radiance);
    }
};

std::string light_text(const Light& light) {
    std::string text = std::visit(LightText{}, light.shape);
    for (const LightSpectrum::Line& line : light.spectrum.lines)
        text += ", " + wavelength(line.wavelength_nm);
    const Spectrum& continuous = light.spectrum.energy_per_nm;
    if (!continuous.empty()) {
        text += fmt::format(", {} to {}", wavelength(continuous.first_nm()), wavelength(continuous.last_nm()));
    }
    return light.power_W > 0 ? text + ", " + format_quantity(light.power_W, Dimension::Power) : text;
}

std::string camera_text(const Camera& camera) {
    const bool telecentric = camera.kind == Camera::Kind::Telecentric;
    const std::string seen = telecentric
                                 ? "telecentric, " + length(camera.field_um) + " high"
                                 : fmt::format("perspective, {:.4g} deg high", camera.fov_rad * 57.29577951308232);
    const double aperture = camera.numerical_aperture * camera.immersion_index;
    return fmt::format("{}, {} x {} pixels, at {} towards {}, in focus at {}, numerical aperture {:g}{}", seen,
                       camera.width, camera.height, point(camera.position), point(camera.target),
                       length(camera.focus_um), aperture,
                       camera.immersion_index == 1 ? "" : fmt::format(" in index {:g}", camera.immersion_index));
}

std::string film_text(const FilmSpec& film) {
    std::string text;
    if (film.is_spectral) {
        text = fmt::format("{} bins from {} to {}", film.channels.size(), wavelength(film.from_nm),
                           wavelength(film.to_nm));
    }
    for (std::size_t i = 0; !film.is_spectral && i < film.channels.size(); ++i) {
        const FilmChannel& channel = film.channels[i];
        text += fmt::format("{}{} ({} to {})", i == 0 ? "channels " : ", ", channel.name,
                            wavelength(channel.response.first_nm()), wavelength(channel.response.last_nm()));
    }
    return text + (film.unit == FilmUnit::Photons ? ", in photons" : ", in watts") +
           (film.per_dye ? ", one layer per dye" : "");
}

void print_summary(const SceneDescription& scene) {
    std::printf("%s%s%s\n", scene.file.c_str(), scene.title.empty() ? "" : ": ", scene.title.c_str());
    const auto line = [](const char* what, const std::string& text) { std::printf("  %-8s%s\n", what, text.c_str()); };
    for (const MediumDescription& medium : scene.media)
        line("medium", medium_text(medium));
    for (const LightDescription& light : scene.lights)
        line("light", light_text(light.light));
    line("camera", camera_text(scene.camera));
    line("film", film_text(scene.film));
    if (scene.stack) {
        const std::size_t views = scene.stack->views.angles_rad.size();
        line("stack",
             fmt::format("{} planes from {} to {} in steps of {}{}", plane_count(*scene.stack),
                         length(scene.stack->start_um), length(scene.stack->stop_um), length(scene.stack->step_um),
                         views > 1 ? fmt::format(", from each of {} sides", views) : ""));
    }
    const RenderDescription& render = scene.render;
    line("render", fmt::format("estimator {}, {} samples per pixel, seed {}, fluorescence orders {}", render.estimator,
                               render.samples, render.seed,
                               render.fluorescence_orders ? std::to_string(*render.fluorescence_orders) : "all"));
}

void say_remarks(const SceneDescription& scene) {
    for (const std::string& warning : scene.warnings)
        std::fprintf(stderr, "warning: %s\n", warning.c_str());
    for (const std::string& remark : scene.remarks)
        std::fprintf(stderr, "note: %s\n", remark.c_str());
}

// Looks only at the tables of contents of the grid files.
void require_grid_of(const MediumDescription& medium) {
    const GridReference& grid = *medium.grid;
    const bool by_dye = grid.name.empty() && medium.dye && list_grids(grid.file).size() > 1;
    require_grid(grid.file, by_dye ? medium.dye->name : grid.name);
}

void require_grids(const SceneDescription& scene) {
    for (const MediumDescription& medium : scene.media) {
        if (!medium.grid) continue;
        try {
            require_grid_of(medium);
        } catch (const InputError& e) {
            const SourceLocation& at = medium.grid->where;
            throw InputError(fmt::format("{}:{}:{}: {}", at.file, at.line, at.column, e.what()));
        }
    }
}

}  // namespace

ExitCode run_check(const std::vector<std::string>& arguments) {
    CommandLine line("fluovox check SCENE.toml [--print] [--set KEY=VALUE]...",
                     "  fluovox check scene.toml\n"
                     "  fluovox check scene.toml --print > resolved.json\n"
                     "  fluovox check scene.toml --set camera.resolution=[64,64] --set 'light.0.power=\"2 mW\"'\n");
    line.options().add_options()                                                                        //
        ("scene", po::value<std::string>()->value_name("SCENE.toml"), "the scene to read and resolve")  //
        ("print", po::bool_switch(), "print the scene with every default as JSON (as --json does)")     //
        ("set", po::value<std::vector<std::string>>()->value_name("KEY=VALUE"), "override a key of the scene");
    line.positional("scene", 1);
    if (!line.parse(arguments)) return ExitCode::Ok;
    if (line.values().count("scene") == 0) line.fail("the scene is missing");
    std::vector<std::string> overrides;
    if (line.values().count("set") != 0) overrides = line.values()["set"].as<std::vector<std::string>>();

    const SceneDescription scene = load_scene_description(line.values()["scene"].as<std::string>(), overrides);
    if (!line.common().quiet) say_remarks(scene);
    if (line.values()["print"].as<bool>() || line.common().json) {
        std::printf("%s\n", to_json(scene).c_str());
    } else if (!line.common().quiet) {
        print_summary(scene);
    }
    require_grids(scene);
    return ExitCode::Ok;
}

}  // namespace fluovox::tools
