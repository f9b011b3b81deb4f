#include "cli/run_program.h"

namespace fluovox::testing {
namespace {

constexpr const char* kDye =
    "name = \"My dye\"\nquantum_yield = 0.5\nextinction = \"20000 /M/cm\"\nspectra = \"my.csv\"\n";
constexpr const char* kCurves = "wavelength_nm,excitation,emission\n400,0,\n450,8,0\n500,,2\n550,,4\n600,,0\n";

TEST_F(ProgramTest, DyesListsShowsAndPlots) {
    write("my.toml", kDye);
    write("my.csv", kCurves);
    expect_rows({
        {"the list", {"dyes"}, 0, "^$", "EGFP +egfp +489 +511 +55900 +0.60 +fluorescent protein"},
        {"the list for machines", {"dyes", "--json"}, 0, "^$", "\"dyes\": \\[[\\s\\S]*\"quantum_yield\": 0.6,"},
        {"one dye", {"dyes", "EGFP"}, 0, "^$", "489 nm[\\s\\S]*511 nm[\\s\\S]*55900 /M/cm[\\s\\S]*0.60[\\s\\S]*FPbase"},
        {"without case, spaces, dashes", {"dyes", "alexa-488"}, 0, "^$", "^Alexa Fluor 488 \\(alexa488\\)"},
        {"GFP is EGFP, and says so", {"dyes", "GFP"}, 0, "^$", "EGFP.*489/508 nm"},
        {"RFP is DsRed, and says so", {"dyes", "RFP"}, 0, "^$", "DsRed.*583 nm"},
        {"one dye for machines", {"dyes", "Cy5", "--json"}, 0, "^$", "\"photons_per_nm\": \\["},
        {"an own dye file", {"dyes", "my.toml"}, 0, "^$", "^My dye \\(my\\)[\\s\\S]*20000 /M/cm at 450 nm"},
        {"a plot", {"dyes", "EGFP", "-o", "egfp.svg"}, 0, "^$", "Wrote egfp.svg", {"egfp.svg"}},
        {"a plot as PNG", {"dyes", "my.toml", "-o", "my.png"}, 0, "^$", "Wrote my.png", {"my.png"}},
        {"tissue", {"dyes", "--tissues"}, 0, "^$", "brain +34.7"},
        {"tissue for machines", {"dyes", "--tissues", "--json"}, 0, "^$", "\"reduced_scattering_per_cm\": 24.2"},
        {"the terms", {"dyes", "--licences"}, 0, "^$", "CC BY-SA 4.0[\\s\\S]*CC0"},
        {"the help has examples first", {"dyes", "--help"}, 0, "^$", "^Examples:\n +fluovox dyes"},
    });
    EXPECT_EQ(read("egfp.svg").substr(0, 5), "<?xml");
    EXPECT_EQ(read("my.png").substr(1, 3), "PNG");
}

TEST_F(ProgramTest, DyesAnswersMistakesAtTheirPlace) {
    write("yield.toml", "name = \"x\"\nquantum_yield = 1.2\n");
    write("key.toml", std::string(kDye) + "licens = \"CC0\"\n");
    write("my.csv", "wavelength_nm,excitation,emission\n400,0,1\n450,8,oops\n");
    write("csv.toml", kDye);
    write("nocsv.toml", "name = \"x\"\nquantum_yield = 1\nextinction = \"2 /M/cm\"\nspectra = \"none.csv\"\n");
    write("garbage.toml", "\x01\xff\xfe garbage \x80");
    write("empty.toml", "");
    write("old.svg", "an old plot");
    expect_rows({
        {"unknown dye", {"dyes", "EGPF"}, 3, "unknown dye \"EGPF\"; did you mean \"EGFP\".*\"fluovox dyes\"", "^$"},
        {"a dye under other terms", {"dyes", "ATTO 488"}, 3, "dyes-optional/atto488.toml", "^$"},
        {"missing file", {"dyes", "none.toml"}, 4, "none.toml: cannot be read: No such file", "^$"},
        {"yield over 1", {"dyes", "yield.toml"}, 3, "^yield.toml:2:17: error: .*from 0 to 1", "^$"},
        {"misspelt key", {"dyes", "key.toml"}, 3, "^key.toml:5:1: error: .*did you mean \"licence\"", "^$"},
        {"bad cell", {"dyes", "csv.toml"}, 3, "^my.csv:3:7: error: \"oops\" is not a number", "^$"},
        {"missing table", {"dyes", "nocsv.toml"}, 4, "nocsv.toml:4:11: spectra: none.csv: cannot be read", "^$"},
        {"garbage", {"dyes", "garbage.toml"}, 3, "^garbage.toml:1:", "^$"},
        {"empty", {"dyes", "empty.toml"}, 3, "^empty.toml:1:1: error: the dye file is empty", "^$"},
        {"plot of nothing", {"dyes", "-o", "x.svg"}, 2, "needs the NAME[\\s\\S]*Usage: fluovox dyes", "^$"},
        {"other ending", {"dyes", "EGFP", "-o", "x.pdf"}, 2, "must end in .svg or .png", "^$", {}, {"x.pdf"}},
        {"two dyes", {"dyes", "EGFP", "Cy5"}, 2, "Usage: fluovox dyes", "^$"},
        {"two questions", {"dyes", "EGFP", "--tissues"}, 2, "exclude each other", "^$"},
        {"missing folder", {"dyes", "EGFP", "-o", "no/x.svg"}, 5, "no/x.svg", "^$"},
    });
    RunLimits full;
    full.max_file_bytes = 1000;
    const ProgramResult result = run({"dyes", "EGFP", "-o", "old.svg"}, full);
    EXPECT_EQ(result.exit_code, 5) << result.err;
    EXPECT_EQ(read("old.svg"), "an old plot");
    EXPECT_EQ(files().size(), 8U) << "something half-written is left behind";
}

}  // namespace
}  // namespace fluovox::testing
