#include "fluovox/voxelize/segmentation.h"

#include "fluovox/core/error.h"
#include "fluovox/core/rng.h"
#include "fluovox/voxelize/label_volume.h"

#include "unit/voxelize/damage.h"
#include "unit/voxelize/label_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace fluovox {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class SegmentationFile : public ::testing::Test {
public:
    SegmentationFile() : folder_(fs::temp_directory_path() / ("fluovox_seg_" + std::to_string(::getpid()))) {
        fs::create_directories(folder_);
    }
    ~SegmentationFile() override { fs::remove_all(folder_); }
    SegmentationFile(const SegmentationFile&) = delete;
    SegmentationFile& operator=(const SegmentationFile&) = delete;

protected:
    fs::path write(const std::string& name, const std::string& bytes) const {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return folder_ / name;
    }
    /// Label 7 with EGFP at 5 uM, label 300 with mCherry at 2 uM.
    SpecimenResult fill(const std::string& name, const std::string& bytes, std::optional<Vec3> voxel_um = {}) const {
        Segmentation segmentation;
        segmentation.file = write(name, bytes);
        segmentation.dyes = {{"EGFP", 5, {{7, 7}}, "7"}, {"mCherry", 2, {{299, 301}}, "299-301"}};
        segmentation.voxel_size_um = voxel_um;
        return run(segmentation);
    }
    SpecimenResult run(const Segmentation& segmentation) const {
        NoProgress progress;
        return voxelize_segmentation(segmentation, settings_, progress);
    }
    std::string complaint(const std::string& name, const std::string& bytes, std::optional<Vec3> voxel_um = {}) const {
        try {
            fill(name, bytes, voxel_um);
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }

    fs::path folder_;
    SpecimenSettings settings_;
};

void expect_labels(const SpecimenResult& result, const Vec3& voxel_um) {
    ASSERT_EQ(result.grids.size(), 2U);
    const GridInfo green = inspect_dye_grid(result.grids[0]);
    const GridInfo red = inspect_dye_grid(result.grids[1]);
    const double voxel_litre_mol = voxel_um.x * voxel_um.y * voxel_um.z * 1e-21;
    EXPECT_EQ(green.active_voxels, static_cast<std::uint64_t>(kSevens));
    EXPECT_EQ(red.active_voxels, static_cast<std::uint64_t>(kThreeHundreds));
    EXPECT_NEAR(green.total_mol / (5 * kSevens * voxel_litre_mol), 1, 1e-9);
    EXPECT_NEAR(red.total_mol / (2 * kThreeHundreds * voxel_litre_mol), 1, 1e-9);
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(green.voxel_size_um[axis], voxel_um[axis], 1e-9);
}

constexpr Vec3 kVoxel = {0.016, 0.016, 0.04};

TEST_F(SegmentationFile, TiffStacksOfEveryKindGiveTheirLabels) {
    const std::vector<TiffStyle> styles = {{"w"},
                                           {"wb"},
                                           {"w8", COMPRESSION_LZW},
                                           {"wb", COMPRESSION_ADOBE_DEFLATE},
                                           {"w", COMPRESSION_PACKBITS},
                                           {"wb", COMPRESSION_LZW, true},
                                           {"w", COMPRESSION_NONE, false, true}};
    for (const TiffStyle& style : styles)
        expect_labels(fill("labels.tif", tiff_bytes(style), kVoxel), kVoxel);
}

