// What lies on the disk while a stack is made: planes kept, runs stopped and gone on with, what is in the way.

#include "cli/stack_fixture.h"

#include <nlohmann/json.hpp>

#include <csignal>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

namespace fs = std::filesystem;

TEST_F(StackTest, KilledAtAnyPlaneAndRunAgainGivesTheSameBytes) {
    const std::vector<std::string> slow = {"--samples", "500", "--progress", "none"};
    const auto command = [&](const std::string& name) {
        std::vector<std::string> arguments = {"render", "scene.toml", "-o", name};
        arguments.insert(arguments.end(), slow.begin(), slow.end());
        return arguments;
    };
    ASSERT_EQ(run(command("whole.ome.tif")).exit_code, 0);
    int killed = 0;
    for (std::size_t planes = 0; planes < 7; ++planes) {
        RunLimits limits;
        limits.signal_when = [&] {
            return fs::exists(folder() / "killed.ome.tif.planes") && planes_there("killed.ome.tif") > planes;
        };
        killed += run(command("killed.ome.tif"), limits).exit_code == 128 + SIGKILL ? 1 : 0;
    }
    EXPECT_GE(killed, 4) << "the program was too quick to be killed";
    ASSERT_EQ(run(command("killed.ome.tif")).exit_code, 0);
    EXPECT_TRUE(read("whole.ome.tif") == read("killed.ome.tif"));
    EXPECT_TRUE(read("whole.png") == read("killed.png"));
    EXPECT_TRUE(read("whole.apng") == read("killed.apng"));
    EXPECT_FALSE(fs::exists(folder() / "killed.ome.tif.planes"));
}

TEST_F(StackTest, StoppedBySignalItSaysHowToGoOnAndGoesOn) {
    RunLimits limits;
    limits.signal = SIGTERM;
    limits.signal_when = [&] { return planes_there("stack.ome.tif") >= 2; };
    const std::vector<std::string> arguments = {"render", "scene.toml", "-o", "stack.ome.tif", "--samples", "800"};
    const ProgramResult stopped = run(arguments, limits);
    EXPECT_EQ(stopped.exit_code, 75) << stopped.err;
    EXPECT_TRUE(found("stopped after [2-6] of 7 planes, which are kept in stack.ome.tif.planes; run the same command",
                      stopped.err));
    const ProgramResult other = run({"render", "scene.toml", "-o", "stack.ome.tif", "--samples", "3"});
    EXPECT_EQ(other.exit_code, 2);
    EXPECT_TRUE(found("stack.ome.tif.planes holds planes of other work .*--overwrite", other.err));
    const ProgramResult resumed = run(arguments);
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_TRUE(found("[2-6] of 7 planes are there already", resumed.err));
}

TEST_F(StackTest, AFullDiskLeavesTheFinishedPlanes) {
    RunLimits limits;
    limits.max_file_bytes = 6000;  // a plane fits, the stack does not
    const ProgramResult full = run({"render", "scene.toml", "-o", "stack.ome.tif"}, limits);
    EXPECT_EQ(full.exit_code, 5) << full.err;
    EXPECT_TRUE(found("could not be written: File too large", full.err));  // the cause, not where the library stood
    EXPECT_TRUE(found("finished planes are kept, run again to go on", full.err));
    EXPECT_EQ(planes_there("stack.ome.tif"), 7U);
    EXPECT_EQ(run({"render", "scene.toml", "-o", "stack.ome.tif"}).exit_code, 0);
}

