// A light-sheet slice, and a cuvette whose spectrum is wanted.

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/progress.h"
#include "fluovox/optics/camera_ray.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/film_response.h"
#include "fluovox/transport/path_tracer.h"
#include "fluovox/transport/pixel_renderer.h"
#include "fluovox/transport/render.h"

#include "cases.h"
#include "measure.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace fluovox::bench {
namespace {

namespace fs = std::filesystem;

Figures render_slice(const fs::path& neuron) {
    NoProgress silent;
    SceneDescription description = load_scene_description(
        neuron / "scene.toml",
        {"camera.resolution=[128,128]", "render.samples=4", "render.max_scatterings=1", "render.estimator=\"path\""});
    const Scene scene = build_scene(std::move(description));
    Figures figures;
    time_into(figures, [&] { figures["real"] = static_cast<double>(render(scene, silent).counts.real_collisions); });
    return figures;
}

constexpr const char* kCuvette = R"(
[[medium]]
dye           = "EGFP"
concentration = "5 uM"
region        = { box = { min = ["-5 mm", "-5 mm", "-5 mm"], max = ["5 mm", "5 mm", "5 mm"] } }

[[medium]]
scattering = "0.5 /mm"
absorption = "0.001 /mm"
region     = { box = { min = ["-5 mm", "-5 mm", "-5 mm"], max = ["5 mm", "5 mm", "5 mm"] } }

[[light]]
kind       = "sheet"
wavelength = "488 nm"
power      = "1 mW"
position   = ["-10 mm", "0 mm", "0 mm"]
direction  = [1, 0, 0]
normal     = [0, 0, 1]
width      = "10 mm"
thickness  = "10 mm"
profile    = "box"

[camera]
kind       = "telecentric"
position   = ["0 mm", "0 mm", "20 mm"]
target     = ["0 mm", "0 mm", "0 mm"]
up         = [0, 1, 0]
field      = "10 mm"
resolution = [8, 8]

[film]
spectrum = { from = "490 nm", to = "602 nm", bins = 28 }

[render]
estimator = "path"
)";

/// Sum over bins of the variance of a pixel's sample, mean over the pixels; and seconds per sample.
struct Worth {
    double variance = 0, seconds = 0, mean = 0;
};

Worth worth_of(const Scene& scene, int samples, const std::function<void(int, int, std::vector<double>&)>& sample) {
    const auto bins = scene.description.film.channels.size();
    const int pixels = scene.description.camera.width * scene.description.camera.height;
    std::vector<double> values(bins);
    Worth worth;
    Figures figures;
    time_into(figures, [&] {
        for (int pixel = 0; pixel < pixels; ++pixel) {
            std::vector<double> sum(bins);
            std::vector<double> squares(bins);
            for (int s = 0; s < samples; ++s) {
                sample(pixel, s, values);
                for (std::size_t b = 0; b < bins; ++b) {
                    sum[b] += values[b];
                    squares[b] += values[b] * values[b];
                }
            }
            for (std::size_t b = 0; b < bins; ++b) {
                worth.mean += sum[b] / samples / pixels;
                worth.variance += (squares[b] - sum[b] * sum[b] / samples) / (samples - 1) / pixels;
            }
        }
    });
    worth.seconds = figures["cpu"] / samples / pixels;
    return worth;
}

// Wavelengths that share a path, against the same renderer with one wavelength per path.
Figures compare_wavelengths(const fs::path& folder) {
    const Scene scene = build_scene(load_scene_description(folder / "cuvette.toml", {}));
    const Illumination illumination(scene);
    PixelRenderer renderer(scene, illumination);
    const auto bins = scene.description.film.channels.size();
    const Worth shared = worth_of(scene, 1500, [&](int pixel, int s, std::vector<double>& values) {
        const auto all = renderer.sample(pixel, s);
        for (std::size_t b = 0; b < bins; ++b)
            values[b] = all[2 * bins + b];  // the fluorescence layer
    });

    PathTracer tracer(scene, illumination);
    const CameraRays camera(scene.description.camera);
    const FilmResponse response(scene.description.film, {});
    PathOptics optics;
    PathRadiance radiance;
    const double from = scene.description.film.from_nm;
    const double width = scene.description.film.to_nm - from;
    const Worth alone = worth_of(scene, 1500, [&](int pixel, int s, std::vector<double>& values) {
        Rng rng(2, static_cast<std::uint64_t>(pixel), static_cast<std::uint64_t>(s));
        values.assign(bins, 0);
        const Ray ray = camera.sample(pixel % 8, pixel / 8, rng);
        Wavelengths one(1);
        one.nm[0] = from + width * rng.uniform();
        one.pdf_per_nm[0] = 1 / width;
        tracer.field().set_optics(one, optics);
        PathTask task;
        task.optics = &optics;
        task.orders = 1;
        tracer.estimate(ray, task, rng, radiance);
        response.add(one.nm[0], radiance.by_dye[0][0] * width, values);
    });
    return {{"gain", alone.variance * alone.seconds / (shared.variance * shared.seconds)},
            {"same", shared.mean / alone.mean},
            {"variance", alone.variance / shared.variance},
            {"us_shared", 1e6 * shared.seconds},
            {"us_alone", 1e6 * alone.seconds}};
}

}  // namespace

void write_cuvette(const fs::path& folder) {
    write_text_file(folder / "cuvette.toml", kCuvette);
}

void report_fluorescence(const fs::path& folder, const fs::path& neuron, Table& table) {
    table.heading("fluorescence");
    const Figures slice = measure(2, 3, [&] { return render_slice(neuron); });
    table.at_most("light-sheet slice of 256^3, 128 x 128 x 4, scattered at most once (CPU s)", slice.at("cpu"), 0.5);
    const Figures spectra = measure(1, 3, [&] { return compare_wavelengths(folder); });
    table.at_least("cuvette, 28 bins: variance x time of one wavelength per path, in ours", spectra.at("gain"), 10);
    table.figure("  of which variance per path", spectra.at("variance"));
    table.figure("  time per path (us)", spectra.at("us_shared"));
    table.figure("  means of the two in ratio", spectra.at("same"));
}

}  // namespace fluovox::bench