TEST_F(SegmentationFile, TiffKeepsTheVoxelsOfImageJAndOme) {
    TiffStyle imagej;
    imagej.description = "ImageJ=1.53t\nimages=11\nslices=11\nunit=\\u00B5m\nspacing=0.04\n";
    imagej.pixels_per_unit = 62.5F;
    expect_labels(fill("ij.tif", tiff_bytes(imagej)), kVoxel);
    imagej.description = "ImageJ=1.53t\nimages=11\nslices=11\nunit=nm\nspacing=40\n";
    imagej.pixels_per_unit = 0.0625F;
    expect_labels(fill("ij.tif", tiff_bytes(imagej)), kVoxel);
    TiffStyle ome;
    ome.description =
        "<?xml version=\"1.0\"?><OME><Image ID=\"0\"><Pixels SizeX=\"20\" SizeY=\"17\" SizeZ=\"11\" SizeC=\"1\" "
        "SizeT=\"1\" PhysicalSizeX=\"16\" PhysicalSizeXUnit=\"nm\" PhysicalSizeY=\"0.016\" PhysicalSizeZ=\"0.04\" "
        "PhysicalSizeZUnit=\"\xc2\xb5m\"><TiffData/></Pixels></Image></OME>";
    expect_labels(fill("ome.tif", tiff_bytes(ome)), kVoxel);
    // Writers of plain ASCII, fluovox and Python's among them, give the micro sign by its number.
    for (const char* micro : {"&#181;m", "&#xB5;m", "&#x3bc;m"}) {
        TiffStyle by_number = ome;
        by_number.description.replace(by_number.description.find("\xc2\xb5m"), 3, micro);
        expect_labels(fill("ome-ascii.tif", tiff_bytes(by_number)), kVoxel);
    }
    for (const char* nonsense : {"&#m", "&#;m", "&#x;", "&#99999999999;m", "&#1114112;", "&"}) {
        TiffStyle broken = ome;
        broken.description.replace(broken.description.find("\xc2\xb5m"), 3, nonsense);
        EXPECT_THROW(fill("ome-broken.tif", tiff_bytes(broken)), InputError) << nonsense;
    }
    // An option overrides what the file says, and is told about.
    const SpecimenResult other = fill("ome.tif", tiff_bytes(ome), Vec3{0.02, 0.02, 0.05});
    expect_labels(other, {0.02, 0.02, 0.05});
    ASSERT_EQ(other.remarks.size(), 1U);
    EXPECT_NE(other.remarks[0].find("0.016 x 0.016 x 0.04 um; taken as 0.02 x 0.02 x 0.05"), std::string::npos);
}

// ImageJ writes only the first page of a very large stack; the others follow it bare.
TEST_F(SegmentationFile, BareSlicesAfterTheFirstPageAreRead) {
    const std::string samples = as_bytes(label_samples<std::uint16_t>());
    const std::string description = "ImageJ=1.53t\nimages=11\nslices=11\nunit=um\nspacing=0.04\n";
    std::string bytes = "II";
    const auto put16 = [&](unsigned value) {
        bytes += static_cast<char>(value & 255U);
        bytes += static_cast<char>(value >> 8U);
    };
    const auto put32 = [&](unsigned value) {
        put16(value & 0xffffU);
        put16(value >> 16U);
    };
    const std::vector<std::array<unsigned, 3>> tags = {
        {256, 3, 20}, {257, 3, 17}, {258, 3, 16},  {259, 3, 1}, {262, 3, 1}, {270, 2, 0}, {273, 4, 0},
        {277, 3, 1},  {278, 3, 17}, {279, 4, 680}, {282, 5, 0}, {283, 5, 0}, {296, 3, 1}};
    const auto after = static_cast<unsigned>(8 + 2 + 12 * tags.size() + 4);
    const auto text = static_cast<unsigned>(description.size() + 1);
    put16(42);
    put32(8);
    put16(static_cast<unsigned>(tags.size()));
    for (auto [tag, type, value] : tags) {
        put16(tag);
        put16(type);
        put32(tag == 270 ? text : 1);
        if (tag == 270) value = after;
        if (type == 5) value = after + text;
        if (tag == 273) value = after + text + 8;
        put32(value);
    }
    put32(0);
    bytes += description + '\0';
    put32(125);
    put32(2);
    expect_labels(fill("bare.tif", bytes + samples), kVoxel);
    EXPECT_NE(complaint("bare.tif", bytes + samples.substr(0, 6000)).find("truncated or damaged"), std::string::npos);
}

