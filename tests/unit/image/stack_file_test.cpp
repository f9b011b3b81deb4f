#include "fluovox/image/stack_file.h"

#include "fluovox/core/error.h"
#include "fluovox/image/apng.h"
#include "fluovox/image/imagej_metadata.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

StackInfo large_stack(int width, int height, int planes) {
    StackInfo info;
    info.title = "a \"title\" <&> of µm";
    info.width = width;
    info.height = height;
    info.planes = planes;
    info.channels = {StackChannel{}, StackChannel{}};
    info.channels[0].name = "green";
    info.channels[1].name = "red";
    info.channels[1].has_efficiency = true;
    info.pixel_um = 0.65;
    info.step_um = 2;
    for (int plane = 0; plane < planes; ++plane)
        info.positions_um.push_back({1, 2, 2.0 * plane});
    info.quantity = "radiance";
    info.scene_json = "{ \"title\": \"a < b & c\" }";
    info.key = "0123";
    return info;
}

float value_of(int plane, int channel, std::size_t pixel) {
    return static_cast<float>(1000 * plane + 100 * channel) + 1e-3F * static_cast<float>(pixel % 5000);
}

void fill(int plane, int channel, std::span<float> values) {
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = value_of(plane, channel, i);
}

class StackFileTest : public ::testing::Test {
public:
    StackFileTest() : folder_(fs::path(::testing::TempDir()) / ("fluovox_stack_" + std::to_string(::getpid()))) {
        fs::create_directories(folder_);
    }
    ~StackFileTest() override {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }
    StackFileTest(const StackFileTest&) = delete;
    StackFileTest& operator=(const StackFileTest&) = delete;

protected:
    fs::path at(const std::string& name) const { return folder_ / name; }

private:
    fs::path folder_;
};

TEST_F(StackFileTest, ReadsBackEveryPageInAnyOrderAndWhatIsSaidOfThem) {
    StackInfo written = large_stack(130, 70, 3);
    written.origin_um = Vec3{1, 2, 3};
    save_ome_tiff(at("s.ome.tif"), written, fill);
    StackFile file(at("s.ome.tif"));
    EXPECT_EQ(to_json(file.info()), to_json(written));
    EXPECT_EQ(file.info().scene_json, written.scene_json);
    std::vector<float> values(written.pixels());
    for (const int page : {5, 0, 1, 2, 4, 3, 3}) {
        file.read(page / 2, page % 2, values);
        for (const std::size_t pixel : {std::size_t{0}, std::size_t{4999}, written.pixels() - 1})
            EXPECT_EQ(values[pixel], value_of(page / 2, page % 2, pixel)) << page;
    }
}

TEST_F(StackFileTest, CountsComeBackAsTheirWorth) {
    StackInfo written = large_stack(100, 100, 1);
    written.type = SampleType::UInt16;
    written.value_per_count = 0.25;
    save_ome_tiff(at("s.ome.tif"), written, [](int /*plane*/, int /*channel*/, std::span<float> values) {
        std::fill(values.begin(), values.end(), 10.1F);
        values[1] = -3;
        values[2] = 1e9F;
        values[3] = std::numeric_limits<float>::quiet_NaN();
    });
    StackFile file(at("s.ome.tif"));
    std::vector<float> values(written.pixels());
    file.read(0, 1, values);
    EXPECT_EQ(values[0], 10.0F);
    EXPECT_EQ(values[1], 0.0F);
    EXPECT_EQ(values[2], 0.25F * 65535);
    EXPECT_EQ(values[3], 0.0F);
}

