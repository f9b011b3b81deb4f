#include "cli/run_program.h"

#include <string>
#include <vector>

namespace fluovox::testing {
namespace {

TEST_F(ProgramTest, AnswersHelpVersionAndUnknownCommands) {
    expect_rows({
        {"help lists the commands and exit codes", {"--help"}, 0, "", "Commands:[\\s\\S]*Exit codes:"},
        {"no command at all shows the help, but is a mistake", {}, 2, "", "Commands:"},
        {"the version", {"--version"}, 0, "", "^fluovox [0-9]+\\.[0-9]+\\.[0-9]+\n$"},
        {"a command that does not exist", {"rendre"}, 2, "no command \"rendre\"", "^$"},
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
