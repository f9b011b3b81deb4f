// What somebody else's program looks like: it reads a scene and asks the dye library.

#include <fluovox/core/error.h>
#include <fluovox/core/version.h>
#include <fluovox/medium/dye.h>
#include <fluovox/scene/scene_description.h>

#include <cstdio>

int main(int argc, char** argv) {
    try {
        if (argc != 2) throw fluovox::UsageError("consumer SCENE.toml");
        const fluovox::SceneDescription scene = fluovox::load_scene_description(argv[1]);
        const fluovox::Dye& dye = scene.media.at(0).dye.value();
        std::printf("fluovox %s: %d x %d pixels, 10 uM %s absorbs %g /um at 488 nm\n", fluovox::version(),
                    scene.camera.width, scene.camera.height, dye.name.c_str(),
                    10 * fluovox::absorption_per_um_per_uM(dye, 488));
        return 0;
    } catch (const fluovox::Error& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return static_cast<int>(e.code());
    }
}