TEST_F(StackFileTest, DamageIsFoundAndAnExistingFileSurvivesAFailure) {
    const StackInfo info = large_stack(130, 70, 2);
    save_ome_tiff(at("s.ome.tif"), info, fill);
    const auto size = fs::file_size(at("s.ome.tif"));
    EXPECT_THROW(save_ome_tiff(at("s.ome.tif"), info,
                               [](int plane, int /*channel*/, std::span<float> /*values*/) {
                                   if (plane == 1) throw InputError("stop");
                               }),
                 InputError);
    EXPECT_EQ(fs::file_size(at("s.ome.tif")), size);
    std::vector<float> values(info.pixels());
    for (std::uintmax_t left = 0; left + 1000 < size; left += size / 23) {  // at the very end are only resolutions
        fs::copy_file(at("s.ome.tif"), at("cut.ome.tif"), fs::copy_options::overwrite_existing);
        fs::resize_file(at("cut.ome.tif"), left);
        EXPECT_THROW(
            {
                StackFile cut(at("cut.ome.tif"));
                for (int page = 0; page < 4; ++page)
                    cut.read(page / 2, page % 2, values);
            },
            InputError)
            << left;
    }
}

TEST_F(StackFileTest, EveryLevelOfAnOmeZarrLiesWhereTheStackDoes) {
    StackInfo info = large_stack(400, 300, 2);
    info.origin_um = Vec3{-10, 20, 30};
    save_ome_zarr(at("s.ome.zarr"), info, fill);
    std::ifstream in(at("s.ome.zarr") / ".zattrs");
    const auto levels = nlohmann::json::parse(in).at("multiscales").at(0).at("datasets");
    ASSERT_EQ(levels.size(), 3U);
    for (std::size_t level = 0; level < 3; ++level) {
        const double pixel_um = 0.65 * static_cast<double>(1U << level);
        const auto& places = levels[level].at("coordinateTransformations");
        ASSERT_EQ(places.size(), 2U);
        EXPECT_EQ(places[0].at("type"), "scale");
        EXPECT_EQ(places[0].at("scale"), nlohmann::json({1, 2, pixel_um, pixel_um}));
        EXPECT_EQ(places[1].at("type"), "translation");
        const std::vector<double> first = places[1].at("translation");
        // The corner of the picture is the same for all.
        EXPECT_EQ(first.at(0), 0);
        EXPECT_EQ(first.at(1), 30);
        EXPECT_NEAR(first.at(2) - pixel_um / 2, 20 - 0.65 / 2, 1e-12);
        EXPECT_NEAR(first.at(3) - pixel_um / 2, -10 - 0.65 / 2, 1e-12);
    }
}

// One range for all would leave a dim channel black at first sight.
TEST_F(StackFileTest, EachChannelOfAnOmeZarrIsShownByItsOwnBrightness) {
    const StackInfo info = [] {
        StackInfo stack = large_stack(40, 30, 2);
        stack.max_value = 500;
        return stack;
    }();
    save_ome_zarr(at("s.ome.zarr"), info, [](int /*plane*/, int channel, std::span<float> values) {
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = (channel == 0 ? 500.0F : 5.0F) * static_cast<float>(i % 100) / 99;
    });
    std::ifstream in(at("s.ome.zarr") / ".zattrs");
    const auto channels = nlohmann::json::parse(in).at("omero").at("channels");
    ASSERT_EQ(channels.size(), 2U);
    EXPECT_NEAR(channels[0].at("window").at("end").get<double>(), 500, 10);
    EXPECT_NEAR(channels[1].at("window").at("end").get<double>(), 5, 0.1);
    EXPECT_EQ(channels[1].at("window").at("max").get<double>(), 500);
}