TEST_F(StackTest, TheSpecimenRendersAndTheSameGridWrittenAgainKeepsTheFinishedStack) {
    const fs::path volume = fs::path(FLUOVOX_SOURCE_DIR) / "volumes" / "lightsheet-neuron";
    fs::copy_file(volume / "scene.toml", folder() / "cells.toml");
    fs::copy_file(volume / "lightsheet-neuron.vdb", folder() / "lightsheet-neuron.vdb");
    std::vector<std::string> render = {"render",  "cells.toml", "-o",        "d.ome.tif",
                                       "--truth", "labels",     "--samples", "2"};
    for (const char* change : {"camera.resolution=[24,24]", "camera.pixel_size=6um", "stack.start=-20um",
                               "stack.stop=20um", "stack.step=20um"})
        render.insert(render.end(), {"--set", change});
    const ProgramResult first = run(render);
    ASSERT_EQ(first.exit_code, 0) << first.err;
    EXPECT_TRUE(found("3 planes of 24 x 24 pixels, 2 channels", first.err));
    std::string grid = read("lightsheet-neuron.vdb");
    grid[25] = grid[25] == 'a' ? 'b' : 'a';  // in the identifier
    write("lightsheet-neuron.vdb", grid);
    EXPECT_TRUE(found("d.ome.tif is finished already", run(render).err));
    render.insert(render.end(), {"--set", "medium.0.grid.scale=2"});
    EXPECT_TRUE(found("3 planes", run(render).err));
    if (!has_readers()) GTEST_SKIP() << "python3 is not installed";
    python("d-labels.ome.tif");
    shell(
        "/usr/bin/python3 -c \"import numpy as np; l = np.load('d-labels.ome.tif.npy'); "
        "assert set(np.unique(l)) == {0, 1, 2}, np.unique(l)\"");
}

TEST_F(StackTest, WhatIsInTheWayAndNotAStackOfOursStays) {
    fs::create_directories(folder() / "data" / "sub");
    write("data/sub/thesis.txt", "precious");
    fs::create_directories(folder() / "t-labels.ome.tif");
    write("t-labels.ome.tif/keep.txt", "precious");
    write("file.ome.zarr", "precious");
    ASSERT_EQ(run({"render", "scene.toml", "-o", "s.ome.zarr", "--samples", "1"}).exit_code, 0);
    ASSERT_EQ(run({"render", "scene.toml", "-o", "s.ome.zarr", "--samples", "2"}).exit_code, 0)
        << "its own is replaced";
    write("s.ome.zarr/mine.txt", "precious");
    expect_rows({
        {"a folder with other things",
         {"render", "scene.toml", "-o", "data", "--format", "ome-zarr"},
         5,
         "data: is a folder with other things in it"},
        {"the folder itself",
         {"render", "scene.toml", "-o", ".", "--format", "ome-zarr"},
         5,
         "with other things in it"},
        {"a file", {"render", "scene.toml", "-o", "file.ome.zarr"}, 5, "is there already and no OME-Zarr folder"},
        {"something beside the levels",
         {"render", "scene.toml", "-o", "s.ome.zarr", "--samples", "3"},
         5,
         "\"mine.txt\" in it is not of the stack"},
        {"a folder where the labels go",
         {"render", "scene.toml", "-o", "t.ome.tif", "--truth", "labels"},
         5,
         "t-labels.ome.tif: is a folder"},
        {"counts without a scale",
         {"render", "scene.toml", "-o", "c.ome.tif", "--type", "uint16", "--value-per-count", "0"},
         2,
         "--value-per-count must be a number above zero"},
    });
    EXPECT_EQ(read("data/sub/thesis.txt"), "precious");
    EXPECT_EQ(read("t-labels.ome.tif/keep.txt"), "precious");
    EXPECT_EQ(read("file.ome.zarr"), "precious");
    EXPECT_EQ(read("s.ome.zarr/mine.txt"), "precious");
    EXPECT_FALSE(read("scene.toml").empty());
}

TEST_F(StackTest, AFinishedStackThatLostItsTruthIsMadeAgain) {
    const std::vector<std::string> command = {"render", "scene.toml", "-o", "s.ome.tif", "--truth", "labels"};
    ASSERT_EQ(run(command).exit_code, 0);
    fs::remove(folder() / "s-labels.ome.tif");
    ASSERT_EQ(run(command).exit_code, 0);
    EXPECT_TRUE(fs::exists(folder() / "s-labels.ome.tif"));
}

