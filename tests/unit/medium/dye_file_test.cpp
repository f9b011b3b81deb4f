#include "fluovox/core/error.h"
#include "fluovox/medium/dye_library.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGood =
    "name = \"My dye\"\n"
    "quantum_yield = 0.5\n"
    "extinction = \"20000 /M/cm\"\n"
    "spectra = \"my.csv\"\n";
constexpr const char* kCurves = "wavelength_nm,excitation,emission\n400,0,\n450,8,0\n500,,2\n550,,4\n600,,0\n";

/// A folder of its own for each test, with files to write into it.
class DyeFile : public ::testing::Test {
public:
    DyeFile() {
        std::string name = (fs::temp_directory_path() / "fluovox-dye-XXXXXX").string();
        if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
        folder_ = name;
    }
    ~DyeFile() override { fs::remove_all(folder_); }
    DyeFile(const DyeFile&) = delete;
    DyeFile& operator=(const DyeFile&) = delete;

protected:
    void write(const std::string& name, std::string_view text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }
    /// The complaint about a dye file and its curves, without the folder; empty when there is none.
    std::string complaint(std::string_view toml, std::string_view curves = kCurves) const {
        write("d.toml", toml);
        write("my.csv", curves);
        try {
            load_dye(folder_ / "d.toml");
        } catch (const Error& e) {
            EXPECT_TRUE(e.code() == ExitCode::Scene || e.code() == ExitCode::Input);
            std::string message = e.what();
            for (std::size_t at = 0; (at = message.find(folder_.string() + '/')) != std::string::npos;)
                message.erase(at, folder_.string().size() + 1);
            return message;
        }
        return {};
    }

    fs::path folder_;
};

TEST_F(DyeFile, HoldsWhatALibraryDyeHolds) {
    write("d.toml", std::string(kGood) + "kind = \"test\"\nsource = \"us\"\nlicence = \"CC0\"\nnote = \"made up\"\n");
    write("my.csv", kCurves);
    const Dye dye = resolve_dye("d.toml", folder_, {}).dye;
    EXPECT_EQ(dye.id, "d");
    EXPECT_EQ(dye.name, "My dye");
    EXPECT_EQ(dye.kind + dye.source + dye.licence + dye.note, "testusCC0made up");
    EXPECT_EQ(dye.quantum_yield, 0.5);
    EXPECT_DOUBLE_EQ(dye.molar_absorption_per_M_cm(450), 20000);  // whatever the scale of the column
    EXPECT_DOUBLE_EQ(dye.molar_absorption_per_M_cm(425), 10000);
    EXPECT_EQ(dye.molar_absorption_per_M_cm(500), 0);
    EXPECT_NEAR(dye.emission_per_nm.integral(), 1, 1e-12);
    EXPECT_NEAR(dye.emission_per_nm(550) / dye.emission_per_nm(500), 2, 1e-12);
    EXPECT_EQ(dye.emission_per_nm(450), 0);
}

TEST_F(DyeFile, EnergyBecomesPhotonsByTheWavelength) {
    write("d.toml", std::string(kGood) + "emission_is = \"energy\"\n");
    write("my.csv", kCurves);
    const Dye dye = load_dye(folder_ / "d.toml");
    EXPECT_NEAR(dye.emission_per_nm(550) / dye.emission_per_nm(500), 2 * 550.0 / 500.0, 1e-12);
    EXPECT_NEAR(dye.emission_per_nm.integral(), 1, 1e-12);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    if (at == std::string::npos) throw std::logic_error(from);
    return text.replace(at, from.size(), to);
}