TEST_F(StackFileTest, AnOmeZarrReadsBackInAnyOrderAndDamageInAnyChunkIsFound) {
    for (const SampleType type : {SampleType::Float32, SampleType::UInt16}) {
        StackInfo written = large_stack(130, 70, 3);
        written.type = type;
        written.value_per_count = 0.5;
        save_ome_zarr(at("s.ome.zarr"), written, fill);
        StackFile file(at("s.ome.zarr"));
        EXPECT_EQ(to_json(file.info()), to_json(written));
        EXPECT_EQ(file.info().scene_json, written.scene_json);
        std::vector<float> values(written.pixels());
        for (const int page : {5, 0, 1, 2, 4, 3, 3}) {
            file.read(page / 2, page % 2, values);
            for (const std::size_t pixel : {std::size_t{0}, std::size_t{4999}, written.pixels() - 1}) {
                const float value = value_of(page / 2, page % 2, pixel);
                EXPECT_EQ(values[pixel], type == SampleType::Float32 ? value : 0.5F * std::round(value / 0.5F)) << page;
            }
        }
        const fs::path chunk = at("s.ome.zarr") / "0/1/2/0/0";
        // The checksum is last; a bit of the packed values may be flipped and give the same, where they repeat.
        std::fstream out(chunk, std::ios::binary | std::ios::in | std::ios::out);
        out.seekg(-1, std::ios::end);
        const auto byte = static_cast<char>(out.get() ^ 4);
        out.seekp(-1, std::ios::end);
        out.put(byte);
        out.close();
        EXPECT_THROW(file.read(2, 1, values), InputError);
        EXPECT_NO_THROW(file.read(2, 0, values));
        fs::resize_file(at("s.ome.zarr") / "0/0/0/0/0", 10);
        EXPECT_THROW(file.read(0, 0, values), InputError);
    }
}

TEST_F(StackFileTest, AnOmeZarrThatAnotherProgramPackedIsRefusedNotMisread) {
    save_ome_zarr(at("s.ome.zarr"), large_stack(130, 70, 3), fill);
    const fs::path file = at("s.ome.zarr") / "0/.zarray";
    const auto ours = nlohmann::json::parse(std::ifstream(file));
    for (const auto& [key, value] : {std::pair<const char*, nlohmann::json>{"dtype", "<f8"},
                                     {"chunks", {1, 1, 64, 64}},
                                     {"compressor", {{"id", "blosc"}}},
                                     {"compressor", nullptr},
                                     {"shape", {2, 2, 70, 130}},
                                     {"order", "F"}}) {
        nlohmann::json other = ours;
        other[key] = value;
        std::ofstream(file) << other;
        EXPECT_THROW(StackFile(at("s.ome.zarr")), InputError) << key;
    }
    std::ofstream(file) << ours;
    EXPECT_NO_THROW(StackFile(at("s.ome.zarr")));
}

TEST_F(StackFileTest, AnImageJHyperstackReadsBackWhateverItsScript) {
    for (const SampleType type : {SampleType::Float32, SampleType::UInt16}) {
        StackInfo written = large_stack(131, 71, 3);
        written.title = "of µm, 細胞 and \xF0\x9F\x94\xAC";
        written.scene_json = "{\n  \"title\": \"of µm\"\n}";
        written.channels[1].name = "röt";
        written.type = type;
        written.value_per_count = 0.5;
        save_imagej_tiff(at("s.tif"), written, fill);
        StackFile file(at("s.tif"));
        EXPECT_EQ(to_json(file.info()), to_json(written));
        EXPECT_EQ(file.info().scene_json, written.scene_json);
        std::vector<float> values(written.pixels());
        for (const int page : {5, 0, 1, 2, 4, 3, 3}) {
            file.read(page / 2, page % 2, values);
            for (const std::size_t pixel : {std::size_t{0}, std::size_t{4999}, written.pixels() - 1}) {
                const float value = value_of(page / 2, page % 2, pixel);
                EXPECT_EQ(values[pixel], type == SampleType::Float32 ? value : 0.5F * std::round(value / 0.5F)) << page;
            }
        }
        const auto size = fs::file_size(at("s.tif"));
        for (std::uintmax_t left = 0; left < size; left += size / 23) {
            fs::copy_file(at("s.tif"), at("cut.tif"), fs::copy_options::overwrite_existing);
            fs::resize_file(at("cut.tif"), left);
            EXPECT_THROW(StackFile(at("cut.tif")), InputError) << left;
        }
    }
}