TEST_F(SegmentationFile, NrrdKeepsItsVoxelsAndItsPlace) {
    expect_labels(fill("a.nrrd", nrrd_bytes("raw", "spacings: 16 16 40\nunits: \"nm\" \"nm\" \"nm\"\n")), kVoxel);
    expect_labels(fill("a.nrrd", nrrd_bytes("gzip", "spacings: 0.016 0.016 0.04\nspace units: \"um\" \"um\" \"um\"\n")),
                  kVoxel);
    // Turned by 90 degrees about z, and elsewhere.
    const std::string turned =
        "space dimension: 3\nspace directions: (0,16,0) (-16,0,0) (0,0,40)\nspace origin: (1000,2000,3000)\n"
        "space units: \"nm\" \"nm\" \"nm\"\n";
    const SpecimenResult result = fill("a.nrrd", nrrd_bytes("gzip", turned));
    expect_labels(result, kVoxel);
    const Bounds box = inspect_dye_grid(result.grids[0]).bbox_um;
    // Voxels x 2..18, y 1..15, z 0..8, with centres at origin + 16 nm (-y, x): half a voxel more on every side.
    EXPECT_NEAR(box.min.x, 1 - 15.5 * 0.016, 1e-9);
    EXPECT_NEAR(box.max.y, 2 + 18.5 * 0.016, 1e-9);
    EXPECT_NEAR(box.min.z, 3 - 0.02, 1e-9);
    const std::string text = [] {
        std::string all;
        for (const std::uint16_t label : label_samples<std::uint16_t>())
            all += std::to_string(label) + '\n';
        return all;
    }();
    expect_labels(fill("a.nrrd", nrrd_bytes("ascii", "", "int", text), kVoxel), kVoxel);
    const auto signed_floats = as_bytes(label_samples<float>());
    expect_labels(fill("a.nrrd", nrrd_bytes("raw", "", "float", signed_floats), kVoxel), kVoxel);
    write("body.raw", "two\nlines\n" + as_bytes(label_samples<std::uint16_t>()));
    const std::string detached = nrrd_bytes("raw", "line skip: 2\ndata file: body.raw\n", "uint16", "\n");
    expect_labels(fill("a.nhdr", detached, kVoxel), kVoxel);
    const std::string at_end = nrrd_bytes("raw", "byte skip: -1\ndata file: body.raw\n", "uint16", "\n");
    expect_labels(fill("a.nhdr", at_end, kVoxel), kVoxel);
}

TEST_F(SegmentationFile, AMaskTakesOneDyeAndALabelGridSaysWhatIsWhere) {
    Segmentation mask;
    mask.file = write("mask.tif", tiff_bytes({}));
    mask.dyes = {{"EGFP", 3, {}, "above 0"}};
    mask.voxel_size_um = Vec3{0.1, 0.1, 0.3};
    settings_.labels = true;
    const SpecimenResult result = run(mask);
    ASSERT_EQ(result.grids.size(), 2U);
    EXPECT_EQ(inspect_dye_grid(result.grids[0]).active_voxels, static_cast<std::uint64_t>(kSevens + kThreeHundreds));
    ASSERT_EQ(result.groups[0].parts.size(), 2U);
    EXPECT_EQ(result.groups[0].parts[1].segment->label, 300U);
    EXPECT_NEAR(result.groups[0].parts[1].segment->volume_um3, kThreeHundreds * 0.003, 1e-12);
    save_dye_grids(folder_ / "labels.vdb", result.grids);
    const auto entries = list_grids(folder_ / "labels.vdb");
    ASSERT_EQ(entries.size(), 2U);
    EXPECT_EQ(entries[1].name, "labels");
    EXPECT_EQ(entries[1].value_type, "int32");
    settings_.voxels.clip_um = Bounds{{0, 0, 0}, {0.42, 10, 10}};  // the centres of voxels 0 to 3 along x
    EXPECT_EQ(inspect_dye_grid(run(mask).grids[0]).active_voxels, 2U * 15 * 9);
    settings_.voxels.clip_um = Bounds{{0, 0, 0}, {0.1, 0.1, 0.1}};
    EXPECT_THROW(run(mask), InputError) << "nothing is left";
}

