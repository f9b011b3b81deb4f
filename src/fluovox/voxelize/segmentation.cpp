#include "fluovox/voxelize/segmentation.h"

#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/core/version.h"
#include "fluovox/volume/vdb_internal.h"
#include "fluovox/voxelize/input_bytes.h"
#include "fluovox/voxelize/label_blocks.h"
#include "fluovox/voxelize/label_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace fluovox {
namespace {

/// Where the voxels are: centre of voxel (i, j, k) = first + i steps[0] + j steps[1] + k steps[2].
struct VoxelFrame {
    std::array<Vec3, 3> steps;
    Vec3 first;

    Vec3 size_um() const { return {length(steps[0]), length(steps[1]), length(steps[2])}; }
};

/// Replaces the steps by voxels of the wanted size, along the axes that the file names, if it does.
void resize_voxels(const Vec3& wanted, const LabelVolumeHeader& volume, VoxelFrame& frame) {
    for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        Vec3 along;
        along[axis] = 1;
        frame.steps[i] = wanted[axis] * (volume.steps ? normalized((*volume.steps)[i]) : along);
    }
}

void require_plausible_voxels(const Vec3& size_um, const std::string& name) {
    constexpr double kSmallest = 1e-4;
    constexpr double kLargest = 1e9;
    for (const double side : {size_um.x, size_um.y, size_um.z}) {
        if (side >= kSmallest && side <= kLargest) continue;
        throw InputError(fmt::format("{}: voxels of {:g} um are {}; check the unit, or give --voxel-size X,Y,Z", name,
                                     side, side < kSmallest ? "smaller than an atom" : "far too large"));
    }
}

VoxelFrame voxel_frame(const Segmentation& segmentation, const LabelVolumeHeader& volume,
                       std::vector<std::string>& remarks) {
    const std::string name = segmentation.file.string();
    const double um = segmentation.um_per_unit > 0 ? segmentation.um_per_unit : volume.um_per_unit;
    const bool is_known = volume.steps && um > 0;
    VoxelFrame frame;
    for (std::size_t axis = 0; is_known && axis < 3; ++axis)
        frame.steps[axis] = um * (*volume.steps)[axis];
    if (segmentation.voxel_size_um) {
        const Vec3 wanted = *segmentation.voxel_size_um;
        const Vec3 found = is_known ? frame.size_um() : wanted;
        constexpr double kSame = 1e-3;
        resize_voxels(wanted, volume, frame);
        if (length(found - wanted) > kSame * length(wanted)) {
            remarks.push_back(
                fmt::format("{}: says its voxels are {:.6g} x {:.6g} x {:.6g} um; taken as {:.6g} x "
                            "{:.6g} x {:.6g} um",
                            name, found.x, found.y, found.z, wanted.x, wanted.y, wanted.z));
        }
    } else if (!is_known) {
        throw InputError(fmt::format(
            "{}: does not say {}; add {}--voxel-size X,Y,Z, for example --voxel-size 16nm,16nm,40nm", name,
            volume.missing, volume.steps ? "--mesh-unit nm (or um, mm: what its lengths are in), or " : ""));
    }
    const Vec3 half = 0.5 * (frame.steps[0] + frame.steps[1] + frame.steps[2]);
    frame.first = volume.first && um > 0 ? um * *volume.first : half;
    require_plausible_voxels(frame.size_um(), name);
    return frame;
}

openvdb::math::Transform::Ptr make_transform(const VoxelFrame& frame) {
    openvdb::Mat4d matrix = openvdb::Mat4d::identity();
    for (int row = 0; row < 3; ++row) {
        for (int axis = 0; axis < 3; ++axis)
            matrix(row, axis) = frame.steps[static_cast<std::size_t>(row)][axis];
        matrix(3, row) = frame.first[row];
    }
    return openvdb::math::Transform::createLinearTransform(matrix);
}

/// Numbers the labels as they are met, with what is to become of each.
class LabelTable {
public:
    LabelTable(const Segmentation& segmentation, std::vector<BlockGrid>& grids) : segmentation_(segmentation) {
        labels_.push_back({});
        numbers_.emplace(0, 0);
        for (const SegmentDye& dye : segmentation.dyes) {
            const auto same =
                std::find_if(grids.begin(), grids.end(), [&](const BlockGrid& grid) { return grid.dye == dye.dye; });
            grid_of_dye_.push_back(static_cast<int>(same - grids.begin()));
            if (same == grids.end()) grids.push_back({dye.dye, nullptr});
        }
    }

