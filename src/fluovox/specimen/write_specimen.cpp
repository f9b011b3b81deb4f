#include "fluovox/specimen/write_specimen.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/core/progress.h"
#include "fluovox/specimen/solids.h"
#include "fluovox/voxelize/specimen.h"

#include <system_error>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw OutputError(folder.string() + ": the folder cannot be made: " + error.message());
}

}  // namespace

std::vector<fs::path> write_specimen(const std::string& name, const fs::path& folder, const DemoSettings& settings,
                                     Progress& progress) {
    const SpecimenInfo& info = find_specimen(name);
    make_folder(folder);
    const Specimen specimen = make_specimen(name, settings.seed.value_or(info.seed));
    std::vector<fs::path> files;
    const auto write = [&](const std::string& file, const std::string& text) {
        write_text_file(folder / file, text);
        files.push_back(folder / file);
    };
    std::vector<SpecimenGroup> groups;
    for (const LabelledBody& body : specimen.bodies) {
        write(body.file, to_obj(body.mesh, body.comment));
        groups.push_back({body.dye, body.concentration_uM, {{files.back(), body.file, 1, {}}}});
    }
    if (!specimen.swc.empty()) write(name + ".swc", specimen.swc);
    if (!groups.empty()) {
        // From the files just written, so that the grid is what `fluovox voxelize` makes of them.
        SpecimenSettings voxelizing;
        voxelizing.voxels.voxel_size_um = settings.voxel_size_um.value_or(info.voxel_size_um);
        voxelizing.labels = info.is_stack;
        const SpecimenResult filled = voxelize_specimen(groups, voxelizing, progress);
        if (progress.stopped()) return files;
        save_dye_grids(folder / (name + ".vdb"), filled.grids);
        files.push_back(folder / (name + ".vdb"));
    }
    write("scene.toml", specimen.scene_toml);
    return files;
}

}  // namespace fluovox
