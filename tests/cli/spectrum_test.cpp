#include "fluovox/core/csv.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/response.h"
#include "fluovox/medium/dye_library.h"

#include "cli/run_program.h"
#include "test_images.h"

#include <nlohmann/json.hpp>

#include <numeric>

namespace fluovox::testing {
namespace {

class SpectrumCommand : public ProgramTest {
protected:
    /// 8 x 8 pixels of light with EGFP's own spectrum, brighter in the lower half, with 10 % noise per sample.
    void image(const std::string& name, const FilmSpec& spec, const std::vector<std::string>& dyes = {"EGFP"}) const {
        Film film(8, 8, film_layers(dyes, dyes.size() > 1), static_cast<int>(spec.channels.size()));
        const auto emission = emission_on_film(find_dye("EGFP")->dye.emission_per_nm, spec);
        fill(film, 64, 1, [&](int pixel, int channel, std::mt19937_64& random) {
            const double mean = emission[static_cast<std::size_t>(channel)] * (pixel < 32 ? 1 : 3);
            return mean * std::normal_distribution<double>(1, 0.1)(random);
        });
        Provenance from;
        from.dyes = dyes;
        save_exr(folder() / name, film, spec, from);
    }
};

TEST_F(SpectrumCommand, WritesTheMeanWithItsErrorAsCsv) {
    image("a.exr", spectrometer(480, 620, 28));
    const ProgramResult result = run({"spectrum", "a.exr"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const CsvTable table = parse_csv(result.out, "stdout");
    const auto& nm = table.column("wavelength_nm");
    ASSERT_EQ(nm.size(), 28U);
    EXPECT_EQ(nm.front(), 482.5);
    const auto& mean = table.column("mean_W_per_m2_sr_nm");
    const auto& error = table.column("standard_error");
    const auto& emission = table.column("EGFP emission_per_nm");
    const auto& shape = table.column("normalised_per_nm");
    double area = 0;
    for (std::size_t i = 0; i < nm.size(); ++i) {
        area += emission[i] * 5;
        EXPECT_NEAR(error[i] / mean[i], 0.1 * std::sqrt(10 / 16.0 * 4) / std::sqrt(64.0 * 64 * 2), 4e-4);
        EXPECT_NEAR(shape[i] / emission[i], 1, 0.02);
    }
    EXPECT_NEAR(area, 1, 1e-6);
    const auto& total = table.column("total_W_per_m2_sr");
    const auto& total_error = table.column("total_standard_error");
    EXPECT_NEAR(total[3] / (5 * std::accumulate(mean.begin(), mean.end(), 0.0)), 1, 1e-6);
    // Here the bins are independent, so that the sum of squares holds.
    EXPECT_NEAR(total_error[27] / (5 * std::sqrt(std::inner_product(error.begin(), error.end(), error.begin(), 0.0))),
                1, 0.05);
    EXPECT_TRUE(found("total from 480 to 620 nm: [0-9.e-]+ \\+- [0-9.e-]+ W/m2/sr\n", result.err));
    EXPECT_TRUE(found("distance to the emission of EGFP: 0.00[0-9]+ \\(noise alone: 0.00", result.err));
}

TEST_F(SpectrumCommand, OneSamplePerPixelTellsNoError) {
    const FilmSpec spec = spectrometer(480, 620, 4);
    Film film(1, 1, film_layers({"EGFP"}, false), 4);
    fill(film, 1, 1, [](int /*pixel*/, int /*channel*/, std::mt19937_64& /*random*/) { return 1.0; });
    Provenance from;
    from.dyes = {"EGFP"};
    save_exr(folder() / "one.exr", film, spec, from);
    expect_rows({{"of the total and of the noise",
                  {"spectrum", "one.exr", "--plot", "one.svg"},
                  0,
                  "\\+- unknown \\(one sample per pixel\\)[\\s\\S]*\\(noise alone: unknown, one sample per pixel\\)",
                  "\n497.5,1,nan,"}});
    const auto json = nlohmann::json::parse(run({"spectrum", "one.exr", "--json"}).out);
    EXPECT_TRUE(json["standard_error"][0].is_null() && json["total_standard_error"].is_null());
    EXPECT_TRUE(json["distance_from_noise"].is_null());
    EXPECT_EQ(read("one.svg").find("nan"), std::string::npos);
}

TEST_F(SpectrumCommand, TakesARegionALayerAndADye) {
    image("a.exr", spectrometer(480, 620, 28));
    const auto mean = [this](const std::vector<std::string>& more) {
        std::vector<std::string> arguments = {"spectrum", "a.exr", "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return nlohmann::json::parse(result.out);
    };
    const double top = mean({"--region", "0,0,8,4"})["mean"][5].get<double>();
    const double bottom = mean({"--region", "0,4,8,8"})["mean"][5].get<double>();
    EXPECT_NEAR(bottom / top, 3, 0.02);
    EXPECT_EQ(mean({"--region", "1,2,3,4"})["region"], nlohmann::json({1, 2, 3, 4}));
    EXPECT_EQ(mean({"--layer", "elastic"})["mean"][5].get<double>(), 0.25);
    EXPECT_TRUE(mean({"--layer", "elastic"})["dyes"].empty());
    EXPECT_LT(mean({})["dyes"][0]["distance"].get<double>(), 0.01);
    const auto other = mean({"--dye", "mCherry", "--dye", "egfp"})["dyes"];
    EXPECT_EQ(other[0]["name"], "mCherry");
    EXPECT_GT(other[0]["distance"].get<double>(), 1);
    EXPECT_LT(other[1]["distance"].get<double>(), 0.01);
    EXPECT_TRUE(mean({"--dye", "none"})["dyes"].empty());
}

TEST_F(SpectrumCommand, ADyesOwnLayerIsComparedWithThatDye) {
    image("a.exr", spectrometer(480, 620, 28), {"EGFP", "mCherry"});
    EXPECT_EQ(nlohmann::json::parse(run({"spectrum", "a.exr", "--json"}).out)["dyes"].size(), 2U);
    const auto own = nlohmann::json::parse(run({"spectrum", "a.exr", "--json", "--layer", "mCherry"}).out)["dyes"];
    ASSERT_EQ(own.size(), 1U);
    EXPECT_EQ(own[0]["name"], "mCherry");
}

TEST_F(SpectrumCommand, PhotonImagesAreComparedAsPhotons) {
    FilmSpec spec = spectrometer(480, 620, 28);
    spec.unit = FilmUnit::Photons;
    image("a.exr", spec);
    const ProgramResult result = run({"spectrum", "a.exr", "--json"});
    EXPECT_LT(nlohmann::json::parse(result.out)["dyes"][0]["distance"].get<double>(), 0.01);
    EXPECT_TRUE(found("mean_photons_per_s_m2_sr_nm", run({"spectrum", "a.exr"}).out));
}

TEST_F(SpectrumCommand, DetectorChannelsAreATable) {
    image("a.exr", two_detectors());
    const ProgramResult result = run({"spectrum", "a.exr"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_TRUE(found("^channel,center_nm,mean_W_per_m2_sr,standard_error\ngreen,525,", result.out)) << result.out;
    expect_rows({{"nothing to plot", {"spectrum", "a.exr", "--plot", "p.svg"}, 4, "a.exr: has detector channels"}});
}

TEST_F(SpectrumCommand, WritesFilesAndNamesThem) {
    image("a.exr", spectrometer(480, 620, 28));
    const ProgramResult result = run({"spectrum", "a.exr", "-o", "r.csv", "--plot", "r.svg"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(found("distance to the emission of EGFP[\\s\\S]*r.csv\nr.svg\n$", result.out)) << result.out;
    EXPECT_EQ(read("r.csv"), run({"spectrum", "a.exr"}).out);
    EXPECT_NE(read("r.svg").find("</svg>"), std::string::npos);
    const std::string red_of_the_residual = "rgb(80%,10%,10%)";
    EXPECT_NE(read("r.svg").find(red_of_the_residual), std::string::npos);
    EXPECT_EQ(run({"spectrum", "a.exr", "--dye", "none", "-o", "r.csv", "--plot", "n.svg"}).exit_code, 0);
    EXPECT_EQ(read("n.svg").find(red_of_the_residual), std::string::npos);
    std::filesystem::remove(folder() / "n.svg");
    EXPECT_EQ(run({"spectrum", "a.exr", "-o", "r.csv"}).exit_code, 0);
    EXPECT_EQ(run({"spectrum", "a.exr", "--plot", "r.png"}).exit_code, 0);
    EXPECT_EQ(read("r.png").substr(1, 3), "PNG");

    write("r.csv", "old");
    RunLimits full_disk;
    full_disk.max_file_bytes = 100;
    EXPECT_EQ(run({"spectrum", "a.exr", "-o", "r.csv"}, full_disk).exit_code, 5);
    EXPECT_EQ(read("r.csv"), "old");
    EXPECT_EQ(files(), (std::vector<std::string>{"a.exr", "r.csv", "r.png", "r.svg"}));
}

TEST_F(SpectrumCommand, AnImageWithoutLightHasNoDistance) {
    const FilmSpec spec = spectrometer(480, 620, 4);
    const Film film(4, 4, film_layers({"EGFP"}, false), 4);
    Provenance from;
    from.dyes = {"EGFP", "no such dye"};
    save_exr(folder() / "black.exr", film, spec, from);
    const ProgramResult result = run({"spectrum", "black.exr", "--plot", "p.png"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(found("EGFP: none, there is no light", result.err));
    EXPECT_TRUE(found("library has no dye \"no such dye\"", result.err));
    EXPECT_TRUE(nlohmann::json::parse(run({"spectrum", "black.exr", "--json"}).out)["dyes"][0]["distance"].is_null());
}

TEST_F(SpectrumCommand, MistakesGetTheirExitCodeAndACure) {
    image("a.exr", spectrometer(480, 620, 2));
    write("text.exr", "text");
    write("cut.exr", read("a.exr").substr(0, 3000));
    expect_rows({
        {"help", {"spectrum", "--help"}, 0, "^$", "sum of \\|a - b\\|"},
        {"no image", {"spectrum"}, 2, "which image"},
        {"two images", {"spectrum", "a.exr", "a.exr"}, 2, "Usage"},
        {"missing", {"spectrum", "none.exr"}, 4, "none.exr: there is no such file", "^$"},
        {"not an image", {"spectrum", "text.exr"}, 4, "text.exr: is not a readable OpenEXR", "^$"},
        {"truncated", {"spectrum", "cut.exr"}, 4, "cut.exr: truncated", "^$"},
        {"region of three", {"spectrum", "a.exr", "--region", "1,2,3"}, 2, "four whole numbers", "^$"},
        {"region of words", {"spectrum", "a.exr", "--region", "a,b,c,d"}, 2, "four whole numbers", "^$"},
        {"trailing text", {"spectrum", "a.exr", "--region", "0,0,2,2px"}, 2, "four whole numbers", "^$"},
        {"region outside", {"spectrum", "a.exr", "--region", "0,0,9,8"}, 2, "leaves the image of 8 x 8", "^$"},
        {"empty region", {"spectrum", "a.exr", "--region", "3,3,3,4"}, 2, "empty", "^$"},
        {"negative region", {"spectrum", "a.exr", "--region", "-1,0,2,2"}, 2, "leaves the image", "^$"},
        {"unknown layer", {"spectrum", "a.exr", "--layer", "plasma"}, 2, "it has total, elastic, fluorescence", "^$"},
        {"unknown dye", {"spectrum", "a.exr", "--dye", "EGPF"}, 2, "EGFP", "^$"},
        {"missing dye file", {"spectrum", "a.exr", "--dye", "no.toml"}, 4, "no.toml", "^$"},
        {"plot of another kind", {"spectrum", "a.exr", "--plot", "p.jpg"}, 2, ".svg or .png", "^$", {}, {"p.jpg"}},
        {"no folder", {"spectrum", "a.exr", "-o", "no/r.csv"}, 5, "no/r.csv", "^$"},
        {"no folder for the plot", {"spectrum", "a.exr", "--plot", "no/r.svg"}, 5, "no/r.svg", "^$"},
    });
}

}  // namespace
}  // namespace fluovox::testing