    std::uint32_t number(std::uint64_t label) {
        if (label == last_label_) return last_number_;
        const auto [at, is_new] = numbers_.emplace(label, static_cast<std::uint32_t>(labels_.size()));
        if (is_new) add(label);
        last_label_ = label;
        return last_number_ = at->second;
    }
    void count(std::uint32_t number, std::uint64_t voxels) { counts_[number] += voxels; }

    const std::vector<BlockLabel>& labels() const { return labels_; }
    std::uint64_t count(std::size_t number) const { return counts_[number]; }

    /// Throws when one of the dyes has no label in the volume.
    void require_all(const std::string& name) const {
        for (std::size_t d = 0; d < segmentation_.dyes.size(); ++d) {
            bool used = false;
            for (std::size_t i = 1; i < labels_.size(); ++i)
                used |= labels_[i].dye == static_cast<int>(d) && counts_[i] > 0;
            if (!used) throw InputError(fmt::format("{}: has {}", name, absence(segmentation_.dyes[d])));
        }
    }

private:
    void add(std::uint64_t label) {
        BlockLabel entry;
        entry.label = label;
        for (std::size_t d = 0; d < segmentation_.dyes.size(); ++d) {
            const SegmentDye& dye = segmentation_.dyes[d];
            const bool chosen =
                dye.labels.empty() || std::any_of(dye.labels.begin(), dye.labels.end(), [label](const auto& range) {
                    return label >= range.first && label <= range.second;
                });
            if (!chosen) continue;
            entry.dye = static_cast<int>(d);
            entry.grid = grid_of_dye_[d];
            entry.value = static_cast<float>(dye.concentration_uM);
            break;
        }
        labels_.push_back(entry);
        counts_.push_back(0);
    }
    std::string absence(const SegmentDye& dye) const {
        std::vector<std::uint64_t> there;
        for (std::size_t i = 1; i < labels_.size(); ++i)
            there.push_back(labels_[i].label);
        if (there.empty()) return "no voxel other than 0";
        std::sort(there.begin(), there.end());
        std::string list;
        constexpr std::size_t kShown = 12;
        for (std::size_t i = 0; i < std::min(kShown, there.size()); ++i)
            list += fmt::format("{}{}", i == 0 ? "" : ", ", there[i]);
        return fmt::format("no label {} (or --clip leaves none of it); it has {} label{}: {}{}", dye.text, there.size(),
                           there.size() == 1 ? "" : "s", list, there.size() > kShown ? " ..." : "");
    }

    const Segmentation& segmentation_;
    std::vector<int> grid_of_dye_;
    std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
    std::vector<BlockLabel> labels_;
    std::vector<std::uint64_t> counts_ = {0};
    std::uint64_t last_label_ = 0;
    std::uint32_t last_number_ = 0;
};

/// Voxels whose centres are in the clip box, as a test along each row.
class ClipTest {
public:
    ClipTest(const std::optional<Bounds>& clip, const VoxelFrame& frame) : clip_(clip), frame_(frame) {}

    bool inside(std::int64_t x, std::int64_t y, std::int64_t z) const {
        if (!clip_) return true;
        return clip_->contains(frame_.first + static_cast<double>(x) * frame_.steps[0] +
                               static_cast<double>(y) * frame_.steps[1] + static_cast<double>(z) * frame_.steps[2]);
    }
    bool all() const { return !clip_; }

private:
    std::optional<Bounds> clip_;
    VoxelFrame frame_;
};

/// Numbers the labels of one slice and counts them.
void number_slice(const std::vector<std::uint64_t>& labels, const LabelVolumeHeader& volume, std::int64_t z,
                  const ClipTest& clip, LabelTable& table, LabelSlab& slab) {
    for (std::int64_t y = 0; y < volume.size[1]; ++y) {
        const auto row = static_cast<std::size_t>(y * volume.size[0]);
        const auto width = static_cast<std::size_t>(volume.size[0]);
        std::uint32_t* const to = slab.row(y, z);
        for (std::size_t x = 0; x < width;) {
            std::size_t end = x + 1;
            while (end < width && labels[row + end] == labels[row + x])
                ++end;
            const std::uint32_t number = table.number(labels[row + x]);
            std::uint64_t kept = end - x;
            std::fill(to + x, to + end, number);
            if (!clip.all() && number != 0) {
                for (std::size_t i = x; i < end; ++i) {
                    if (clip.inside(static_cast<std::int64_t>(i), y, z)) continue;
                    to[i] = 0;
                    --kept;
                }
            }
            table.count(number, kept);
            x = end;
        }
    }
}

