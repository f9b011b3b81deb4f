#include "fluovox/core/quantity.h"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>
#include <string>

namespace fluovox {
namespace {

std::string complaint(std::string_view text, Dimension dimension) {
    try {
        parse_quantity(text, dimension);
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
    return "no complaint";
}

TEST(Quantity, ReadsEveryUnitIntoTheDimensionsOwn) {
    EXPECT_DOUBLE_EQ(parse_quantity("0.25 um", Dimension::Length), 0.25);
    EXPECT_DOUBLE_EQ(parse_quantity("20nm", Dimension::Length), 0.02);
    EXPECT_DOUBLE_EQ(parse_quantity("-5 mm", Dimension::Length), -5000);
    EXPECT_DOUBLE_EQ(parse_quantity("0.488 um", Dimension::Wavelength), 488);
    EXPECT_DOUBLE_EQ(parse_quantity("1 mW", Dimension::Power), 1e-3);
    EXPECT_DOUBLE_EQ(parse_quantity("5 nM", Dimension::Concentration), 5e-3);
    EXPECT_DOUBLE_EQ(parse_quantity("1e-6 mol/L", Dimension::Concentration), 1);
    EXPECT_DOUBLE_EQ(parse_quantity("24.2 /cm", Dimension::PerLength), 24.2e-4);
    EXPECT_DOUBLE_EQ(parse_quantity("55900 /M/cm", Dimension::Extinction), 55900);
    EXPECT_DOUBLE_EQ(parse_quantity("180 deg", Dimension::Angle), std::numbers::pi);
}

TEST(Quantity, TheMicroSignAndTheGreekLetterStandForU) {
    for (const std::string mu : {"\u00b5", "\u03bc"}) {
        EXPECT_DOUBLE_EQ(parse_quantity("0.25 " + mu + "m", Dimension::Length), 0.25);
        EXPECT_DOUBLE_EQ(parse_quantity("5 " + mu + "W", Dimension::Power), 5e-6);
        EXPECT_DOUBLE_EQ(parse_quantity("5 " + mu + "M", Dimension::Concentration), 5);
        EXPECT_DOUBLE_EQ(parse_quantity("2 " + mu + "mol/L", Dimension::Concentration), 2);
        EXPECT_DOUBLE_EQ(parse_quantity("2 /" + mu + "m", Dimension::PerLength), 2);
        EXPECT_DOUBLE_EQ(parse_quantity("3 " + mu + "s", Dimension::Time), 3e-6);
    }
}

TEST(Quantity, ReciprocalUnitsAreReadAsPapersWriteThem) {
    for (const std::string unit : {"/mm", "1/mm", "mm^-1", "mm-1", "mm\u207b\u00b9"})
        EXPECT_DOUBLE_EQ(parse_quantity("20 " + unit, Dimension::PerLength), 0.02) << unit;
    EXPECT_DOUBLE_EQ(parse_quantity("20m-1", Dimension::PerLength), 20e-6);
    for (const std::string unit : {"/M/cm", "1/M/cm", "M^-1 cm^-1", "M-1 cm-1", "M\u207b\u00b9\u00b7cm\u207b\u00b9"})
        EXPECT_DOUBLE_EQ(parse_quantity("55900 " + unit, Dimension::Extinction), 55900) << unit;
    for (const std::string unit : {"W/m2/sr", "W m^-2 sr^-1", "W.m^-2.sr^-1"})
        EXPECT_DOUBLE_EQ(parse_quantity("3 " + unit, Dimension::Radiance), 3) << unit;
    EXPECT_EQ(complaint("20 mm-2", Dimension::PerLength).rfind("\"mm-2\" is not a unit of coefficient", 0), 0U);
    EXPECT_EQ(complaint("5-6 um", Dimension::Length).rfind("\"-6 um\" is not a unit of length", 0), 0U);
    EXPECT_EQ(complaint("5 1/um", Dimension::Length).rfind("\"5 1/um\" is a coefficient, not a length", 0), 0U);
    EXPECT_EQ(complaint("5 u.m", Dimension::Length).rfind("\"u.m\" is not a unit", 0), 0U);
}

TEST(Quantity, SpacesThatDoNotBreakAreSpaces) {
    for (const std::string space : {"\u00a0", "\u202f", "\u2009", " \u00a0\t"}) {
        EXPECT_DOUBLE_EQ(parse_quantity("5" + space + "um", Dimension::Length), 5);
        EXPECT_DOUBLE_EQ(parse_quantity(space + "20" + space + "/mm" + space, Dimension::PerLength), 0.02);
        EXPECT_EQ(complaint("6.5" + space, Dimension::Length), "6.5 needs a unit, for example \"6.5 um\"");
    }
    EXPECT_NE(complaint("5\u00a1um", Dimension::Length), "no complaint");
}

TEST(Quantity, SaysWhatIsWrongAndHowToMendIt) {
    EXPECT_EQ(complaint("6.5", Dimension::Length), "6.5 needs a unit, for example \"6.5 um\"");
    EXPECT_EQ(complaint("1 mW", Dimension::Length).substr(0, 33), "\"1 mW\" is a power, not a length (");
    EXPECT_EQ(complaint("thin", Dimension::Length), "\"thin\" is not a length, for example \"5 um\"");
    EXPECT_NE(complaint("nan um", Dimension::Length), "no complaint");
    EXPECT_NE(complaint("", Dimension::Power), "no complaint");
    EXPECT_NE(complaint("5 parsec", Dimension::Length), "no complaint");
    EXPECT_EQ(complaint("1e308 m", Dimension::Length), "\"1e308 m\" is too large");
}

TEST(Quantity, FormatReadsBackExactly) {
    for (const double value : {0.1, 1.0 / 3, 1e-12, 123456.789}) {
        EXPECT_EQ(parse_quantity(format_quantity(value, Dimension::Length), Dimension::Length), value);
    }
}

}  // namespace
}  // namespace fluovox
