#include "fluovox/core/atomic_file.h"

#include "fluovox/core/error.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public ::testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }

    static std::string content(const fs::path& file) {
        std::ifstream in(file);
        return {std::istreambuf_iterator<char>(in), {}};
    }

    // One folder a test: ctest runs them at the same time.
    const fs::path folder_ =
        fs::path(::testing::TempDir()) /
        (std::string("fluovox_atomic_file_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(AtomicFile, ReplacesWhatWasThere) {
    write_text_file(folder_ / "a.txt", "old");
    write_text_file(folder_ / "a.txt", "new");
    EXPECT_EQ(content(folder_ / "a.txt"), "new");
}

TEST_F(AtomicFile, AFailedWriterLeavesTheOldFileAndNothingElse) {
    write_text_file(folder_ / "a.txt", "old");
    const auto half_written = [](const fs::path& temporary) {
        std::ofstream(temporary) << "half";
        throw std::runtime_error("power cut");
    };
    EXPECT_THROW(write_atomically(folder_ / "a.txt", half_written), std::runtime_error);
    EXPECT_EQ(content(folder_ / "a.txt"), "old");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(AtomicFile, NamesAMissingFolder) {
    try {
        write_text_file(folder_ / "nowhere" / "a.txt", "x");
        FAIL() << "should have thrown";
    } catch (const OutputError& e) {
        EXPECT_NE(std::string(e.what()).find("does not exist"), std::string::npos);
    }
}

}  // namespace
}  // namespace fluovox