TEST_F(SegmentationFile, WhatCannotBeRightIsRefusedWithACure) {
    const auto expect = [&](const std::string& name, const std::string& bytes, const std::string& text,
                            std::optional<Vec3> voxel_um = kVoxel) {
        const std::string found = complaint(name, bytes, voxel_um);
        EXPECT_NE(found.find(text), std::string::npos) << text << "\n" << found;
    };
    const std::string raw = nrrd_bytes("raw", "");
    expect("a.tif", "", "is empty");
    expect("a.tif", "II*", "is not a TIFF file");
    expect("a.nrrd", "NRRX", "is not a NRRD file");
    expect("a.nrrd", raw.substr(0, 3000), "truncated or damaged");
    const std::string packed = nrrd_bytes("gzip", "");
    expect("a.nrrd", packed.substr(0, packed.size() - 30), "truncated");
    expect("a.nrrd", nrrd_bytes("bzip2", ""), "encoding \"bzip2\" is not known; save it as raw or gzip");
    expect("a.nrrd", raw, "does not say how large its voxels are; add --voxel-size", {});
    expect("a.nrrd", nrrd_bytes("raw", "spacings: 16 16 40\n"), "in which unit", {});
    expect("a.nrrd", nrrd_bytes("raw", "spacings: 16 0 40\n"), "voxels of no volume", {});
    expect("a.nrrd", nrrd_bytes("raw", "spacings: 16 x 40\n"), "\"x\" is not a number", {});
    expect("a.tif", tiff_bytes({}), "does not say how large its voxels are", {});
    std::vector<float> soft(std::size_t{20} * 17 * 11, 0.5F);
    expect("a.nrrd", nrrd_bytes("raw", "", "float", as_bytes(soft)), "is 0.5: labels are whole numbers; threshold");
    TiffStyle channels;
    channels.description = "ImageJ=1.53t\nimages=11\nchannels=11\nunit=um\nspacing=1\n";
    expect("a.tif", tiff_bytes(channels), "has 11 channels");
    TiffStyle more;
    more.compression = COMPRESSION_LZW;
    more.description = "ImageJ=1.53t\nimages=12\nslices=12\nunit=um\nspacing=1\n";
    expect("a.tif", tiff_bytes(more), "says it has 12 slices, but 11 are here");
    std::string other = raw;
    std::replace(other.begin() + static_cast<std::ptrdiff_t>(other.find("\n\n")), other.end(), '\7', '\6');
    expect("a.nrrd", other, "no label 7 (or --clip leaves none of it); it has 2 labels: 6, 300");
}

/// True when the file was read, false when it was refused.
bool survives(const std::string& bytes, bool is_tiff) {
    try {
        const LabelVolumeFile file{bytes, "m", "/nowhere", is_tiff};
        const LabelVolumeHeader header = parse_label_header(file);
        std::uint64_t sum = 0;
        read_label_slices(file, header, [&](std::int64_t /*z*/, const std::vector<std::uint64_t>& labels) {
            for (const std::uint64_t label : labels)
                sum += label;
            return true;
        });
        return sum != 1;
    } catch (const InputError&) {
        return false;
    }
}

TEST(SegmentationFuzz, DamagedVolumesAreReadOrRefused) {
    const std::vector<std::pair<std::string, bool>> seeds = {
        {tiff_bytes({"w"}), true},
        {tiff_bytes({"wb", COMPRESSION_LZW}), true},
        {tiff_bytes({"w8", COMPRESSION_ADOBE_DEFLATE, true}), true},
        {tiff_bytes({"w", COMPRESSION_PACKBITS, false, true, "ImageJ=1\nimages=11\nspacing=2\nunit=nm\n", 3}), true},
        {nrrd_bytes("raw", "spacings: 1 1 2\nunits: \"um\" \"um\" \"um\"\n"), false},
        {nrrd_bytes("gzip", "space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,3)\n"), false}};
    for (const auto& [bytes, is_tiff] : seeds)
        EXPECT_TRUE(survives(bytes, is_tiff));
    const char* const asked = std::getenv("FLUOVOX_FUZZ");
    const long long runs = asked != nullptr ? std::atoll(asked) : 3000;
    long long refused = 0;
    for (long long run = 0; run < runs; ++run) {
        Rng random(2027, static_cast<std::uint64_t>(run), 0);
        const auto& [bytes, is_tiff] = seeds[static_cast<std::size_t>(run) % seeds.size()];
        refused += survives(damaged(bytes, random, run % 2 == 0 ? 0 : 400), is_tiff) ? 0 : 1;
    }
    EXPECT_GT(refused, runs / 20);
    EXPECT_LT(refused, runs);
}

}  // namespace
}  // namespace fluovox
