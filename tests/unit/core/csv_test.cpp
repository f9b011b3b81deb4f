#include "fluovox/core/csv.h"

#include "fluovox/core/error.h"

#include <gtest/gtest.h>

namespace fluovox {
namespace {

std::string complaint(std::string_view text, std::optional<double> blank = {}) {
    try {
        parse_csv(text, "t.csv", blank);
    } catch (const SceneError& e) {
        return e.what();
    }
    return "no complaint";
}

TEST(Csv, ReadsNamedColumnsCommentsAndBlanks) {
    const CsvTable table =
        parse_csv("# a comment\nwavelength_nm, Excitation ,emission\n\n300,0.5,\r\n 301 ,1e-1,2\n", "t.csv", 0.0);
    ASSERT_EQ(table.rows(), 2U);
    EXPECT_EQ(table.column("excitation"), (std::vector<double>{0.5, 0.1}));
    EXPECT_EQ(table.column("emission"), (std::vector<double>{0, 2}));
    EXPECT_EQ(table.lines, (std::vector<int>{4, 5}));
}

TEST(Csv, ReadsATableWithoutHeaderAndOtherSeparators) {
    const CsvTable table = parse_csv("400\t1\n500\t2", "t.csv");
    EXPECT_TRUE(table.header.empty());
    EXPECT_EQ(table.columns, (std::vector<std::vector<double>>{{400, 500}, {1, 2}}));
    EXPECT_EQ(parse_csv("\xEF\xBB\xBF\"nm\";v\n1;2\n", "t.csv").header, (std::vector<std::string>{"nm", "v"}));
}

TEST(Csv, ErrorsNameTheLineAndTheCell) {
    EXPECT_EQ(complaint(""), "t.csv:1:1: error: the table is empty");
    EXPECT_EQ(complaint("# only a comment\n"), "t.csv:1:1: error: the table is empty");
    EXPECT_EQ(complaint("a,b\n"), "t.csv:1:1: error: the table has no rows of numbers");
    EXPECT_EQ(complaint("a,b\n1,2\n3,x\n"), "t.csv:3:3: error: \"x\" is not a number");
    EXPECT_EQ(complaint("a,b\n1,2\n3\n"), "t.csv:3:1: error: 1 cells, but the table has 2 columns");
    EXPECT_EQ(complaint("a,b\n1,\n"), "t.csv:2:3: error: an empty cell where a number is needed");
    EXPECT_EQ(complaint("a,b\n1,\n", 0.0), "no complaint");
    EXPECT_EQ(complaint("a,b\n1,inf\n"), "t.csv:2:3: error: \"inf\" is not finite");
    EXPECT_EQ(complaint("a,b\n1,1,5\n"), "t.csv:2:1: error: 3 cells, but the table has 2 columns");
    EXPECT_EQ(complaint(std::string_view("a\0b", 3)), "t.csv:1:1: error: not a text file");
}

TEST(Csv, AMissingColumnListsThoseThereAre) {
    const CsvTable table = parse_csv("# c\nnm,power\n1,2\n", "t.csv");
    try {
        table.column("emission");
        FAIL() << "no complaint";
    } catch (const SceneError& e) {
        EXPECT_STREQ(e.what(), "t.csv:2:1: error: needs a column \"emission\" (its columns: nm, power)");
    }
}

TEST(Csv, AMissingFileIsBadInput) {
    EXPECT_THROW(load_csv(testing::TempDir() + "no-such.csv"), InputError);
}

}  // namespace
}  // namespace fluovox
