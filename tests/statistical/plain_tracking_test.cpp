// The fast tracking of fine structures against the plain one: the same image, and the same for any number of threads.

#include "fluovox/image/compare.h"
#include "fluovox/image/rendered_image.h"
#include "fluovox/transport/render.h"
#include "fluovox/volume/sparse_grid_builder.h"

#include "scene_kit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace fluovox {
namespace {

constexpr double kSize_um = 64;

/// Two thin tubes that cross, soft at their surface, and a lump; scattering that makes paths of a few collisions.
Scene tubes(double denser = 1) {
    const auto value = [&](Voxel v) {
        const auto soft = [](double inside) { return std::clamp(inside, 0.0, 1.0); };
        const double first = 2.5 - std::hypot(v.x - 30.0, v.y - 20.0 - 0.3 * v.z);
        const double second = 1.8 - std::hypot(v.y - 34.0, v.z - 50.0 + 0.5 * v.x);
        const double lump = 7 - std::hypot(v.x - 45.0, v.y - 45.0, v.z - 20.0);
        return denser * std::max({soft(first), soft(second), 0.3 * soft(lump)});
    };
    Scene scene;
    scene.media = {testing::host(SparseGrid::from_function({0, 0, 0}, {64, 64, 64}, {}, value), 0.25, 0.01)};
    scene.lights = {testing::laser(testing::slanting_light({32, 32, 32}, 400), 488, 1)};
    scene.description.camera = testing::one_pixel({32, 32, 100}, {32, 32, 32}, {0, 1, 0}, kSize_um);
    scene.description.camera.width = scene.description.camera.height = 16;
    scene.description.film = testing::spectrometer(487, 489, 1);
    scene.description.render.estimator = "path";
    scene.description.render.samples = 3000;
    return scene;
}

RenderedImage image_of(Scene scene, std::uint64_t seed, bool plain) {
    NoProgress silent;
    scene.description.render.seed = seed;
    scene.description.render.plain_tracking = plain;
    const RenderResult result = render(scene, silent);
    EXPECT_EQ(result.counts.bound_violations, 0);
    EXPECT_GT(result.counts.real_collisions, 10000);
    Provenance provenance;
    provenance.seed = seed;
    return make_image(result.film, scene.description.film, provenance);
}

TEST(PlainTracking, GivesTheImageThatFastTrackingGives) {
    const Comparison result = compare(image_of(tubes(), 1, false), image_of(tubes(), 2, true));
    EXPECT_TRUE(result.same) << result.where << " p = " << result.p_value;
    EXPECT_GT(result.mean_a, 0);
}

TEST(PlainTracking, WouldShowATenthMoreOfTheMedium) {
    EXPECT_FALSE(compare(image_of(tubes(1.1), 1, false), image_of(tubes(), 2, true)).same);
}

// Outside the box of a grid its background is the bound, which rounding must not seem to exceed.
TEST(PlainTracking, KeepsWithinTheBoundsOfAGridThatGoesOnForEver) {
    NoProgress silent;
    Rng rng(3, 0, 0);
    std::array<float, 512> values{};
    for (float& value : values)
        value = static_cast<float>(0.2 + rng.uniform());
    SparseGridBuilder builder(0.1F);
    builder.add_brick({0, 0, 0}, values.data());
    Scene scene = tubes();
    scene.media = {testing::host(std::move(builder).finish({}, 512), 0.02, 0.01)};
    scene.description.render.samples = 200;
    scene.description.render.plain_tracking = true;
    const RenderResult result = render(scene, silent);
    EXPECT_GT(result.counts.real_collisions, 10000);
    EXPECT_EQ(result.counts.bound_violations, 0);
}

TEST(PlainTracking, NeedsManyMoreTentativeCollisions) {
    NoProgress silent;
    Scene scene = tubes();
    const RenderResult fast = render(scene, silent);
    scene.description.render.plain_tracking = true;
    const RenderResult plain = render(scene, silent);
    EXPECT_GT(plain.counts.null_collisions, 5 * fast.counts.null_collisions);
    EXPECT_GT(plain.counts.grid_lookups, 5 * fast.counts.grid_lookups);
}

}  // namespace
}  // namespace fluovox