GridMetadata describe(const Segmentation& segmentation, const std::string& dye, const std::string& sha256) {
    GridMetadata metadata;
    metadata.dye = dye;
    metadata.value_unit = "umol/L";
    metadata.length_unit = "um";
    metadata.source = segmentation.file.filename().string();
    metadata.source_sha256 = sha256;
    metadata.fluovox_version = version();
    return metadata;
}

}  // namespace

bool is_segmentation_file(const std::filesystem::path& file) {
    const std::string extension = lower_case(file.extension().string());
    return extension == ".tif" || extension == ".tiff" || extension == ".nrrd" || extension == ".nhdr";
}

SpecimenResult voxelize_segmentation(const Segmentation& segmentation, const SpecimenSettings& settings,
                                     Progress& progress) {
    initialize_openvdb();
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    const MappedBytes mapped(segmentation.file);
    const std::string name = segmentation.file.string();
    const std::string extension = lower_case(segmentation.file.extension().string());
    const LabelVolumeFile file{mapped.bytes(), name, segmentation.file.parent_path(), extension.starts_with(".t")};
    const LabelVolumeHeader volume = parse_label_header(file);
    SpecimenResult result;
    const VoxelFrame frame = voxel_frame(segmentation, volume, result.remarks);

    std::vector<BlockGrid> grids;
    LabelTable table(segmentation, grids);
    if (settings.labels) grids.push_back({"", nullptr});
    LabelSlab slab(volume.size[0], volume.size[1]);
    BlockFiller filler(grids, settings.voxels.max_bytes);
    const ClipTest clip(settings.voxels.clip_um, frame);
    progress.start("voxelizing", volume.size[2]);
    read_label_slices(file, volume, [&](std::int64_t z, const std::vector<std::uint64_t>& labels) {
        number_slice(labels, volume, z, clip, table, slab);
        const bool last = z + 1 == volume.size[2];
        if (last || LabelSlab::is_last_of_block(z)) filler.add(slab, z, table.labels());
        progress.advance(1);
        return !progress.stopped();
    });
    if (progress.stopped()) return result;
    table.require_all(name);

    const Vec3 size = frame.size_um();
    result.voxel_size_um = std::max({size.x, size.y, size.z});
    const auto transform = make_transform(frame);
    const std::string sha256 = sha256_hex(file.bytes);
    for (const BlockGrid& grid : filler.finish(transform)) {
        const DyeGrid dye_grid(std::make_shared<DyeGrid::Impl>(DyeGrid::Impl{grid.grid}));
        if (!grid.dye.empty()) {
            describe_dye_grid(dye_grid, grid.dye, describe(segmentation, grid.dye, sha256), settings.half);
        }
        result.grids.push_back(dye_grid);
    }
    const double voxel_um3 = std::abs(dot(frame.steps[0], cross(frame.steps[1], frame.steps[2])));
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    for (std::size_t d = 0; d < segmentation.dyes.size(); ++d) {
        GroupReport report;
        report.dye = segmentation.dyes[d].dye;
        report.concentration_uM = segmentation.dyes[d].concentration_uM;
        report.seconds = d == 0 ? seconds : 0;
        for (std::size_t i = 1; i < table.labels().size(); ++i) {
            if (table.labels()[i].dye != static_cast<int>(d)) continue;
            const std::uint64_t voxels = table.count(i);
            PartReport part;
            part.name = name;
            part.sha256 = sha256;
            part.segment = SegmentReport{table.labels()[i].label, voxels, static_cast<double>(voxels) * voxel_um3};
            report.voxels.voxels += voxels;
            report.voxels.volume_um3 += part.segment->volume_um3;
            report.parts.push_back(std::move(part));
        }
        std::sort(report.parts.begin(), report.parts.end(),
                  [](const PartReport& a, const PartReport& b) { return a.segment->label < b.segment->label; });
        report.voxels.capped_um3 = report.voxels.volume_um3;
        result.groups.push_back(std::move(report));
    }
    return result;
}

}  // namespace fluovox
