#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace fluovox::testing {

/// What one run of the program came to.
struct ProgramResult {
    std::string command;  ///< as one would type it, for messages
    int exit_code = 0;    ///< 128 + signal where one ended it
    bool timed_out = false;
    std::string out;  ///< stdout
    std::string err;  ///< stderr
};

/// How many times longer the program may take than usual.
#ifdef __SANITIZE_ADDRESS__
constexpr int kSlowness = 10;
#else
constexpr int kSlowness = 1;
#endif

struct RunLimits {
    int seconds = 60;                         ///< x kSlowness; a run that takes longer counts as hung and is ended
    std::optional<long long> max_file_bytes;  ///< writing beyond fails, as on a full disk
    std::function<bool()> signal_when = {};   ///< asked again and again: once true, the program gets `signal`
    int signal = 9;
};

/// Runs the program of this build in `folder` and waits for it.
ProgramResult run_program(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                          const RunLimits& limits = {});

/// One row of a table "this command, this exit code, this said".
struct CommandRow {
    std::string promise;
    std::vector<std::string> arguments;
    int exit_code = 0;
    std::string err = {};                       ///< regular expression (ECMAScript) found in stderr; empty: any
    std::string out = {};                       ///< the same for stdout
    std::vector<std::string> files_after = {};  ///< that must be there afterwards
    std::vector<std::string> files_absent = {};
};

/// Gives each test an empty folder, in which the program runs, so that messages hold relative names.
class ProgramTest : public ::testing::Test {
public:
    ProgramTest();
    ~ProgramTest() override;
    ProgramTest(const ProgramTest&) = delete;
    ProgramTest& operator=(const ProgramTest&) = delete;

protected:
    const std::filesystem::path& folder() const { return folder_; }
    /// Writes a file into the folder (with its parents) and gives its full path.
    std::filesystem::path write(const std::string& name, const std::string& text) const;
    /// The whole text of a file in the folder; fails the test when there is none.
    std::string read(const std::string& name) const;
    /// Names of everything in the folder (with sub-folders), sorted; hidden temporaries show up here as well.
    std::vector<std::string> files() const;

    ProgramResult run(const std::vector<std::string>& arguments, const RunLimits& limits = {}) const {
        return run_program(arguments, folder_, limits);
    }
    /// Runs each row and checks all that it says; also that nothing crashed, hung or ended as an internal error.
    void expect_rows(const std::vector<CommandRow>& rows) const;

private:
    std::filesystem::path folder_;
};

/// Whether `expression` is found in `text`.
::testing::AssertionResult found(const std::string& expression, const std::string& text);

}  // namespace fluovox::testing
