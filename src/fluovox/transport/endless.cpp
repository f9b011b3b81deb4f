#include "fluovox/transport/endless.h"

#include "fluovox/core/error.h"

#include <cstddef>
#include <optional>

namespace fluovox {
namespace {

void add_where_positive(const Spectrum& spectrum, std::vector<double>& wavelengths_nm) {
    for (std::size_t i = 0; i < spectrum.values().size(); ++i) {
        if (spectrum.values()[i] > 0) wavelengths_nm.push_back(spectrum.wavelengths_nm()[i]);
    }
}

// A half space or slab has a way out; a grid goes on for ever where its background is not zero.
bool is_without_end(const SceneMedium& medium) {
    return medium.grid ? medium.grid->background() > 0 : std::holds_alternative<Everywhere>(medium.region);
}

// The medium that keeps light of a wavelength for ever, if there is one.
std::optional<std::size_t> endless_medium(const Scene& scene, double wavelength_nm) {
    std::optional<std::size_t> keeper;
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        const SceneMedium& medium = scene.media[i];
        if (!is_without_end(medium) || medium.amount <= 0) continue;
        const double absorption =
            medium.dye >= 0 ? absorption_per_um_per_uM(scene.dyes[static_cast<std::size_t>(medium.dye)], wavelength_nm)
                            : coefficient_per_um(medium.absorption, wavelength_nm);
        if (absorption > 0) return std::nullopt;
        if (medium.dye < 0 && coefficient_per_um(medium.scattering, wavelength_nm) > 0) keeper = i;
    }
    return keeper;
}

}  // namespace

std::vector<double> travelling_wavelengths_nm(const Scene& scene) {
    std::vector<double> wavelengths_nm;
    for (const Light& light : scene.lights) {
        for (const LightSpectrum::Line& line : light.spectrum.lines)
            wavelengths_nm.push_back(line.wavelength_nm);
        add_where_positive(light.spectrum.energy_per_nm, wavelengths_nm);
    }
    if (scene.description.render.fluorescence_orders == 0) return wavelengths_nm;
    for (const Dye& dye : scene.dyes) {
        if (dye.quantum_yield > 0) add_where_positive(dye.emission_per_nm, wavelengths_nm);
    }
    return wavelengths_nm;
}

void require_an_end(const Scene& scene, const std::vector<double>& wavelengths_nm) {
    if (scene.description.render.max_scatterings) return;
    for (const double nm : wavelengths_nm) {
        const auto medium = endless_medium(scene, nm);
        if (!medium) continue;
        const auto& media = scene.description.media;  // none where a scene was made without a file
        const SourceLocation where =
            *medium < media.size() ? media[*medium].where : SourceLocation{scene.description.file};
        throw SceneError(where, "light of " + std::to_string(static_cast<int>(nm)) +
                                    " nm would scatter here for ever: it can neither leave nor be absorbed. Give the "
                                    "medium some absorption or a finite region, or set render.max_scatterings");
    }
}

}  // namespace fluovox
