#pragma once

// Internal to the module: how the parts of a scene file become plain data.

#include "fluovox/scene/scene_description.h"
#include "fluovox/scene/scene_table.h"

#include <filesystem>
#include <string>
#include <vector>

namespace fluovox {

/// What all readers share.
struct ReadContext {
    std::filesystem::path folder;      ///< of the scene file; relative paths start here
    std::vector<std::string> remarks;  ///< see SceneDescription
    std::vector<std::string> warnings;
};

/// Wavelengths that make sense here; others are a wrong unit.
inline constexpr NumberRange kWavelengthRange_nm = {.min = 100, .max = 20000};

struct Band {
    double from_nm = 0, to_nm = 0;
};

/// The band a table gives as `from` and `to`, or as `center` and `width`; other keys are left to the caller.
Band read_band(const SceneTable& table);

/// A file named in the scene, from the scene's folder on.
std::filesystem::path resolve_path(const SceneTable& table, std::string_view key, const ReadContext& context);

/// A table of wavelength (nm) and value in the file that `key` names; values within `range`.
/// `file_text`, where wanted, gets the whole text of the file.
Spectrum load_table(const SceneTable& table, std::string_view key, const ReadContext& context, NumberRange range,
                    std::string* file_text = nullptr);

/// The same from `table = { wavelength_nm = [...], value = [...] }` in the scene itself, as `to_json` writes tables.
Spectrum read_numbers(const SceneTable& parent, NumberRange range);

// Each reads its part of the root table.
std::vector<MediumDescription> read_media(const SceneTable& root, ReadContext& context);
std::vector<LightDescription> read_lights(const SceneTable& root, ReadContext& context);
Camera read_camera(const SceneTable& root, const ReadContext& context);
FilmSpec read_film(const SceneTable& root, const ReadContext& context);
std::optional<StackDescription> read_stack(const SceneTable& root);
RenderDescription read_render(const SceneTable& root);

/// Sets the camera's blur where it is `blur = "diffraction"`: wavelength / (2 NA) at the mean of the film's
/// wavelengths.
void resolve_blur(const SceneTable& root, SceneDescription& scene);

/// Throws at camera.resolution when the film would not fit into the memory of this machine.
void require_film_fits(const SceneTable& root, const SceneDescription& scene);

/// `phase_function`, or `anisotropy`; isotropic when both are missing.
PhaseFunction read_phase(const SceneTable& medium, ReadContext& context);

/// Regions of media, part of `read_media`.
Region read_region(const SceneTable& medium);
/// `scattering` or `absorption`; zero when missing.
Coefficient read_coefficient(const SceneTable& medium, std::string_view key, const ReadContext& context);

}  // namespace fluovox
