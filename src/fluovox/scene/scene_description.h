#pragma once

#include "fluovox/core/error.h"
#include "fluovox/image/film_spec.h"
#include "fluovox/medium/coefficient.h"
#include "fluovox/medium/dye.h"
#include "fluovox/medium/phase_function.h"
#include "fluovox/optics/camera.h"
#include "fluovox/optics/light.h"
#include "fluovox/volume/region.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace fluovox {

/// A grid of a VDB file, not yet opened.
struct GridReference {
    std::filesystem::path file;           ///< absolute, or relative to the working folder
    std::string written;                  ///< the file as the scene names it, relative to the scene's folder
    std::string name;                     ///< empty: the only grid of the file, or the one named after the dye
    std::optional<double> uM_per_value;   ///< from `unit`; otherwise the file's metadata say it, or umol/L
    std::optional<double> um_per_length;  ///< from `length_unit`; otherwise the file's metadata say it, or um
    double scale = 1;                     ///< multiplies every value
    SourceLocation where;
};

/// One [[medium]] of the scene: a dye (concentration per voxel or constant in a region) or a host.
struct MediumDescription {
    SourceLocation where;
    std::string name;
    std::optional<Dye> dye;
    double concentration_uM = 0;        ///< of a dye in a region
    std::optional<GridReference> grid;  ///< otherwise `region` says where
    Region region = Everywhere{};
    Coefficient scattering = 0.0;  ///< hosts only, per um
    Coefficient absorption = 0.0;  ///< hosts only, per um
    PhaseFunction phase;           ///< hosts only
    std::optional<double> refractive_index;
    bool exclusive = false;  ///< replaces the media around it instead of adding to them
};

struct LightDescription {
    SourceLocation where;
    Light light;
};

/// One image per position of sheet and focal plane, moved together; the whole of it once more for each view.
struct StackDescription {
    /// Camera, sheets and beams turned together about an axis, as if the specimen were turned the other way.
    struct Views {
        Vec3 axis = {0, 1, 0}, center;
        std::vector<double> angles_rad = {0};
    };

    SourceLocation where;
    Vec3 along;
    double start_um = 0, stop_um = 0, step_um = 0;
    Views views;
};

/// Bands of wavelength cut before the film.
struct FilterDescription {
    bool passes = true;  ///< only these bands pass; otherwise these are blocked
    struct Band {
        double from_nm = 0, to_nm = 0;
    };
    std::vector<Band> bands;
};

struct RenderDescription {
    std::string estimator = "auto";
    int samples = 64;  ///< per pixel
    std::uint64_t seed = 1;
    std::optional<int> fluorescence_orders = 1;  ///< nothing: "all"
    std::optional<int> max_scatterings;          ///< elastic events of a path; nothing: no limit
    std::optional<FilterDescription> filter;
    std::optional<double> photons;         ///< pass 1 of `cached`
    std::optional<double> cache_voxel_um;  ///< `cached`
    bool plain_tracking = false;           ///< by one bound for each grid: the reference; not in the scene file
    SourceLocation where;
};

/// The scene file as plain data: units resolved, defaults filled in, small tables read, grids not opened.
struct SceneDescription {
    std::string file;
    std::string title;
    std::vector<MediumDescription> media;
    std::vector<LightDescription> lights;
    Camera camera;
    FilmSpec film;
    std::optional<StackDescription> stack;
    RenderDescription render;
    std::vector<std::string> remarks;   ///< what the reader should hear: "GFP" stands for EGFP ...
    std::vector<std::string> warnings;  ///< what is allowed but probably a mistake
};

/// What a scene is read for: an image needs a camera and a film, light alone does not.
enum class SceneUse { Image, Light };

/// Reads and checks a scene file, the JSON that `to_json` makes of one, or that in an image or stack of fluovox (whose
/// relative paths start where the image lies; of dyes of the user's own only the name is in it). `overrides` are
/// `KEY=VALUE` texts (`camera.resolution=[64,64]`) that replace keys. Throws SceneError with the place of the first
/// mistake, InputError for a file that cannot be read (the scene or one of the tables it names), UsageError for an
/// override that is no `KEY=VALUE`.
SceneDescription load_scene_description(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides = {}, SceneUse use = SceneUse::Image);

/// The same for a scene whose `text` is at hand; `file` is what messages call it and where relative paths start.
SceneDescription parse_scene_description(const std::string& text, const std::filesystem::path& file,
                                         const std::vector<std::string>& overrides = {},
                                         SceneUse use = SceneUse::Image);

/// The description with every default, as JSON text; the same scene gives the same text.
std::string to_json(const SceneDescription& scene);

}  // namespace fluovox
