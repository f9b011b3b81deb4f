#include "fluovox/core/error.h"
#include "fluovox/core/rng.h"
#include "fluovox/volume/label_field.h"
#include "fluovox/volume/projection.h"
#include "fluovox/volume/sparse_grid.h"
#include "fluovox/volume/vdb_internal.h"

#include <gtest/gtest.h>
#include <openvdb/io/File.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

class VdbFile : public ::testing::Test {
protected:
    void SetUp() override {
        initialize_openvdb();
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    /// A ball of 3 umol/L with soft edges and a tile inside.
    static openvdb::FloatGrid::Ptr ball(const std::string& name) {
        auto grid = new_grid<openvdb::FloatGrid>();
        grid->setName(name);
        grid->setGridClass(openvdb::GRID_FOG_VOLUME);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
        grid->tree().fill(openvdb::CoordBBox(openvdb::Coord(-8), openvdb::Coord(15)), 3.0F, true);
        auto values = grid->getAccessor();
        Rng random(1, 2, 3);
        for (int i = 0; i < 2000; ++i) {
            const auto at = [&] { return static_cast<int>(random.uniform() * 60) - 30; };
            values.setValue({at(), at(), at()}, static_cast<float>(random.uniform()));
        }
        return grid;
    }
    static std::string message(const std::function<void()>& action) {
        try {
            action();
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    }
    static std::string bytes(const fs::path& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    /// A file as another program would write it.
    fs::path foreign() const {
        fs::path file = folder_ / "foreign.vdb";
        openvdb::io::File(file.string()).write({ball("EGFP")});
        return file;
    }
    fs::path write(const std::string& name, const std::string& content) const {
        std::ofstream(folder_ / name, std::ios::binary) << content;
        return folder_ / name;
    }

    const fs::path folder_ =
        fs::path(::testing::TempDir()) /
        (std::string("fluovox_vdb_file_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(VdbFile, GivesBackWhatWasSaved) {
    const auto grid = ball("EGFP");
    set_grid_metadata(*grid, {"EGFP", "umol/L", "um", "cell.ply", "00ff", "0.1.0"});
    save_grids(folder_ / "a.vdb", {grid, ball("DAPI")});
    const auto back = load_float_grid(folder_ / "a.vdb", "EGFP");
    EXPECT_EQ(back->baseTree().activeVoxelCount(), grid->baseTree().activeVoxelCount());
    EXPECT_EQ(back->tree().getValue({-8, 3, 4}), grid->tree().getValue({-8, 3, 4}));
    EXPECT_EQ(grid_metadata(*back).dye, "EGFP");
    EXPECT_EQ(grid_metadata(*back).source_sha256, "00ff");
    EXPECT_DOUBLE_EQ(back->voxelSize().x(), 0.5);
    EXPECT_EQ(load_float_grid(folder_ / "a.vdb", "dapi")->getName(), "DAPI");
}

TEST_F(VdbFile, ReadsHalfFloatsAndEveryCompression) {
    using namespace openvdb::io;
    for (const int compression : {int{COMPRESS_NONE}, int{COMPRESS_ZIP}, int{COMPRESS_ACTIVE_MASK}, int{COMPRESS_BLOSC},
                                  COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK}) {
        for (const bool half : {false, true}) {
            const auto grid = ball("EGFP");
            grid->setSaveFloatAsHalf(half);
            openvdb::io::File out((folder_ / "a.vdb").string());
            out.setCompression(static_cast<std::uint32_t>(compression));
            out.write(openvdb::GridPtrVec{grid});
            const auto back = load_float_grid(folder_ / "a.vdb", "");
            EXPECT_EQ(back->baseTree().activeVoxelCount(), grid->baseTree().activeVoxelCount()) << compression << half;
            EXPECT_EQ(list_grids(folder_ / "a.vdb").at(0).half, half);
        }
    }
}

TEST_F(VdbFile, AFileOfManyPiecesIsReadAsTheLibraryReadsIt) {
    auto grid = new_grid<openvdb::FloatGrid>();
    grid->setName("EGFP");
    Rng random(4, 5, 6);
    auto values = grid->getAccessor();
    for (int x = 0; x < 100; ++x) {
        for (int y = 0; y < 100; ++y) {
            for (int z = 0; z < 100; ++z)
                if (random.uniform() < 0.9) values.setValue({x, y, z}, static_cast<float>(random.uniform()));
        }
    }
    const fs::path file = folder_ / "large.vdb";
    for (const std::uint32_t compression : {openvdb::io::COMPRESS_NONE, openvdb::io::COMPRESS_ZIP}) {
        openvdb::io::File out(file.string());
        out.setCompression(compression | openvdb::io::COMPRESS_ACTIVE_MASK);
        out.write({ball("before"), grid});
        ASSERT_GT(fs::file_size(file), 3U << 20U);
        openvdb::io::File in(file.string());
        in.open();
        const auto expected = openvdb::gridPtrCast<openvdb::FloatGrid>(in.readGrid("EGFP"));
        const auto read = load_float_grid(file, "EGFP");
        ASSERT_EQ(read->baseTree().activeVoxelCount(), expected->baseTree().activeVoxelCount());
        auto other = expected->getConstAccessor();
        for (auto value = read->cbeginValueOn(); value; ++value)
            ASSERT_EQ(*value, other.getValue(value.getCoord())) << value.getCoord();
    }
}

TEST_F(VdbFile, AGridThatSharesTheTreeOfAnotherIsRead) {
    const auto grid = ball("EGFP");
    const auto shared =
        openvdb::gridPtrCast<openvdb::FloatGrid>(openvdb::GridBase::Ptr(grid)->copyGrid());  // shares the tree
    shared->setName("DAPI");
    shared->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    openvdb::io::File((folder_ / "shared.vdb").string()).write({grid, shared});
    const auto read = load_float_grid(folder_ / "shared.vdb", "DAPI");
    EXPECT_EQ(read->baseTree().activeVoxelCount(), grid->baseTree().activeVoxelCount());
    EXPECT_EQ(read->tree().getValue({-8, 3, 4}), 3.0F);
    EXPECT_DOUBLE_EQ(read->voxelSize().x(), 0.25);
    EXPECT_EQ(read->getName(), "DAPI");
}

TEST_F(VdbFile, NamesTheGridsOfTheFileWhenOneIsMissing) {
    save_grids(folder_ / "a.vdb", {ball("EGFP"), ball("DAPI")});
    const std::string text = message([&] { load_float_grid(folder_ / "a.vdb", "mCherry"); });
    EXPECT_NE(text.find("\"EGFP\", \"DAPI\""), std::string::npos) << text;
    EXPECT_NE(message([&] { load_float_grid(folder_ / "a.vdb", ""); }).find("several"), std::string::npos);
}

TEST_F(VdbFile, OfSeveralGridsOfOneNameNoneIsTakenUnasked) {
    const auto other = ball("EGFP");
    other->tree().setValue({0, 0, 0}, 7.0F);
    save_grids(folder_ / "a.vdb", {ball("EGFP"), other, ball("DAPI")});
    const std::string text = message([&] { load_float_grid(folder_ / "a.vdb", "EGFP"); });
    EXPECT_NE(text.find("a.vdb: has several grids named \"EGFP\": ask for one of \"EGFP[0]\", \"EGFP[1]\" (in a scene"),
              std::string::npos)
        << text;
    EXPECT_EQ(message([&] { require_grid(folder_ / "a.vdb", "EGFP"); }), text);
    EXPECT_EQ(load_float_grid(folder_ / "a.vdb", "EGFP[0]")->tree().getValue({0, 0, 0}), 3.0F);
    EXPECT_EQ(load_float_grid(folder_ / "a.vdb", "egfp[1]")->tree().getValue({0, 0, 0}), 7.0F);
    EXPECT_EQ(load_float_grid(folder_ / "a.vdb", "DAPI")->getName(), "DAPI");
    const auto infos = inspect_grids(folder_ / "a.vdb");
    ASSERT_EQ(infos.size(), 3U);
    EXPECT_EQ(infos[1].entry.name, "EGFP[1]");
    EXPECT_EQ(infos[0].max, 3);
    EXPECT_EQ(infos[1].max, 7);
    // Nor of two that differ in case only, unless one is named exactly.
    save_grids(folder_ / "b.vdb", {ball("EGFP"), ball("Egfp")});
    EXPECT_EQ(load_float_grid(folder_ / "b.vdb", "Egfp")->getName(), "Egfp");
    EXPECT_NE(message([&] { load_float_grid(folder_ / "b.vdb", "egfp"); }).find("several grids"), std::string::npos);
    // A grid without a name, among others, can be asked for as well.
    save_grids(folder_ / "c.vdb", {ball(""), ball("DAPI")});
    EXPECT_EQ(inspect_grids(folder_ / "c.vdb").at(0).entry.name, "[0]");
}

TEST_F(VdbFile, RefusesALevelSetAndNamesTheCommandThatConvertsIt) {
    const auto grid = ball("sdf");
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    save_grids(folder_ / "a.vdb", {grid});
    const std::string text = message([&] { load_float_grid(folder_ / "a.vdb", "sdf"); });
    EXPECT_NE(text.find("level set"), std::string::npos) << text;
    EXPECT_NE(text.find("fluovox voxelize --from-levelset"), std::string::npos) << text;
    EXPECT_NO_THROW(load_any_float_grid(folder_ / "a.vdb", "sdf"));
}

TEST_F(VdbFile, CountsValuesThatAreNoConcentrationsAndSaysWhereTheFirstIs) {
    const auto grid = ball("EGFP");
    auto values = grid->getAccessor();
    values.setValue({40, 1, 2}, std::nanf(""));
    values.setValue({41, 1, 2}, INFINITY);
    values.setValue({39, 7, 8}, -1.5F);
    grid->tree().addTile(1, {128, 0, 0}, -2.0F, true);
    save_grids(folder_ / "a.vdb", {grid});
    const std::string text = message([&] { load_float_grid(folder_ / "a.vdb", "EGFP"); });
    EXPECT_NE(text.find("515 voxels"), std::string::npos) << text;
    EXPECT_NE(text.find("1 NaN, 1 infinite, 513 negative"), std::string::npos) << text;
    EXPECT_NE(text.find("voxel [39, 7, 8], position [19.5"), std::string::npos) << text;
}

TEST_F(VdbFile, RefusesOtherValueTypesByName) {
    const auto grid = new_grid<openvdb::DoubleGrid>();
    grid->setName("density");
    save_grids(folder_ / "a.vdb", {grid, new_grid<openvdb::Int32Grid>()});
    EXPECT_NE(message([&] { load_float_grid(folder_ / "a.vdb", "density"); }).find("double"), std::string::npos);
    EXPECT_EQ(list_grids(folder_ / "a.vdb").at(1).value_type, "int32");
}

TEST_F(VdbFile, MissingEmptyAndForeignFilesSayWhatIsWrong) {
    EXPECT_NE(message([&] { list_grids(folder_ / "none.vdb"); }).find("No such file"), std::string::npos);
    EXPECT_NE(message([&] { list_grids(write("empty.vdb", "")); }).find("is empty"), std::string::npos);
    EXPECT_NE(message([&] { list_grids(write("text.vdb", "this is some text, no grid")); }).find("not a VDB"),
              std::string::npos);
    EXPECT_NE(message([&] { list_grids(folder_); }).find("is not a file"), std::string::npos);
}

TEST_F(VdbFile, EveryTruncationIsNoticed) {
    save_grids(folder_ / "a.vdb", {ball("EGFP")});
    const std::string whole = bytes(folder_ / "a.vdb");
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 97) {
        const fs::path cut = write("cut.vdb", whole.substr(0, length));
        EXPECT_THROW(load_float_grid(cut, "EGFP"), InputError) << length;
    }
}

TEST_F(VdbFile, DamagedBytesNeverCrashOrHang) {
    const std::string whole = bytes(foreign());  // without a checksum, which would find all of it
    int refused = 0;
    for (std::uint64_t trial = 0; trial < 400; ++trial) {
        Rng random(7, trial, 0);
        std::string damaged = whole;
        // Mostly in the first kilobytes, where the counts and sizes are.
        const double reach = trial % 2 == 0 ? 1200.0 : static_cast<double>(whole.size());
        for (int flips = 0; flips < 4; ++flips) {
            damaged[static_cast<std::size_t>(random.uniform() * reach)] =
                static_cast<char>(static_cast<int>(random.uniform() * 256));
        }
        const fs::path file = write("damaged.vdb", damaged);
        refused += message([&] { load_float_grid(file, ""); }).empty() ? 0 : 1;
    }
    EXPECT_GT(refused, 50);
}

TEST_F(VdbFile, InAFileOfOursEveryFlippedBitIsFound) {
    save_grids(folder_ / "a.vdb", {ball("EGFP")});
    const std::string whole = bytes(folder_ / "a.vdb");
    int told = 0;
    for (std::uint64_t trial = 0; trial < 300; ++trial) {
        Rng random(8, trial, 0);
        std::string damaged = whole;
        constexpr std::size_t kLine = 24;  // the checksum's own
        auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(whole.size() - kLine));
        if (trial == 0) at = whole.size() - 3;  // one of its digits
        if (at >= 21 && at < 57) continue;      // the file's random identifier
        damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ (1U << (trial % 8)));
        const std::string said = message([&] { load_float_grid(write("damaged.vdb", damaged), ""); });
        EXPECT_FALSE(said.empty()) << at;
        told += said.find("checksum") != std::string::npos ? 1 : 0;
    }
    EXPECT_GT(told, 100);
}

TEST_F(VdbFile, TheSameGridGivesTheSameChecksumAndFilesWithoutOneAreRead) {
    const auto last_line = [](const fs::path& file) {
        const std::string all = bytes(file);
        return all.substr(all.size() - 24);
    };
    save_grids(folder_ / "a.vdb", {ball("EGFP")});
    save_grids(folder_ / "b.vdb", {ball("EGFP")});
    EXPECT_EQ(last_line(folder_ / "a.vdb"), last_line(folder_ / "b.vdb"));
    EXPECT_EQ(last_line(folder_ / "a.vdb").substr(0, 15), "\nfluovox crc32 ");
    // OpenVDB reads ours, and what it writes anew has no checksum that would be of other bytes.
    openvdb::io::File in((folder_ / "a.vdb").string());
    in.open();
    const auto grids = in.getGrids();
    openvdb::io::File((folder_ / "c.vdb").string()).write(*grids);
    EXPECT_EQ(last_line(folder_ / "c.vdb").find("fluovox crc32"), std::string::npos);
    EXPECT_EQ(message([&] { load_float_grid(folder_ / "c.vdb", ""); }), "");
    EXPECT_EQ(message([&] { load_float_grid(write("d.vdb", bytes(folder_ / "c.vdb") + "something else"), ""); }), "");
}

TEST_F(VdbFile, TheSameGridGivesTheSameBytes) {
    const auto identifier = [&](const char* file) { return bytes(folder_ / file).substr(21, 36); };
    const auto other = ball("EGFP");
    other->tree().setValue({0, 0, 0}, 0.125F);
    save_grids(folder_ / "a.vdb", {ball("EGFP")});
    save_grids(folder_ / "b.vdb", {ball("EGFP")});
    save_grids(folder_ / "other.vdb", {other});
    EXPECT_TRUE(bytes(folder_ / "a.vdb") == bytes(folder_ / "b.vdb")) << identifier("a.vdb") << identifier("b.vdb");
    EXPECT_NE(identifier("a.vdb"), identifier("other.vdb"));
    openvdb::io::File in((folder_ / "a.vdb").string());
    in.open();
    EXPECT_EQ(in.getUniqueTag(), identifier("a.vdb"));
    EXPECT_EQ(in.getGrids()->size(), 1U);
}

TEST_F(VdbFile, OfATileBeyondAnySpecimenTheCureIsARegion) {
    const auto grid = ball("EGFP");
    grid->tree().addTile(3, {8192, 0, 0}, 1.0F, true);
    save_grids(folder_ / "a.vdb", {grid});
    const std::string said = message([&] {
        SparseGrid::load(folder_ / "a.vdb", "EGFP", [](const GridMetadata& /*unknown*/) { return GridScale{}; });
    });
    EXPECT_NE(said.find("a.vdb: grid \"EGFP\": has a constant tile"), std::string::npos) << said;
    EXPECT_NE(said.find("medium with a region"), std::string::npos) << said;
}

TEST_F(VdbFile, ABackgroundFinerThanAGridIsPackedIsRead) {
    for (const float background : {1e-6F, 2e-5F, 1e-4F, 1e-3F}) {
        auto grid = new_grid<openvdb::FloatGrid>(background);
        grid->setName("EGFP");
        auto values = grid->getAccessor();
        for (int i = 0; i < 512; ++i)  // just below the background, also in the first layers
            values.setValue({i >> 6, (i >> 3) & 7, i & 7}, 0.99F * background);
        values.setValue({4, 4, 4}, 10);
        save_grids(folder_ / "a.vdb", {grid});
        const SparseGrid packed =
            SparseGrid::load(folder_ / "a.vdb", "EGFP", [](const GridMetadata& /*unknown*/) { return GridScale{}; });
        EXPECT_NEAR(packed.trilinear({4, 4, 4}), 10, 1e-3);
        EXPECT_NEAR(packed.trilinear({-0.5, 0, 0}), static_cast<double>(background),
                    1e-4 + 0.02 * static_cast<double>(background));
        EXPECT_GE(packed.max(), 10);
    }
}

TEST_F(VdbFile, VoxelsAnAbsurdWayApartAreRefusedInsteadOfPassedOneByOne) {
    const auto grid = ball("EGFP");
    grid->tree().setValue({0, 0, -268439552}, 1.0F);
    save_grids(folder_ / "a.vdb", {grid});
    const std::string said = message([&] {
        SparseGrid::load(folder_ / "a.vdb", "EGFP", [](const GridMetadata& /*unknown*/) { return GridScale{}; });
    });
    EXPECT_NE(said.find("a.vdb: grid \"EGFP\": its voxels are spread too far apart"), std::string::npos) << said;
}

TEST_F(VdbFile, VoxelsAtBothEndsOfAllNumbersAreRefusedToo) {
    const auto grid = ball("EGFP");
    grid->tree().setValue({1 << 30, 0, 0}, 1.0F);
    grid->tree().setValue({-(1 << 30), 0, 0}, 1.0F);
    save_grids(folder_ / "a.vdb", {grid});
    const std::string said = message([&] {
        SparseGrid::load(folder_ / "a.vdb", "EGFP", [](const GridMetadata& /*unknown*/) { return GridScale{}; });
    });
    EXPECT_NE(said.find("a.vdb: grid \"EGFP\": its voxels are spread too far apart"), std::string::npos) << said;
}

TEST_F(VdbFile, VoxelsAtBothEndsOfAllNumbersAreProjectedIntoAPictureOfTheSizeAskedFor) {
    auto grid = new_grid<openvdb::FloatGrid>();
    grid->setName("EGFP");
    grid->tree().setValue({1 << 30, 0, 3}, 1.0F);
    grid->tree().setValue({-(1 << 30), 1 << 30, 3}, 2.0F);
    save_grids(folder_ / "a.vdb", {grid});
    const auto pictures = project_grids(folder_ / "a.vdb", 64);
    ASSERT_EQ(pictures.size(), 1U);
    const Projection& picture = pictures[0];
    EXPECT_LE(picture.width, 65);
    EXPECT_LE(picture.height, 33);
    ASSERT_EQ(picture.values.size(),
              static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
    EXPECT_EQ(picture.values.front(), 2.0F);
    EXPECT_EQ(picture.values.back(), 1.0F);
}

TEST_F(VdbFile, LabelsAreNobodysWhereTheTreeHasNoPlaces) {
    auto grid = new_grid<openvdb::Int32Grid>();
    grid->setName("labels");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1e-3));
    grid->tree().setValue({1000, 0, 0}, 7);
    openvdb::io::File((folder_ / "a.vdb").string()).write(openvdb::GridPtrVec{grid});
    const auto labels = LabelField::load(folder_ / "a.vdb", 1);
    ASSERT_TRUE(labels);
    EXPECT_EQ(labels->at({1, 0, 0}), 7);
    for (const double far : {2147483.6475, -2147484.0, 1e12, -1e300})
        EXPECT_EQ(labels->at({1, far, 0}), 0);
}

TEST_F(VdbFile, WhatTheFormatSaysTwiceMustBeTheSame) {
    const std::string whole = bytes(foreign());
    const auto with_flip = [&](std::size_t at, unsigned bit) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) ^ (1U << bit));
        return message([&] { load_float_grid(write("damaged.vdb", damaged), ""); });
    };
    const std::string map = "UniformScaleMap";
    const std::size_t numbers = whole.find(map) + map.size();
    constexpr std::size_t kExponent = 6;  // the upper byte but one of a double
    for (const std::size_t number : {std::size_t{0}, std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{8}}) {
        EXPECT_NE(with_flip(numbers + 8 * number + kExponent, 4).find("contradict each other"), std::string::npos);
    }
    // The first mask of the first leaf lies between the tree's inner nodes and the values.
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(load_float_grid(foreign(), ""));
    const auto& leaf = *grid->tree().cbeginLeaf();
    std::string mask(64, '\0');
    for (std::size_t bit = 0; bit < 512; ++bit) {
        if (leaf.isValueOn(static_cast<openvdb::Index>(bit)))
            mask[bit / 8] = static_cast<char>(static_cast<unsigned char>(mask[bit / 8]) | (1U << (bit % 8)));
    }
    const std::size_t first = whole.find(mask);
    const std::size_t second = whole.find(mask, first + 1);
    ASSERT_NE(second, std::string::npos);
    EXPECT_NE(with_flip(second + 5, 3).find("the two masks of a leaf"), std::string::npos);
    EXPECT_NE(with_flip(first + 5, 3), "");
}

TEST_F(VdbFile, AFailedWriteLeavesTheOldFile) {
    EXPECT_THROW(save_grids(folder_ / "nowhere" / "a.vdb", {ball("EGFP")}), OutputError);
}

TEST_F(VdbFile, StatisticsCountTilesAndGiveTheAmountOfSubstance) {
    auto grid = new_grid<openvdb::FloatGrid>();
    grid->setName("EGFP");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->sparseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(15)), 4.0F, true);
    save_grids(folder_ / "a.vdb", {grid});
    const GridInfo info = inspect_grids(folder_ / "a.vdb").at(0);
    EXPECT_EQ(info.active_voxels, 4096U);
    EXPECT_DOUBLE_EQ(info.mean, 4);
    EXPECT_DOUBLE_EQ(info.bbox_um.min.x, -0.25);
    EXPECT_DOUBLE_EQ(info.bbox_um.max.z, 7.75);
    // 8^3 um^3 = 5.12e-13 L of 4 umol/L
    EXPECT_NEAR(info.total_mol, 4e-6 * 5.12e-13, 1e-30);
}

}  // namespace
}  // namespace fluovox
