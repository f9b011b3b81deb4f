#pragma once

// Scenes in a few lines for tests, without files.

#include "fluovox/scene/scene.h"
#include "fluovox/transport/render.h"

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace fluovox::testing {

inline SceneMedium host(Region region, double scattering_per_um, double absorption_per_um, double g = 0) {
    SceneMedium medium;
    medium.name = "host";
    medium.region = region;
    medium.scattering = scattering_per_um;
    medium.absorption = absorption_per_um;
    medium.phase = HenyeyGreenstein{g};
    return medium;
}

inline SceneMedium host(SparseGrid grid, double scattering_per_um, double absorption_per_um, double g = 0) {
    SceneMedium medium = host(Everywhere{}, scattering_per_um, absorption_per_um, g);
    medium.grid = std::make_shared<const SparseGrid>(std::move(grid));
    return medium;
}

inline SceneMedium dye_in(Region region, int dye, double uM) {
    SceneMedium medium;
    medium.name = "dye";
    medium.region = region;
    medium.dye = dye;
    medium.amount = uM;
    return medium;
}

inline SceneMedium dye_in(SparseGrid grid, int dye) {
    SceneMedium medium = dye_in(Everywhere{}, dye, 1);
    medium.grid = std::make_shared<const SparseGrid>(std::move(grid));
    return medium;
}

/// A dye with flat curves: absorbs `mu_per_um_per_uM` between two wavelengths, emits evenly between two others.
inline Dye flat_dye(double mu_per_um_per_uM, double absorb_from_nm, double absorb_to_nm, double emit_from_nm,
                    double emit_to_nm, double quantum_yield) {
    Dye dye;
    dye.id = dye.name = "flat";
    const double epsilon = mu_per_um_per_uM * 1e10 / std::log(10.0);  // mu = ln(10) eps c; c in M, 1 cm = 1e4 um
    dye.molar_absorption_per_M_cm = Spectrum::box(absorb_from_nm, absorb_to_nm, epsilon);
    dye.emission_per_nm = Spectrum::box(emit_from_nm, emit_to_nm, 1 / (emit_to_nm - emit_from_nm));
    dye.quantum_yield = quantum_yield;
    return dye;
}

/// Collimated light that comes down on a point from the side, even over a square of this size around it; it starts as
/// far before it.
inline SheetLight slanting_light(Vec3 onto_um, double size_um, Vec3 direction = {0.48, 0.36, -0.8}) {
    SheetLight sheet;
    sheet.direction = normalized(direction);
    sheet.normal = normalized(cross(sheet.direction, Vec3{0, 1, 0}));
    sheet.position = sheet.waist = onto_um - size_um * sheet.direction;
    sheet.width_um = sheet.thickness_um = size_um;
    sheet.profile = BeamProfile::Box;
    return sheet;
}

inline Light laser(decltype(Light::shape) shape, double wavelength_nm, double power_W) {
    Light light;
    light.shape = std::move(shape);
    light.spectrum.lines = {{wavelength_nm, 1}};
    light.power_W = power_W;
    return light;
}

/// A telecentric camera of one pixel that looks from `position` to `target`.
inline Camera one_pixel(Vec3 position, Vec3 target, Vec3 up, double field_um, double numerical_aperture = 0) {
    Camera camera;
    camera.position = position;
    camera.target = target;
    camera.up = up;
    camera.focus_um = length(target - position);
    camera.field_um = field_um;
    camera.width = camera.height = 1;
    camera.numerical_aperture = numerical_aperture;
    return camera;
}

inline FilmSpec spectrometer(double from_nm, double to_nm, int bins) {
    FilmSpec film;
    film.from_nm = from_nm;
    film.to_nm = to_nm;
    const double width = (to_nm - from_nm) / bins;
    for (int i = 0; i < bins; ++i) {
        FilmChannel channel;
        channel.name = "bin" + std::to_string(i);
        channel.center_nm = from_nm + (i + 0.5) * width;
        channel.response = Spectrum::box(from_nm + i * width, from_nm + (i + 1) * width, 1 / width);
        film.channels.push_back(std::move(channel));
    }
    return film;
}

}  // namespace fluovox::testing
