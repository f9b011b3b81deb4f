#include "fluovox/core/file_lock.h"

#include "fluovox/core/error.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <string>
#include <utility>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

class FileLockTest : public ::testing::Test {
public:
    FileLockTest() : folder_(fs::path(::testing::TempDir()) / ("fluovox_lock_" + std::to_string(::getpid()))) {
        fs::create_directories(folder_);
    }
    ~FileLockTest() override {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }
    FileLockTest(const FileLockTest&) = delete;
    FileLockTest& operator=(const FileLockTest&) = delete;

protected:
    fs::path file() const { return folder_ / "lock"; }

private:
    fs::path folder_;
};

TEST_F(FileLockTest, OneHoldsItUntilItGoes) {
    std::optional<FileLock> first = FileLock::take(file());
    ASSERT_TRUE(first);
    EXPECT_FALSE(FileLock::take(file()));
    FileLock moved = std::move(*first);
    first.reset();
    EXPECT_FALSE(FileLock::take(file()));
    { const FileLock last = std::move(moved); }
    EXPECT_TRUE(FileLock::take(file()));
    EXPECT_TRUE(FileLock::take(file())) << "the file that stays is no lock";
}

TEST_F(FileLockTest, AKilledProcessLeavesNone) {
    std::array<int, 2> pipe{};
    ASSERT_EQ(::pipe(pipe.data()), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const std::optional<FileLock> lock = FileLock::take(file());
        const char held = lock ? 'y' : 'n';
        if (::write(pipe[1], &held, 1) != 1) ::_exit(1);
        for (;;)
            ::pause();
    }
    char held = 0;
    ASSERT_EQ(::read(pipe[0], &held, 1), 1);
    EXPECT_EQ(held, 'y');
    EXPECT_FALSE(FileLock::take(file()));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    EXPECT_TRUE(FileLock::take(file()));
    ::close(pipe[0]);
    ::close(pipe[1]);
}

TEST_F(FileLockTest, AFileThatWasTakenAwayIsNoLockAnyMore) {
    const std::optional<FileLock> first = FileLock::take(file());
    fs::remove(file());
    EXPECT_TRUE(FileLock::take(file()));
    EXPECT_THROW(FileLock::take(file() / "below"), OutputError);
}

}  // namespace
}  // namespace fluovox
