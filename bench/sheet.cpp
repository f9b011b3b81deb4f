// One plane of a light-sheet stack by each estimator that can render it: what they are worth.

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/specimen/write_specimen.h"
#include "fluovox/transport/render.h"

#include "cases.h"
#include "measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace fluovox::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLayer = "fluorescence";

/// Brightness of each pixel, and of which pixels the efficiency is asked: the brightest tenth.
struct Bright {
    std::vector<double> means;
    std::vector<int> pixels;
};

Film film_of(const Scene& base, const char* estimator, int samples, std::uint64_t seed) {
    Scene scene = base;
    scene.description.render.estimator = estimator;
    scene.description.render.samples = samples;
    scene.description.render.seed = seed;
    NoProgress silent;
    return render(scene, silent).film;
}

void save_means(const fs::path& file, const Film& film) {
    std::ofstream out(file);
    for (int pixel = 0; pixel < film.pixels(); ++pixel)
        out << fmt::format("{}\n", film.mean_of_all(film.layer(kLayer), pixel));
}

Bright load_bright(const fs::path& file) {
    Bright bright;
    std::ifstream in(file);
    for (double mean = 0; in >> mean;) {
        bright.pixels.push_back(static_cast<int>(bright.means.size()));
        bright.means.push_back(mean);
    }
    std::sort(bright.pixels.begin(), bright.pixels.end(), [&](int a, int b) {
        return bright.means[static_cast<std::size_t>(a)] > bright.means[static_cast<std::size_t>(b)];
    });
    bright.pixels.resize(bright.pixels.size() / 10);
    return bright;
}

Scene middle_plane(const fs::path& specimen) {
    SceneDescription description = load_scene_description(specimen / "scene.toml", {});
    description.stack.reset();
    return build_scene(std::move(description));
}

/// 1 / (mean relative variance of the bright pixels x CPU seconds), and their mean in units of the reference's.
Figures efficiency(const Scene& scene, const Bright& bright, const char* estimator, int samples) {
    Figures figures;
    double variance = 0;
    double mean = 0;
    double reference = 0;
    time_into(figures, [&] {
        const Film film = film_of(scene, estimator, samples, 2);
        const int layer = film.layer(kLayer);
        for (const int pixel : bright.pixels) {
            const double expected = bright.means[static_cast<std::size_t>(pixel)];
            variance += film.variance_of_mean_of_all(layer, pixel) / (expected * expected);
            mean += film.mean_of_all(layer, pixel);
            reference += expected;
        }
    });
    variance /= static_cast<double>(bright.pixels.size());
    figures["efficiency"] = 1 / (variance * figures.at("cpu"));
    figures["same"] = mean / reference;
    return figures;
}

}  // namespace

void report_sheet(const fs::path& folder, Table& table) {
    const fs::path specimen = folder / "lightsheet-neuron";
    const fs::path means = specimen / "means.txt";
    // Whatever uses threads does so in a process of its own.
    measure(2, 1, [&] {
        NoProgress silent;
        fs::create_directories(specimen);
        write_specimen("lightsheet-neuron", specimen.string(), DemoSettings{}, silent);
        save_means(means, film_of(middle_plane(specimen), "cached", 24, 1));
        return Figures{};
    });
    table.heading("one plane of the light-sheet neuron: 1 / (relative variance of the bright tenth x CPU seconds)");
    const auto of = [&](const char* estimator, int samples) {
        return measure(2, 1,
                       [&] { return efficiency(middle_plane(specimen), load_bright(means), estimator, samples); });
    };
    const Figures cached = of("cached", 24);
    const Figures light = of("light", 200);
    const Figures path = of("path", 8);
    const Figures plain = of("collision", 64);
    const double ours = cached.at("efficiency");
    table.figure("cached", ours);
    table.at_least("  over photons from the lights (light)", ours / light.at("efficiency"), 1.5);
    table.figure("  over paths from the camera (path)", ours / path.at("efficiency"));
    table.at_least("  over plain paths that score at collisions (collision)", ours / plain.at("efficiency"), 100);
    table.figure("bright pixels by light, in units of cached's", light.at("same"));
    table.figure("  by path", path.at("same"));
    table.figure("  by collision", plain.at("same"));
}

}  // namespace fluovox::bench