TEST_F(DyeFile, MistakesInTheTomlAreAnsweredAtTheirPlace) {
    const auto with = [&](const char* from, const char* to) { return complaint(replaced(kGood, from, to)); };
    EXPECT_EQ(complaint(kGood), "");
    EXPECT_EQ(with("0.5", "1.2"), "d.toml:2:17: error: quantum_yield is 1.2, but must be from 0 to 1");
    EXPECT_EQ(with("0.5", "-0.1"), "d.toml:2:17: error: quantum_yield is -0.1, but must be from 0 to 1");
    EXPECT_EQ(with("0.5", "nan"), "d.toml:2:17: error: quantum_yield is nan, but must be from 0 to 1");
    EXPECT_EQ(with("0.5", "\"0.5\""), "d.toml:2:17: error: quantum_yield must be a number from 0 to 1");
    EXPECT_EQ(with("\"20000 /M/cm\"", "20000"),
              "d.toml:3:14: error: extinction = 20000 needs a unit, for example \"20000 /M/cm\"");
    EXPECT_EQ(with("20000 /M/cm", "0 /M/cm"), "d.toml:3:14: error: extinction is 0 /M/cm, but must be above 0");
    EXPECT_EQ(
        with("20000 /M/cm", "20 /cm"),
        "d.toml:3:14: error: extinction: \"20 /cm\" is a coefficient, not an extinction (its units: /M/cm M^-1 cm^-1)");
    EXPECT_EQ(with("quantum_yield", "quantum_yeild"),
              "d.toml:2:1: error: unknown key \"quantum_yeild\"; did you mean \"quantum_yield\"?");
    EXPECT_EQ(with("quantum_yield = 0.5\n", ""),
              "d.toml:1:1: error: quantum_yield is missing; a number from 0 to 1 is needed");
    EXPECT_EQ(with("\"My dye\"", "7"), "d.toml:1:8: error: name must be a text in quotes");
    EXPECT_EQ(complaint(std::string(kGood) + "emission_is = \"watts\""),
              "d.toml:5:15: error: emission_is is \"watts\", but must be \"photons\" or \"energy\"");
    EXPECT_EQ(complaint(""), "d.toml:1:1: error: the dye file is empty");
}

TEST_F(DyeFile, MistakesInTheCurvesAreAnsweredWithTheirLine) {
    const auto curves = [&](std::string_view text) { return complaint(kGood, text); };
    EXPECT_EQ(curves(""), "my.csv:1:1: error: the table is empty");
    EXPECT_EQ(curves("wavelength_nm,excitation\n400,1\n500,2\n"),
              "my.csv:1:1: error: needs a column \"emission\" (its columns: wavelength_nm, excitation)");
    EXPECT_EQ(curves("wavelength_nm,excitation,emission\n400,1,1\n"),
              "my.csv:2:1: error: a dye needs at least two wavelengths");
    EXPECT_EQ(curves("wavelength_nm,excitation,emission\n400,1,1\n400,1,1\n"),
              "my.csv:3:1: error: wavelength_nm must increase, but 400 follows 400");
    EXPECT_EQ(curves("wavelength_nm,excitation,emission\n0.4,1,1\n0.5,1,1\n"),
              "my.csv:2:1: error: wavelength_nm is 0.4, but must be from 100 to 10000");
    EXPECT_EQ(curves("wavelength_nm,excitation,emission\n400,1,1\n500,1,-0.5\n"),
              "my.csv:3:1: error: emission is -0.5, but must not be negative");
    EXPECT_EQ(curves("wavelength_nm,excitation,emission\n400,0,1\n500,,1\n"),
              "my.csv:2:1: error: excitation is zero at every wavelength");
    EXPECT_EQ(curves("wavelength_nm,excitation,emission\n400,x,1\n"), "my.csv:2:5: error: \"x\" is not a number");
}

TEST_F(DyeFile, MissingFilesAreNamed) {
    EXPECT_NE(complaint(replaced(kGood, "my.csv", "none.csv")).find("d.toml:4:11: spectra: none.csv: cannot be read"),
              std::string::npos);
    EXPECT_THROW(load_dye(folder_ / "none.toml"), InputError);
    EXPECT_THROW(load_dye(folder_), InputError);
}

TEST_F(DyeFile, GarbageAndTruncationNeverCrash) {
    const std::string good = std::string(kGood) + "note = \"caf\xC3\xA9\"\n";
    for (std::size_t length = 0; length + 1 < good.size(); ++length) {
        const std::string message = complaint(good.substr(0, length));
        if (length < std::string(kGood).size() - 1) {
            EXPECT_EQ(message.rfind("d.toml:", 0), 0U) << length << ": " << message;
        }
    }
    std::string garbage;
    unsigned state = 12345;
    for (int i = 0; i < 4000; ++i) {
        state = state * 1664525U + 1013904223U;
        garbage += static_cast<char>(state >> 24U);
    }
    EXPECT_NE(complaint(garbage), "");
    EXPECT_NE(complaint(kGood, garbage), "");
    EXPECT_NE(complaint(std::string(5000, '[')), "");
    EXPECT_NE(complaint(kGood, std::string(100000, ',')), "");
    EXPECT_EQ(complaint(kGood, "wavelength_nm,excitation,emission\n400,1,1\n500,1e300,1\n"),
              "my.csv:3:1: error: excitation is 1e+300, above any scale");
    EXPECT_EQ(complaint(kGood, "wavelength_nm,excitation,emission\n400,1e-310,1\n500,1e-310,1\n"),
              "my.csv:2:1: error: excitation is zero at every wavelength");
}

}  // namespace
}  // namespace fluovox
