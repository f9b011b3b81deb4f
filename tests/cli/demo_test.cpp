#include "fluovox/core/text.h"
#include "fluovox/volume/grid_info.h"

#include "cli/run_program.h"

#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

TEST_F(ProgramTest, DemoSaysWhatItHasAndWhatItNeeds) {
    write("file", "in the way");
    expect_rows({
        {"alone lists the specimens",
         {"demo"},
         0,
         "^$",
         "neuron[\\s\\S]*beads[\\s\\S]*cuvette-gfp[\\s\\S]*cuvette-rfp"},
        {"as JSON too", {"demo", "--json"}, 0, "^$", "\"name\": \"beads\""},
        {"examples come first in the help", {"demo", "--help"}, 0, "^$", "^Examples:"},
        {"a slip of the name", {"demo", "neurone", "-o", "out"}, 2, "did you mean \"neuron\"", "", {}, {"out"}},
        {"no folder", {"demo", "beads"}, 2, "-o FOLDER"},
        {"a voxel size without unit", {"demo", "beads", "-o", "out", "--voxel-size", "3"}, 2, "unit", "", {}, {"out"}},
        {"a voxel size of nothing",
         {"demo", "beads", "-o", "out", "--voxel-size", "0um"},
         2,
         "positive",
         "",
         {},
         {"out"}},
        {"a file where the folder should be", {"demo", "cuvette-gfp", "-o", "file/out"}, 5, "file/out"},
    });
}

TEST_F(ProgramTest, DemoWritesTheSceneOfTheRepositoryAndTheNextCommand) {
    const ProgramResult result = run({"demo", "cuvette-gfp", "-o", "new/folder"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(found("Next: fluovox render new/folder/scene.toml -o new/folder/cuvette-gfp.exr", result.out));
    EXPECT_EQ(files(), std::vector<std::string>{"new/folder/scene.toml"});
    EXPECT_EQ(read("new/folder/scene.toml"), load_text(FLUOVOX_SOURCE_DIR "/volumes/cuvette-gfp/scene.toml"));
}

TEST_F(ProgramTest, DemoMakesTheGridOfTheRepository) {
    ASSERT_EQ(run({"demo", "neuron", "-o", "."}).exit_code, 0);
    EXPECT_EQ(files(),
              (std::vector<std::string>{"neuron.obj", "neuron.swc", "neuron.vdb", "nucleus.obj", "scene.toml"}));
    const auto made = inspect_grids(folder() / "neuron.vdb");
    const auto kept = inspect_grids(FLUOVOX_SOURCE_DIR "/volumes/neuron/neuron.vdb");
    ASSERT_EQ(made.size(), 2U);
    ASSERT_EQ(kept.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(made[i].entry.name, kept[i].entry.name);
        EXPECT_EQ(made[i].active_voxels, kept[i].active_voxels);
        EXPECT_EQ(made[i].total_mol, kept[i].total_mol);
    }
}

}  // namespace
}  // namespace fluovox::testing
