// Photons from a pencil beam in a homogeneous cube of 60 mm: the common benchmark of tissue optics.

#include "fluovox/core/progress.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/fluence.h"

#include "cases.h"
#include "measure.h"

#include <utility>

namespace fluovox::bench {
namespace {

// Lengths in millimetres instead of micrometres: only ratios count.
Scene cube60() {
    Scene scene;
    scene.description.render.estimator = "path";
    SceneMedium cube;
    cube.name = "cube";
    cube.region = BoxRegion{{0, 0, 0}, {60, 60, 60}};
    cube.scattering = 1.0;
    cube.absorption = 0.005;
    cube.phase = HenyeyGreenstein{0.01};
    scene.media.push_back(std::move(cube));
    BeamLight beam;
    beam.position = beam.waist = {30, 30, 0};
    beam.direction = {0, 0, 1};
    beam.radius_um = 0;
    beam.profile = BeamProfile::Box;
    Light light;
    light.shape = beam;
    light.spectrum.lines = {{480, 1}};
    light.power_W = 1;
    scene.lights.push_back(std::move(light));
    return scene;
}

Figures trace_cube() {
    NoProgress silent;
    const Scene scene = cube60();
    FluenceSettings settings;
    settings.photons = 200000;
    Figures figures;
    time_into(figures,
              [&] { figures["absorbed"] = trace_fluence(scene, settings, silent).share.excitation.absorbed[0].value; });
    figures["photons_per_ms"] = static_cast<double>(settings.photons) / figures["cpu"] / 1e3;
    // In the same process, as the speed of a shared machine changes from one moment to the next.
    figures["plain"] = plain_cube_rate();
    figures["ratio"] = figures["photons_per_ms"] / figures["plain"];
    return figures;
}

}  // namespace

void report_photons(const std::filesystem::path& /*folder*/, Table& table) {
    const Figures two = measure(2, 5, trace_cube);
    table.heading("cube60: photons in a homogeneous cube");
    table.at_least("photons/ms, two threads by their CPU time", 2 * two.at("photons_per_ms"), 300);
    table.at_least("in ratio to the plain loop", two.at("ratio"), 0.8);
    table.figure("  plain loop, photons/ms on two threads", 2 * two.at("plain"));
    table.figure("  absorbed (published: 0.1771)", two.at("absorbed"));
}

}  // namespace fluovox::bench
