#include "fluovox/image/film.h"
#include "fluovox/scene/read_scene.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <string>

namespace fluovox {
namespace {

constexpr double kParallel = 1e-6;
constexpr long long kMostPixels = 1 << 20;  // along one side
constexpr long long kMostBins = 4096;
constexpr double kNarrowestBin_nm = 0.001;  // three decimals tell bins apart in the names of their layers

/// A spectrometer's bin is called by its centre, with the comma of the spectral layout of OpenEXR files.
/// Fichet et al., JCGT 10(3) (2021).
std::string bin_name(double center_nm) {
    std::string name = fmt::format("{:.3f}nm", center_nm);
    std::replace(name.begin(), name.end(), '.', ',');
    return name;
}

void read_spectrometer(const SceneTable& table, FilmSpec& film) {
    table.allow_only({"from", "to", "bins"});
    const Band band = read_band(table);
    const long long bins = table.integer("bins", 1, kMostBins);
    const double width_nm = (band.to_nm - band.from_nm) / static_cast<double>(bins);
    if (width_nm < kNarrowestBin_nm) {
        table.fail("bins", fmt::format("makes bins of {} nm: they must be {} nm or wider", width_nm, kNarrowestBin_nm));
    }
    film.is_spectral = true;
    film.from_nm = band.from_nm;
    film.to_nm = band.to_nm;
    for (long long bin = 0; bin < bins; ++bin) {
        const double from = band.from_nm + width_nm * static_cast<double>(bin);
        const double to = bin + 1 == bins ? band.to_nm : band.from_nm + width_nm * static_cast<double>(bin + 1);
        const double center = 0.5 * (from + to);
        film.channels.push_back({bin_name(center), center, Spectrum::box(from, to, 1 / width_nm), false});
    }
}

double mean_wavelength(const Spectrum& response) {
    const Spectrum wavelength({response.first_nm(), response.last_nm()}, {response.first_nm(), response.last_nm()});
    return integral_of_product(response, wavelength) / response.integral();
}

FilmChannel read_channel(const SceneTable& table, const ReadContext& context) {
    table.allow_only({"name", "band", "filter", "response", "efficiency", "counts_photons"});
    constexpr NumberRange kFraction = {.min = 0, .max = 1};
    FilmChannel channel;
    channel.name = table.text("name");
    const auto bad = [](unsigned char c) { return c < ' ' || c == 0x7F || c == '.'; };
    if (channel.name.empty() || std::any_of(channel.name.begin(), channel.name.end(), bad)) {
        table.fail("name", "must be a short text without dots and control characters");
    }
    const int ways = static_cast<int>(table.has("band")) + static_cast<int>(table.has("filter")) +
                     static_cast<int>(table.has("response"));
    if (ways != 1) {
        table.fail("needs either band = { center = \"525 nm\", width = \"50 nm\" } or filter = \"filter.csv\"");
    }
    if (table.has("band")) {
        const SceneTable given = table.table("band");
        given.allow_only({"center", "width", "from", "to"});
        const Band band = read_band(given);
        channel.response = Spectrum::box(band.from_nm, band.to_nm, 1);
    } else if (table.has("response")) {
        const SceneTable response = table.table("response");
        response.allow_only({"table"});
        channel.response = read_numbers(response, kFraction);
    } else {
        channel.response = load_table(table, "filter", context, kFraction);
    }
    channel.counts_photons = table.flag_or("counts_photons", false);
    if (table.has("efficiency")) {
        channel.response = product(channel.response, load_table(table, "efficiency", context, kFraction));
        channel.counts_photons = true;
    }
    if (!(channel.response.integral() > 0))
        table.fail("lets no light through: its filter and efficiency leave nothing");
    channel.center_nm = mean_wavelength(channel.response);
    return channel;
}

void read_channels(const SceneTable& table, const ReadContext& context, FilmSpec& film) {
    film.is_spectral = false;
    std::set<std::string> names;
    for (const SceneTable& given : table.tables("channel")) {
        film.channels.push_back(read_channel(given, context));
        if (!names.insert(film.channels.back().name).second) given.fail("name", "is the name of an earlier channel");
    }
    if (film.channels.empty()) table.fail("channel", "is an empty list: a film needs one channel or more");
}

FilterDescription read_filter(const SceneTable& table) {
    table.allow_only({"pass", "block"});
    if (table.has("pass") == table.has("block")) table.fail("needs either pass = [...] or block = [...]");
    FilterDescription filter;
    filter.passes = table.has("pass");
    const char* key = filter.passes ? "pass" : "block";
    if (table.is_text_list(key)) {  // [from, to], for one band
        const std::vector<double> nm = table.quantities(key, Dimension::Wavelength, 2, kWavelengthRange_nm);
        if (!(nm[0] < nm[1])) table.fail(key, "must go from the shorter to the longer wavelength");
        filter.bands.push_back({nm[0], nm[1]});
        return filter;
    }
    for (const SceneTable& band : table.tables(key)) {
        band.allow_only({"from", "to", "center", "width"});
        const auto [from_nm, to_nm] = read_band(band);
        filter.bands.push_back({from_nm, to_nm});
    }
    if (filter.bands.empty())
        table.fail(key, "needs a band or more, for example [{ from = \"500 nm\", to = \"550 nm\" }]");
    return filter;
}

}  // namespace

namespace {

/// The field of a microscope by the size of its pixels: in the specimen, or on the chip and the magnification.
void read_pixel_size(const SceneTable& table, Camera& camera) {
    const bool on_chip = table.has("magnification") || table.has("sensor_pixel");
    if (static_cast<int>(table.has("field")) + static_cast<int>(table.has("pixel_size")) + static_cast<int>(on_chip) >
        1)
        table.fail("says the size twice: give field, or pixel_size, or magnification and sensor_pixel");
    if (table.has("pixel_size"))
        camera.field_um = camera.height * table.quantity("pixel_size", Dimension::Length, NumberRange::positive());
    if (!on_chip) return;
    const double magnification = table.number("magnification", NumberRange::positive());
    camera.field_um =
        camera.height * table.quantity("sensor_pixel", Dimension::Length, NumberRange::positive()) / magnification;
}

}  // namespace

void resolve_blur(const SceneTable& root, SceneDescription& scene) {
    const SceneTable table = root.table("camera");
    if (!table.is_text("blur") || table.text("blur") != "diffraction") return;
    const double aperture = scene.camera.numerical_aperture * scene.camera.immersion_index;
    if (!(aperture > 0)) table.fail("blur", "needs numerical_aperture: its width is wavelength / (2 NA)");
    double nm = 0;
    for (const FilmChannel& channel : scene.film.channels)
        nm += channel.center_nm / static_cast<double>(scene.film.channels.size());
    scene.camera.blur_um = 1e-3 * nm / (2 * aperture);
}

Camera read_camera(const SceneTable& root, const ReadContext& /*context*/) {
    if (!root.has("camera")) root.fail("camera", "is missing: the scene needs a table [camera]");
    const SceneTable table = root.table("camera");
    table.allow_only({"kind", "position", "target", "up", "focus", "field", "fov_deg", "resolution",
                      "numerical_aperture", "exposure", "pixel_size", "magnification", "sensor_pixel",
                      "immersion_index", "blur"});
    Camera camera;
    const bool telecentric = !table.has("kind") || table.choice("kind", {"telecentric", "perspective"}) == 0;
    camera.kind = telecentric ? Camera::Kind::Telecentric : Camera::Kind::Perspective;
    camera.position = table.point("position");
    camera.target = table.point("target");
    const Vec3 view = camera.target - camera.position;
    const double distance_um = length(view);
    if (!(distance_um > 0)) table.fail("target", "must differ from position: the camera looks from there to here");
    camera.up = table.has("up") ? table.direction("up") : Vec3{0, 1, 0};
    if (length(cross(camera.up, normalized(view))) < kParallel) {
        table.fail("up", table.has("up") ? "must not be parallel to the view (from position to target)"
                                         : "is missing: [0, 1, 0], the default, is parallel to the view");
    }
    camera.focus_um = table.quantity_or("focus", Dimension::Length, distance_um, NumberRange::positive());
    const char* other = telecentric ? "fov_deg" : "field";
    if (table.has(other)) {
        table.fail(other, telecentric ? "belongs to a perspective camera; a telecentric one has field"
                                      : "belongs to a telecentric camera; a perspective one has fov_deg");
    }
    if (telecentric) {
        if (!table.has("pixel_size") && !table.has("magnification"))
            camera.field_um = table.quantity("field", Dimension::Length, NumberRange::positive());
    } else {
        constexpr NumberRange kFov_deg = {.min = 0, .max = 180, .without_min = true, .without_max = true};
        camera.fov_rad = table.number("fov_deg", kFov_deg) * std::numbers::pi / 180;
    }
    const std::vector<long long> resolution = table.integers("resolution", 2, 1, kMostPixels);
    camera.width = static_cast<int>(resolution[0]);
    camera.height = static_cast<int>(resolution[1]);
    if (telecentric) read_pixel_size(table, camera);
    camera.immersion_index = table.number_or("immersion_index", 1, {.min = 1, .max = 4});
    camera.numerical_aperture =
        table.number_or("numerical_aperture", 0, NumberRange::not_negative()) / camera.immersion_index;
    if (!table.is_text("blur") || table.text("blur") != "diffraction")
        camera.blur_um = table.quantity_or("blur", Dimension::Length, 0, NumberRange::not_negative());
    camera.exposure_s = table.quantity_or("exposure", Dimension::Time, 0, NumberRange::positive());
    return camera;
}

FilmSpec read_film(const SceneTable& root, const ReadContext& context) {
    if (!root.has("film")) root.fail("film", "is missing: the scene needs a table [film]");
    const SceneTable table = root.table("film");
    table.allow_only({"spectrum", "channel", "unit", "per_dye"});
    if (table.has("spectrum") == table.has("channel")) {
        table.fail("needs either spectrum = { from = \"480 nm\", to = \"620 nm\", bins = 28 } or [[film.channel]]");
    }
    FilmSpec film;
    if (table.has("spectrum")) {
        read_spectrometer(table.table("spectrum"), film);
    } else {
        read_channels(table, context, film);
    }
    if (table.has("unit"))
        film.unit = table.choice("unit", {"watts", "photons"}) == 0 ? FilmUnit::Watts : FilmUnit::Photons;
    film.per_dye = table.flag_or("per_dye", false);
    return film;
}

namespace {

StackDescription::Views read_views(const SceneTable& table) {
    table.allow_only({"axis", "center", "angles_deg"});
    StackDescription::Views views;
    views.axis = table.has("axis") ? table.direction("axis") : Vec3{0, 1, 0};
    views.center = table.point("center");
    views.angles_rad = table.numbers("angles_deg", {.min = -360, .max = 360});
    for (double& angle : views.angles_rad)
        angle *= std::numbers::pi / 180;
    return views;
}

}  // namespace

std::optional<StackDescription> read_stack(const SceneTable& root) {
    if (!root.has("stack")) return std::nullopt;
    const SceneTable table = root.table("stack");
    table.allow_only({"along", "start", "stop", "step", "views"});
    StackDescription stack;
    stack.where = table.where();
    stack.along = table.direction("along");
    stack.start_um = table.quantity("start", Dimension::Length);
    stack.stop_um = table.quantity("stop", Dimension::Length);
    stack.step_um = table.quantity("step", Dimension::Length, NumberRange::positive());
    if (stack.stop_um < stack.start_um) table.fail("stop", "must not be below start");
    constexpr double kMostImages = 100'000;
    if (table.has("views")) stack.views = read_views(table.table("views"));
    const double images =
        ((stack.stop_um - stack.start_um) / stack.step_um + 1) * static_cast<double>(stack.views.angles_rad.size());
    if (images > kMostImages)
        table.fail("step", fmt::format("makes {:.0f} images; at most {} are allowed", images, kMostImages));
    return stack;
}

RenderDescription read_render(const SceneTable& root) {
    RenderDescription render;
    render.where = root.where();
    if (!root.has("render")) return render;
    const SceneTable table = root.table("render");
    render.where = table.where();
    table.allow_only(
        {"estimator", "samples", "seed", "fluorescence_orders", "max_scatterings", "filter", "photons", "cache_voxel"});
    constexpr long long kLargest = std::numeric_limits<int>::max();
    if (table.has("estimator")) {
        table.choice("estimator", {"auto", "path", "light", "cached", "collision", "bidirectional", "vpl"});
        render.estimator = table.text("estimator");
    }
    if (table.has("samples")) render.samples = static_cast<int>(table.integer("samples", 1, kLargest));
    if (table.has("seed")) {
        render.seed = static_cast<std::uint64_t>(table.integer("seed", 0, std::numeric_limits<long long>::max()));
    }
    if (table.is_text("fluorescence_orders")) {
        if (table.text("fluorescence_orders") != "all")
            table.fail("fluorescence_orders", "must be a number or \"all\"");
        render.fluorescence_orders = std::nullopt;
    } else if (table.has("fluorescence_orders")) {
        render.fluorescence_orders = static_cast<int>(table.integer("fluorescence_orders", 0, kLargest));
    }
    if (table.has("max_scatterings")) {
        render.max_scatterings = static_cast<int>(table.integer("max_scatterings", 0, kLargest));
    }
    if (table.has("filter")) render.filter = read_filter(table.table("filter"));
    if (table.has("photons")) render.photons = table.number("photons", {.min = 1, .max = 1e18});
    if (table.has("cache_voxel")) {
        render.cache_voxel_um = table.quantity("cache_voxel", Dimension::Length, NumberRange::positive());
    }
    return render;
}

void require_film_fits(const SceneTable& root, const SceneDescription& scene) {
    std::set<std::string> dyes;
    for (const MediumDescription& medium : scene.media) {
        if (medium.dye) dyes.insert(medium.dye->name);
    }
    const auto layers = film_layers({dyes.begin(), dyes.end()}, scene.film.per_dye).size();
    const auto values = static_cast<double>(layers * scene.film.channels.size());
    const double pixels = static_cast<double>(scene.camera.width) * scene.camera.height;
    // A sum and a sum of squares of each value, and a count per pixel.
    const double bytes = pixels * (2 * values * sizeof(double) + sizeof(std::int64_t));
    const double memory = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
    if (bytes <= memory && pixels <= std::numeric_limits<int>::max()) return;
    constexpr double kGiB = 1024.0 * 1024 * 1024;
    root.table("camera").fail(
        "resolution",
        fmt::format("with {} wavelength bins or channels makes a film of {:.3g} GiB, larger than the memory "
                    "of this machine ({:.3g} GiB): take fewer pixels or bins",
                    scene.film.channels.size(), bytes / kGiB, memory / kGiB));
}

}  // namespace fluovox