TEST(DisplayRanges, LeaveAThousandthOfTheLitPixelsAboveAndDoNotLetThemDarkenTheRest) {
    StackInfo info = large_stack(100, 100, 1);
    DisplayRanges ranges(info);
    std::vector<float> values(20000, 0.0F);
    for (std::size_t i = 0; i < 10000; ++i)  // half of the pixels: 1 ... 2
        values[i] = 1 + 1e-4F * static_cast<float>(i);
    values[7] = 1e6F;
    values[8] = std::numeric_limits<float>::infinity();
    values[9] = std::numeric_limits<float>::quiet_NaN();
    ranges.add(1, values);
    EXPECT_EQ(ranges.range(1).low, 0);
    EXPECT_NEAR(ranges.range(1).high, 2, 0.02);
    EXPECT_EQ(ranges.range(0).low, 0) << "a channel that is dark";
    EXPECT_EQ(ranges.range(0).high, 1);
    ranges.add(0, std::vector<float>(100, 5.0F));
    EXPECT_EQ(ranges.range(0).low, 0) << "one value alone is not black";
    EXPECT_EQ(ranges.range(0).high, 5);
    for (float& value : values)  // counts of a camera stand on an offset
        value = std::isfinite(value) ? 100 + value : 100.0F;
    DisplayRanges counts(info);
    counts.add(0, values);
    EXPECT_EQ(counts.range(0).low, 100);
    EXPECT_NEAR(counts.range(0).high, 102, 0.8);
}

TEST(DisplayRanges, OfLabelsReachToTheLargestAndCountsAreInCounts) {
    StackInfo info = large_stack(100, 100, 1);
    info.type = SampleType::UInt16;
    info.value_per_count = 0.25;
    DisplayRanges counts(info);
    counts.add(0, std::vector<float>{0, 1, 8});
    EXPECT_EQ(counts.range(0).high, 32);
    info.quantity = "labels";
    info.value_per_count = 1;
    DisplayRanges labels(info);
    std::vector<float> values(100000, 1.0F);
    values[5] = 40001;  // one voxel is an object too
    labels.add(0, values);
    EXPECT_EQ(labels.range(0).low, 0);
    EXPECT_EQ(labels.range(0).high, 40001);
}

TEST_F(StackFileTest, PlainImageJGetsNoFileItCannotRead) {
    StackInfo info = large_stack(8192, 8192, 20);
    try {
        save_imagej_tiff(at("s.tif"), info, fill);
        FAIL();
    } catch (const OutputError& e) {
        EXPECT_NE(std::string(e.what()).find("no TIFF over 4 GB, and this one would have 10.7 GB"), std::string::npos);
    }
    EXPECT_FALSE(fs::exists(at("s.tif")));
}

TEST_F(StackFileTest, OnlyFilesOver4GBAreBigTiffs) {
    // The first bytes are on disk before the first page is asked for again.
    const auto version = [&](int planes) {
        char seen = 0;
        try {
            save_ome_tiff(at("s.ome.tif"), large_stack(4096, 4096, planes),
                          [&](int plane, int channel, std::span<float> /*values*/) {
                              if (plane == 0 && channel == 0) return;
                              for (const auto& entry : fs::directory_iterator(at("."))) {
                                  std::ifstream in(entry.path(), std::ios::binary);
                                  in.seekg(2);
                                  in.get(seen);
                              }
                              throw InputError("enough");
                          });
        } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): thrown above
        }
        return static_cast<int>(seen);
    };
    EXPECT_EQ(version(31), 42);  // 4.16 GB of 4.29
    EXPECT_EQ(version(33), 43);
}

TEST(Animation, IsAPngWhoseFramesFollowTheFirst) {
    std::vector<Picture> frames(3, Picture(5, 4));
    frames[1].at(2, 2)[0] = 200;
    const std::string bytes = to_apng(frames, 120);
    EXPECT_EQ(bytes.substr(1, 3), "PNG");
    std::size_t controls = 0;
    for (std::size_t at = 0; (at = bytes.find("fcTL", at)) != std::string::npos; ++at)
        ++controls;
    EXPECT_EQ(controls, 3U);
    EXPECT_LT(bytes.find("acTL"), bytes.find("IDAT"));
    EXPECT_LT(bytes.find("IDAT"), bytes.find("fdAT"));
    EXPECT_THROW(to_apng({}, 100), std::invalid_argument);
    EXPECT_THROW(to_apng({Picture(2, 2), Picture(3, 2)}, 100), std::invalid_argument);
}

}  // namespace
}  // namespace fluovox