TEST_F(StackTest, AFinishedStackWhoseFilesNoLongerHoldIsRenderedAgain) {
    const auto flip_in_the_middle = [&](const std::string& name) {
        std::string bytes = read(name);
        bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
        write(name, bytes);
    };
    const auto cut_short = [&](const std::string& name) { write(name, read(name).substr(0, read(name).size() / 2)); };
    const auto replace = [&](const std::string& name) { write(name, "another file"); };
    struct Row {
        std::string output, damaged;
        std::function<void(const std::string&)> damage;
        std::vector<std::string> more;
    };
    for (const Row& row : {Row{"a.ome.tif", "a.ome.tif", flip_in_the_middle, {}},
                           Row{"b.ome.tif", "b.ome.tif", cut_short, {}}, Row{"c.ome.tif", "c.ome.tif", replace, {}},
                           Row{"d.ome.tif", "d-labels.ome.tif", flip_in_the_middle, {"--truth", "labels"}},
                           Row{"e.tif", "e.tif", flip_in_the_middle, {"--format", "imagej"}},
                           Row{"f.ome.zarr", "f.ome.zarr/0/1/3/0/0", flip_in_the_middle, {}},
                           Row{"g.ome.zarr", "g.ome.zarr/0/.zarray", cut_short, {}},
                           Row{"h.exr", "h-0003.exr", cut_short, {}}, Row{"i.ome.tif", "i.png", cut_short, {}}}) {
        SCOPED_TRACE(row.output);
        std::vector<std::string> command = {"render", "scene.toml", "-o", row.output, "--samples", "2"};
        command.insert(command.end(), row.more.begin(), row.more.end());
        ASSERT_EQ(run(command).exit_code, 0);
        EXPECT_TRUE(found("is finished already", run(command).err));
        const std::string good = read(row.damaged);
        row.damage(row.damaged);
        ASSERT_NE(read(row.damaged), good);
        const ProgramResult again = run(command);
        EXPECT_EQ(again.exit_code, 0) << again.err;
        EXPECT_TRUE(found("7 planes of 14 x 12 pixels", again.err));
        if (row.damaged != "i.png") {
            EXPECT_TRUE(found("is not as it was written .* is rendered again", again.err));
        }
        EXPECT_TRUE(read(row.damaged) == good);
    }
    write("f.ome.zarr/0/.DS_Store", "a file manager's");
    EXPECT_TRUE(found("is finished already", run({"render", "scene.toml", "-o", "f.ome.zarr", "--samples", "2"}).err));
}

TEST_F(StackTest, JsonOfAFinishedStackHoldsWhatWasMeasuredAndNullForWhatWasNot) {
    const std::vector<std::string> command = {"render", "scene.toml", "-o", "s.ome.tif", "--json"};
    const auto fresh = nlohmann::json::parse(run(command).out);
    const auto finished = nlohmann::json::parse(run(command).out);
    EXPECT_EQ(fresh.at("finished_before"), false);
    EXPECT_GT(fresh.at("seconds"), 0.0);
    EXPECT_EQ(finished.at("finished_before"), true);
    EXPECT_TRUE(finished.at("seconds").is_null());
    EXPECT_GT(finished.at("median_relative_error"), 0.0);
    for (const char* same : {"outputs", "nan_count", "median_relative_error", "bright_relative_error"})
        EXPECT_EQ(finished.at(same), fresh.at(same)) << same;
    ASSERT_EQ(finished.at("planes").size(), 7U);
    EXPECT_TRUE(finished.at("planes").at(3).at("seconds").is_null());
    EXPECT_EQ(finished.at("planes").at(3).at("median_relative_error"),
              fresh.at("planes").at(3).at("median_relative_error"));
}

}  // namespace
}  // namespace fluovox::testing
