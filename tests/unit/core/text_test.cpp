#include "fluovox/core/text.h"

#include "fluovox/core/error.h"

#include <gtest/gtest.h>

namespace fluovox {
namespace {

using Names = std::vector<std::string>;

TEST(Text, EditDistanceCountsEveryKindOfSlipOnce) {
    EXPECT_EQ(edit_distance("waist", "waist"), 0U);
    EXPECT_EQ(edit_distance("wiast", "waist"), 1U);  // swapped
    EXPECT_EQ(edit_distance("wist", "waist"), 1U);   // left out
    EXPECT_EQ(edit_distance("waiist", "waist"), 1U);
    EXPECT_EQ(edit_distance("wXist", "waist"), 1U);
    EXPECT_EQ(edit_distance("EGFP", "egfp"), 0U);
    EXPECT_EQ(edit_distance("", "abc"), 3U);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Text, KeysOfManyDotsAreFound) {
    std::string dots;
    for (int i = 0; i < 300; ++i)
        dots += "a.";
    EXPECT_EQ(line_of_deep_key("x = 1\n" + dots + "b = 2\n"), 2);
    EXPECT_EQ(line_of_deep_key("[" + dots + "b]"), 1);
    std::string many = "x = [";
    for (int i = 0; i < 300; ++i)
        many += "0.5, ";
    EXPECT_EQ(line_of_deep_key("title = \"1.5 um ...\"\n" + many + "]"), 0);
}

TEST(Text, ClosestNamesAreBestFirstAndOnlyPlausibleOnes) {
    const Names keys = {"position", "direction", "power", "width", "waist", "wavelength"};
    EXPECT_EQ(closest_names("wiast", keys), (Names{"waist"}));
    EXPECT_EQ(closest_names("wave", keys).front(), "wavelength");
    EXPECT_EQ(closest_names("zzzzzz", keys), Names{});
    EXPECT_EQ(closest_names("a", {"b"}), Names{});
    EXPECT_EQ(closest_names("alexa 480", {"Alexa 488", "Alexa 546", "Cy5"}, 1), (Names{"Alexa 488"}));
}

TEST(Text, DidYouMeanIsReadyToAppend) {
    EXPECT_EQ(did_you_mean("powr", {"power", "position"}), "; did you mean \"power\"?");
    EXPECT_EQ(did_you_mean("m1", {"m2", "m3"}), "; did you mean \"m2\" or \"m3\"?");
    EXPECT_EQ(did_you_mean("qqqqqqq", {"power"}), "");
}

TEST(Text, WhatATerminalShowsHasNoBytesThatSteerIt) {
    EXPECT_EQ(printable("0.5 \u00b5m, \u65e5\u672c\n\tnext"), "0.5 \u00b5m, \u65e5\u672c\n\tnext");
    EXPECT_EQ(printable("\x1b[2J\r"), "\\x1b[2J\\x0d");
    EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(printable("\xff\xc3"), "\\xff\\xc3");  // no UTF-8, cut UTF-8
    EXPECT_EQ(printable("\xc2\x9b"
                        "2J"),
              "\\xc2\\x9b2J");  // a control sequence in one character
}

TEST(Text, LoadingNamesTheFileThatCannotBeRead) {
    EXPECT_THROW(load_text(testing::TempDir()), InputError);
    EXPECT_THROW(load_text(testing::TempDir() + "no-such-file.toml"), InputError);
}

}  // namespace
}  // namespace fluovox
