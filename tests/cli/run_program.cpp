#include "cli/run_program.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>
#include <thread>

namespace fluovox::testing {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

std::string file_text(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

fs::path make_temporary_folder() {
    std::string name = (fs::temp_directory_path() / "fluovox-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder: " + name);
    return name;
}

// Between fork and exec: only what is safe there.
[[noreturn]] void become_program(char* const* argv, const char* folder, const char* out, const char* err,
                                 const RunLimits& limits) {
    const auto redirect = [](const char* file, int flags, int to) {
        const int opened = ::open(file, flags, 0600);  // NOLINT(*-vararg)
        if (opened < 0 || ::dup2(opened, to) < 0) ::_exit(126);
    };
    redirect("/dev/null", O_RDONLY, STDIN_FILENO);
    redirect(out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
    redirect(err, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
    if (::chdir(folder) != 0) ::_exit(126);
    if (limits.max_file_bytes) {
        std::signal(SIGXFSZ, SIG_IGN);  // so that write() fails, as it does on a full disk
        const auto most = static_cast<rlim_t>(*limits.max_file_bytes);
        const rlimit limit{most, most};
        if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) ::_exit(126);
    }
    ::execv(argv[0], argv);
    ::_exit(127);
}

}  // namespace

ProgramResult run_program(const std::vector<std::string>& arguments, const fs::path& folder, const RunLimits& limits) {
    ProgramResult result;
    std::vector<std::string> words = {FLUOVOX_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);
    result.command = "fluovox";
    for (const std::string& argument : arguments)
        result.command += ' ' + argument;

    const fs::path streams = make_temporary_folder();
    const std::string out = streams / "out";
    const std::string err = streams / "err";
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("fork failed");
    if (child == 0) become_program(argv.data(), folder.c_str(), out.c_str(), err.c_str(), limits);

    const auto give_up = Clock::now() + std::chrono::seconds(kSlowness * limits.seconds);
    int status = 0;
    bool signalled = false;
    while (::waitpid(child, &status, WNOHANG) == 0) {
        if (!result.timed_out && Clock::now() > give_up) {
            result.timed_out = true;
            ::kill(child, SIGKILL);
        }
        if (limits.signal_when && !signalled && limits.signal_when()) {
            signalled = true;
            ::kill(child, limits.signal);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.out = file_text(out);
    result.err = file_text(err);
    fs::remove_all(streams);
    return result;
}

::testing::AssertionResult found(const std::string& expression, const std::string& text) {
    if (std::regex_search(text, std::regex(expression))) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "no match of /" << expression << "/ in:\n" << text;
}

ProgramTest::ProgramTest() : folder_(make_temporary_folder()) {}

ProgramTest::~ProgramTest() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

fs::path ProgramTest::write(const std::string& name, const std::string& text) const {
    fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << text;
    return file;
}

std::string ProgramTest::read(const std::string& name) const {
    EXPECT_TRUE(fs::is_regular_file(folder_ / name)) << name << " is not there";
    return file_text(folder_ / name);
}

std::vector<std::string> ProgramTest::files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
        if (!entry.is_directory()) names.push_back(entry.path().lexically_relative(folder_).string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

void ProgramTest::expect_rows(const std::vector<CommandRow>& rows) const {
    for (const CommandRow& row : rows) {
        const ProgramResult result = run(row.arguments);
        SCOPED_TRACE(row.promise + "\n  " + result.command + "\n--- stderr\n" + result.err);
        EXPECT_FALSE(result.timed_out) << "hung";
        EXPECT_LT(result.exit_code, 128) << "crashed";
        EXPECT_EQ(result.exit_code, row.exit_code);
        EXPECT_TRUE(found(row.err, result.err));
        EXPECT_TRUE(found(row.out, result.out));
        for (const std::string& name : row.files_after)
            EXPECT_TRUE(fs::exists(folder_ / name)) << name << " is missing";
        for (const std::string& name : row.files_absent)
            EXPECT_FALSE(fs::exists(folder_ / name)) << name << " was left behind";
    }
}

}  // namespace fluovox::testing
