#include "fluovox/core/quantity.h"
#include "fluovox/medium/dye_library.h"
#include "fluovox/scene/scene_description.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace fluovox {
namespace {

// Keys stand in the order of the scene file's documentation and quantities carry their unit, so that the text can be
// read beside a scene file.
using Json = nlohmann::ordered_json;

Json length(double um) {
    return format_quantity(um, Dimension::Length);
}
Json wavelength(double nm) {
    return format_quantity(nm, Dimension::Wavelength);
}
Json point(Vec3 p) {
    return {length(p.x), length(p.y), length(p.z)};
}
Json vector(Vec3 v) {
    return {v.x, v.y, v.z};
}

// What has no value is said too: null.
template <class T>
Json optional(const std::optional<T>& value) {
    return value ? Json(*value) : Json();
}

Json table(const Spectrum& spectrum) {
    return {{"wavelength_nm", spectrum.wavelengths_nm()}, {"value", spectrum.values()}};
}

Json band(double from_nm, double to_nm) {
    return {{"from", wavelength(from_nm)}, {"to", wavelength(to_nm)}};
}

bool is_flat(const Spectrum& spectrum) {
    const std::vector<double>& values = spectrum.values();
    return values.size() == 2 && values[0] == values[1];
}

// A flat piece of spectrum is a band, everything else a table.
Json band_or_table(const Spectrum& spectrum) {
    if (is_flat(spectrum)) return band(spectrum.first_nm(), spectrum.last_nm());
    return {{"table", table(spectrum)}};
}

struct RegionText {
    Json operator()(const Everywhere& /*all*/) const { return "everywhere"; }
    Json operator()(const BoxRegion& box) const {
        return {{"box", {{"min", point(box.min)}, {"max", point(box.max)}}}};
    }
    Json operator()(const SphereRegion& sphere) const {
        return {{"sphere", {{"center", point(sphere.center)}, {"radius", length(sphere.radius)}}}};
    }
    Json operator()(const CylinderRegion& cylinder) const {
        return {{"cylinder",
                 {{"from", point(cylinder.from)}, {"to", point(cylinder.to)}, {"radius", length(cylinder.radius)}}}};
    }
    Json operator()(const SlabRegion& slab) const {
        Json json = {{"axis", std::string(1, "xyz"[slab.axis])}};
        if (std::isfinite(slab.min)) json["min"] = length(slab.min);
        if (std::isfinite(slab.max)) json["max"] = length(slab.max);
        return {{"slab", json}};
    }
};

struct CoefficientText {
    Json operator()(double per_um) const { return format_quantity(per_um, Dimension::PerLength); }
    Json operator()(const PowerLaw& law) const {
        return {{"at", wavelength(law.at_nm)},
                {"value", format_quantity(law.value_per_um, Dimension::PerLength)},
                {"exponent", law.exponent}};
    }
    Json operator()(const Spectrum& spectrum) const { return {{"table", table(spectrum)}, {"unit", "/um"}}; }
};

Json grid_json(const GridReference& grid) {
    Json json = {{"file", grid.written}};
    if (!grid.name.empty()) json["name"] = grid.name;
    if (grid.uM_per_value) json["unit"] = format_quantity(*grid.uM_per_value, Dimension::Concentration);
    if (grid.um_per_length) json["length_unit"] = length(*grid.um_per_length);
    json["scale"] = grid.scale;
    return json;
}

/// What stands behind the dye's name. The library's spectra are not repeated, a user's are.
Json dye_json(const Dye& dye) {
    Json json = {{"id", dye.id},
                 {"quantum_yield", dye.quantum_yield},
                 {"extinction", format_quantity(dye.molar_absorption_per_M_cm.max(), Dimension::Extinction)},
                 {"excitation_peak", wavelength(dye.molar_absorption_per_M_cm.peak_nm())},
                 {"emission_peak", wavelength(dye.emission_per_nm.peak_nm())},
                 {"source", dye.source},
                 {"licence", dye.licence}};
    if (find_dye(dye.id)) return json;
    json["molar_absorption_per_M_cm"] = table(dye.molar_absorption_per_M_cm);
    json["emission_photons_per_nm"] = table(dye.emission_per_nm);
    return json;
}

struct PhaseText {
    Json operator()(const HenyeyGreenstein& p) const { return {{"kind", "henyey-greenstein"}, {"g", p.g}}; }
    Json operator()(const TwoTermHenyeyGreenstein& p) const {
        return {{"kind", "two-term-henyey-greenstein"}, {"g1", p.g1}, {"g2", p.g2}, {"weight", p.weight}};
    }
    Json operator()(const Rayleigh& /*p*/) const { return "rayleigh"; }
    Json operator()(const PhaseTable& p) const {
        return {{"kind", "table"}, {"cosine", p.cosines()}, {"value", p.values_per_sr()}};
    }
};

Json medium_json(const MediumDescription& medium) {
    Json json = {{"name", medium.name}};
    if (medium.dye) {
        json["dye"] = medium.dye->name;
        json["dye_data"] = dye_json(*medium.dye);
        if (!medium.grid) json["concentration"] = format_quantity(medium.concentration_uM, Dimension::Concentration);
    } else {
        json["scattering"] = std::visit(CoefficientText{}, medium.scattering);
        json["absorption"] = std::visit(CoefficientText{}, medium.absorption);
        json["anisotropy"] = mean_cosine(medium.phase);
        json["phase_function"] = std::visit(PhaseText{}, medium.phase);
    }
    if (medium.grid) {
        json["grid"] = grid_json(*medium.grid);
        return json;
    }
    json["region"] = std::visit(RegionText{}, medium.region);
    json["refractive_index"] = optional(medium.refractive_index);
    json["exclusive"] = medium.exclusive;
    return json;
}

Json profile(BeamProfile profile) {
    return profile == BeamProfile::Gaussian ? "gaussian" : "box";
}

std::vector<double> degrees(std::vector<double> angles) {
    for (double& angle : angles)
        angle *= 180 / std::numbers::pi;
    return angles;
}

struct LightText {
    Json operator()(const SheetLight& sheet) const {
        return {{"kind", "sheet"},
                {"position", point(sheet.position)},
                {"direction", vector(sheet.direction)},
                {"normal", vector(sheet.normal)},
                {"width", length(sheet.width_um)},
                {"thickness", length(sheet.thickness_um)},
                {"profile", profile(sheet.profile)},
                {"two_sided", sheet.two_sided},
                {"pivot_deg", degrees(sheet.pivots_rad)},
                {"numerical_aperture", sheet.numerical_aperture},
                {"waist", point(sheet.waist)}};
    }
    Json operator()(const BeamLight& beam) const {
        return {{"kind", "beam"},
                {"position", point(beam.position)},
                {"direction", vector(beam.direction)},
                {"radius", length(beam.radius_um)},
                {"profile", profile(beam.profile)},
                {"numerical_aperture", beam.numerical_aperture},
                {"waist", point(beam.waist)}};
    }
    Json operator()(const PointLight& light) const { return {{"kind", "point"}, {"position", point(light.position)}}; }
    Json operator()(const RectangleLight& light) const {
        return {{"kind", "rectangle"},
                {"center", point(light.center)},
                {"normal", vector(light.normal)},
                {"up", vector(light.up)},
                {"size", {length(light.width_um), length(light.height_um)}}};
    }
    Json operator()(const UniformLight& light) const {
        return {{"kind", "uniform"}, {"radiance", format_quantity(light.radiance_W_per_m2_sr, Dimension::Radiance)}};
    }
};

Json light_json(const Light& light) {
    Json json = std::visit(LightText{}, light.shape);
    if (light.spectrum.energy_per_nm.empty() && light.spectrum.lines.size() == 1) {
        json["wavelength"] = wavelength(light.spectrum.lines.front().wavelength_nm);
    } else {
        json["spectrum"] = band_or_table(light.spectrum.energy_per_nm);
    }
    if (!std::holds_alternative<UniformLight>(light.shape)) {
        json["power"] = format_quantity(light.power_W, Dimension::Power);
    }
    return json;
}

Json camera_json(const Camera& camera) {
    const bool telecentric = camera.kind == Camera::Kind::Telecentric;
    Json json = {{"kind", telecentric ? "telecentric" : "perspective"},
                 {"position", point(camera.position)},
                 {"target", point(camera.target)},
                 {"up", vector(camera.up)},
                 {"focus", length(camera.focus_um)}};
    if (telecentric) {
        json["field"] = length(camera.field_um);
    } else {
        json["fov_deg"] = camera.fov_rad * 180 / std::numbers::pi;
    }
    json["resolution"] = {camera.width, camera.height};
    json["numerical_aperture"] = camera.numerical_aperture * camera.immersion_index;
    json["immersion_index"] = camera.immersion_index;
    json["blur"] = length(camera.blur_um);
    json["exposure"] = camera.exposure_s > 0 ? Json(format_quantity(camera.exposure_s, Dimension::Time)) : Json();
    return json;
}

Json film_json(const FilmSpec& film) {
    Json json;
    if (film.is_spectral) {
        json["spectrum"] = band(film.from_nm, film.to_nm);
        json["spectrum"]["bins"] = film.channels.size();
    } else {
        for (const FilmChannel& channel : film.channels) {
            const Spectrum& response = channel.response;
            Json one = {{"name", channel.name}};
            // A band lets everything through; a filter may be as flat, but grey.
            if (is_flat(response) && response.values().front() == 1) {
                one["band"] = band(response.first_nm(), response.last_nm());
            } else {
                one["response"] = {{"table", table(response)}};
            }
            one["counts_photons"] = channel.counts_photons;
            json["channel"].push_back(one);
        }
    }
    json["unit"] = film.unit == FilmUnit::Watts ? "watts" : "photons";
    json["per_dye"] = film.per_dye;
    return json;
}

Json stack_json(const StackDescription& stack) {
    return {{"along", vector(stack.along)},
            {"start", length(stack.start_um)},
            {"stop", length(stack.stop_um)},
            {"step", length(stack.step_um)},
            {"views",
             {{"axis", vector(stack.views.axis)},
              {"center", point(stack.views.center)},
              {"angles_deg", degrees(stack.views.angles_rad)}}}};
}

Json render_json(const RenderDescription& render) {
    Json json = {{"estimator", render.estimator}, {"samples", render.samples}, {"seed", render.seed}};
    json["fluorescence_orders"] = render.fluorescence_orders ? Json(*render.fluorescence_orders) : Json("all");
    json["max_scatterings"] = optional(render.max_scatterings);
    json["filter"] = nullptr;
    if (render.filter) {
        Json bands = Json::array();
        for (const FilterDescription::Band& one : render.filter->bands)
            bands.push_back(band(one.from_nm, one.to_nm));
        json["filter"] = {{render.filter->passes ? "pass" : "block", bands}};
    }
    json["photons"] = optional(render.photons);
    json["cache_voxel"] = render.cache_voxel_um ? length(*render.cache_voxel_um) : Json();
    return json;
}

bool is_plain(const Json& json) {
    return !json.is_structured() || json.empty();
}

// Like dump(2), but lists of plain values (points, tables) stay on one line.
void print(const Json& json, std::size_t indent, std::string& out) {
    const bool one_line = json.is_array() && std::all_of(json.begin(), json.end(), is_plain);
    if (is_plain(json) || one_line) {
        // A file name may be in any encoding: what is no UTF-8 is replaced instead of thrown at.
        out += json.dump(-1, ' ', false, Json::error_handler_t::replace);
        return;
    }
    const std::string margin(indent + 2, ' ');
    out += json.is_object() ? "{" : "[";
    const char* separator = "\n";
    for (const auto& [key, value] : json.items()) {
        out += separator + margin;
        if (json.is_object()) out += Json(key).dump() + ": ";
        print(value, indent + 2, out);
        separator = ",\n";
    }
    out += '\n' + std::string(indent, ' ') + (json.is_object() ? '}' : ']');
}

}  // namespace

std::string to_json(const SceneDescription& scene) {
    Json json = {{"title", scene.title}, {"medium", Json::array()}, {"light", Json::array()}};
    for (const MediumDescription& medium : scene.media)
        json["medium"].push_back(medium_json(medium));
    for (const LightDescription& light : scene.lights)
        json["light"].push_back(light_json(light.light));
    json["camera"] = camera_json(scene.camera);
    json["film"] = film_json(scene.film);
    json["stack"] = scene.stack ? stack_json(*scene.stack) : Json();
    json["render"] = render_json(scene.render);
    std::string text;
    print(json, 0, text);
    return text;
}

}  // namespace fluovox
