#include "cli/run_program.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

TEST_F(ProgramTest, AnswersHelpVersionAndUnknownCommands) {
    expect_rows({
        {"help lists the commands and exit codes", {"--help"}, 0, "", "Commands:[\\s\\S]*Exit codes:"},
        {"no command at all shows the help, but is a mistake", {}, 2, "", "Commands:"},
        {"the version", {"--version"}, 0, "", "^fluovox [0-9]+\\.[0-9]+\\.[0-9]+\n$"},
        {"a slip in a command's name",
         {"rendre"},
         2,
         "no command \"rendre\"; did you mean \"render\"\\? \\(fluovox --help lists them",
         "^$"},
        {"a command that does not exist", {"convert"}, 2, "no command \"convert\" \\(fluovox --help", "^$"},
        {"a slip in an option's name",
         {"render", "a.toml", "--truht", "all"},
         2,
         "'--truht'; did you mean \"--truth\"\\?"},
        {"too many arguments", {"dyes", "EGFP", "DAPI"}, 2, "more arguments than this command takes"},
    });
    EXPECT_TRUE(files().empty());
}

TEST_F(ProgramTest, NumbersThatAreTooLargeAreToldWithTheirRange) {
    write("seed.toml", "[render]\nseed = 18446744073709551615\n");
    const std::string most = "9223372036854775807";
    expect_rows({
        {"on the command line",
         {"render", "seed.toml", "-o", "a.exr", "--seed", "18446744073709551615"},
         2,
         "--seed must be a whole number from 0 to " + most},
        {"in a scene", {"check", "seed.toml"}, 3, "seed.toml:2:.*a seed, go up to " + most},
        {"threads", {"render", "seed.toml", "-o", "a.exr", "--threads", "100000"}, 2, "--threads must be 1024 or less"},
    });
}

/// Exit code of the program in a shell, with what follows its name.
int shell_exit_code(const std::string& line) {
    return WEXITSTATUS(std::system((FLUOVOX_PROGRAM " " + line).c_str()));
}

TEST_F(ProgramTest, ResultsThatCannotBePrintedAreAnError) {
    EXPECT_EQ(shell_exit_code("dyes > /dev/null"), 0);
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
    const std::string said = (folder() / "said").string();
    EXPECT_EQ(shell_exit_code("dyes > /dev/full 2> " + said), 5);
    EXPECT_TRUE(found("standard output", read("said")));
    EXPECT_EQ(shell_exit_code("--version > /dev/full 2> " + said), 5);
    EXPECT_EQ(shell_exit_code("rendre > /dev/full 2> " + said), 2);  // the first mistake counts
}

// Otherwise the first files that are opened take the numbers of the streams.
TEST_F(ProgramTest, RunsWithoutStandardStreams) {
    write("cube.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const std::string make = "voxelize " + (folder() / "cube.off").string() + " --dye EGFP=5uM --voxel-size 0.1um -o ";
    EXPECT_EQ(shell_exit_code(make + (folder() / "open.vdb").string() + " > /dev/null 2>&1"), 0);
    EXPECT_EQ(shell_exit_code(make + (folder() / "closed.vdb").string() + " <&- >&- 2>&-"), 0);
    EXPECT_EQ(run({"info", "closed.vdb", "-q"}).exit_code, 0);
    EXPECT_EQ(std::filesystem::file_size(folder() / "closed.vdb"), std::filesystem::file_size(folder() / "open.vdb"));
    EXPECT_EQ(files(), (std::vector<std::string>{"closed.vdb", "cube.off", "open.vdb"}));
}

// The harness must see what it claims to see.
TEST_F(ProgramTest, HarnessTellsExitCodeStreamsAndFilesApart) {
    const ProgramResult bad = run({"rendre"});
    EXPECT_EQ(bad.exit_code, 2);
    EXPECT_TRUE(bad.out.empty());
    EXPECT_FALSE(bad.err.empty());
    EXPECT_FALSE(found("no such words", bad.err));
    write("sub/file.txt", "text\n");
    EXPECT_EQ(files(), std::vector<std::string>{"sub/file.txt"});
    EXPECT_EQ(read("sub/file.txt"), "text\n");
}

}  // namespace
}  // namespace fluovox::testing
