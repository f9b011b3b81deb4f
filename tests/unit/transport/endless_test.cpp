#include "fluovox/transport/endless.h"

#include "fluovox/core/error.h"
#include "fluovox/volume/sparse_grid_builder.h"

#include "scene_kit.h"

#include <gtest/gtest.h>

#include <utility>

namespace fluovox {
namespace {

using testing::dye_in;
using testing::flat_dye;
using testing::host;

const BoxRegion kBox{{0, 0, 0}, {10, 10, 10}};

bool ends(const Scene& scene) {
    try {
        require_an_end(scene, travelling_wavelengths_nm(scene));
    } catch (const SceneError&) {
        return false;
    }
    return true;
}

// A laser at 488 nm in the given media; one dye absorbs it and emits, where it absorbs nothing, from 500 to 600 nm.
Scene scene_of(std::vector<SceneMedium> media) {
    Scene scene;
    scene.lights = {testing::laser(PointLight{}, 488, 1)};
    scene.dyes = {flat_dye(1e-3, 480, 490, 500, 600, 0.5)};
    scene.description.render.fluorescence_orders = 0;
    scene.media = std::move(media);
    return scene;
}

SparseGrid with_background(float value) {
    SparseGridBuilder builder(value);
    builder.add_constant({0, 0, 0}, 8, 2);
    return std::move(builder).finish({}, 512);
}

TEST(Endless, OnlyAMediumWithoutEndKeepsItsLight) {
    EXPECT_TRUE(ends(scene_of({host(kBox, 1, 0)})));
    EXPECT_TRUE(ends(scene_of({host(SlabRegion{2, 0, 10}, 1, 0)})));
    EXPECT_TRUE(ends(scene_of({host(with_background(0), 1, 0)})));
    EXPECT_FALSE(ends(scene_of({host(Everywhere{}, 1, 0)})));
    EXPECT_FALSE(ends(scene_of({host(with_background(0.5F), 1, 0)})));
}

TEST(Endless, WhatAbsorbsMustBeWithoutEndToo) {
    EXPECT_TRUE(ends(scene_of({host(Everywhere{}, 1, 0), host(Everywhere{}, 0, 0.1)})));
    EXPECT_TRUE(ends(scene_of({host(Everywhere{}, 1, 0), host(with_background(0.5F), 0, 0.1)})));
    EXPECT_TRUE(ends(scene_of({host(Everywhere{}, 1, 0), dye_in(Everywhere{}, 0, 10)})));
    EXPECT_FALSE(ends(scene_of({host(Everywhere{}, 1, 0), host(kBox, 0, 0.1)})));
    EXPECT_FALSE(ends(scene_of({host(Everywhere{}, 1, 0), dye_in(kBox, 0, 10)})));
}

TEST(Endless, TheGlowOfADyeMustEndAsItsExcitationDoes) {
    Scene scene = scene_of({host(Everywhere{}, 1, 0), dye_in(Everywhere{}, 0, 10)});
    scene.description.render.fluorescence_orders = 1;
    EXPECT_FALSE(ends(scene));
    scene.description.render.max_scatterings = 100;
    EXPECT_TRUE(ends(scene));
}

}  // namespace
}  // namespace fluovox
