#include "fluovox/image/exr.h"

#include "cli/run_program.h"
#include "test_images.h"

#include <nlohmann/json.hpp>
#include <png.h>

#include <cstring>

namespace fluovox::testing {
namespace {

class Diff : public ProgramTest {
protected:
    /// 16 x 16 pixels of two bins; `factor` times the light of the others.
    void image(const std::string& name, std::uint64_t seed, double factor = 1, int size = 16) const {
        const FilmSpec spec = spectrometer(480, 620, 2);
        Film film(size, size, film_layers({"EGFP"}, false), 2);
        fill(film, 64, seed, [factor](int /*pixel*/, int /*channel*/, std::mt19937_64& random) {
            return factor * std::lognormal_distribution<double>(0, 1)(random);
        });
        Provenance from;
        from.seed = seed;
        from.estimator = "path";
        save_exr(folder() / name, film, spec, from);
    }
};

TEST_F(Diff, AnswersByExitCode) {
    image("a.exr", 1);
    image("b.exr", 2);
    image("brighter.exr", 3, 1.2);
    expect_rows({
        {"the same file", {"diff", "a.exr", "a.exr"}, 0, "^$", "^same: p = 1\n"},
        {"another seed", {"diff", "a.exr", "b.exr"}, 0, "^$", "^same: p = "},
        {"a brighter scene", {"diff", "a.exr", "brighter.exr"}, 1, "^$", "^different: p = .*fluorescence"},
        {"quiet says it by the exit code alone", {"diff", "-q", "a.exr", "brighter.exr"}, 1, "^$", "^$"},
        {"help", {"diff", "--help"}, 0, "^$", "^Examples:"},
    });
}

TEST_F(Diff, NoticesSharedRandomNumbers) {
    image("a.exr", 1);
    image("b.exr", 1, 1.001);
    EXPECT_TRUE(found("both images have seed 1", run({"diff", "a.exr", "b.exr"}).err));
    EXPECT_EQ(run({"diff", "a.exr", "a.exr"}).err, "");
}

TEST_F(Diff, TroubleIsTwo) {
    image("a.exr", 1);
    image("small.exr", 2, 1, 8);
    write("text.exr", "not an image");
    write("cut.exr", read("a.exr").substr(0, 5000));
    expect_rows({
        {"missing file", {"diff", "a.exr", "none.exr"}, 2, "none.exr: there is no such file", "^$"},
        {"not an image", {"diff", "text.exr", "a.exr"}, 2, "text.exr: is not a readable OpenEXR", "^$"},
        {"truncated", {"diff", "a.exr", "cut.exr"}, 2, "cut.exr: truncated or damaged", "^$"},
        {"other size", {"diff", "a.exr", "small.exr"}, 2, "16 x 16 and 8 x 8 pixels", "^$"},
        {"one image", {"diff", "a.exr"}, 2, "two images[\\s\\S]*Usage: fluovox diff", "^$"},
        {"none", {"diff"}, 2, "two images", "^$"},
        {"unknown option", {"diff", "a.exr", "a.exr", "--fuzzy"}, 2, "fuzzy", "^$"},
        {"picture of another kind",
         {"diff", "a.exr", "a.exr", "-o", "z.jpg"},
         2,
         "must end in .png",
         "^$",
         {},
         {"z.jpg"}},
    });
}

TEST_F(Diff, JsonHasTheAgreedKeys) {
    image("a.exr", 1);
    image("b.exr", 2, 1.2);
    const ProgramResult result = run({"diff", "a.exr", "b.exr", "--json"});
    EXPECT_EQ(result.exit_code, 1);
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_FALSE(json.at("same").get<bool>());
    EXPECT_LT(json.at("p_value").get<double>(), 1e-3);
    EXPECT_EQ(json.at("pixels").get<int>(), 256);
    EXPECT_GE(json.at("differing").get<int>(), 0);
    EXPECT_NEAR(json.at("mean_b").get<double>() - json.at("mean_a").get<double>(), 0.2 * std::exp(0.5), 0.05);
}

TEST_F(Diff, WritesPicturesOrLeavesTheOldOnes) {
    image("a.exr", 1);
    image("b.exr", 2, 1.5);
    EXPECT_EQ(run({"diff", "a.exr", "b.exr", "-o", "z.png", "--p-values", "p.png"}).exit_code, 1);
    png_image header;
    std::memset(&header, 0, sizeof header);
    header.version = PNG_IMAGE_VERSION;
    const std::string png = read("z.png");
    ASSERT_NE(png_image_begin_read_from_memory(&header, png.data(), png.size()), 0);
    EXPECT_EQ(header.width, 16U);
    png_image_free(&header);

    write("z.png", "old");
    RunLimits full_disk;
    full_disk.max_file_bytes = 50;
    const ProgramResult result = run({"diff", "a.exr", "b.exr", "-o", "z.png"}, full_disk);
    EXPECT_EQ(result.exit_code, 5);
    EXPECT_TRUE(found("z.png", result.err));
    EXPECT_EQ(read("z.png"), "old");
    EXPECT_EQ(files(), (std::vector<std::string>{"a.exr", "b.exr", "p.png", "z.png"}));
    expect_rows({{"no such folder", {"diff", "a.exr", "b.exr", "-o", "no/z.png"}, 5, "no.*does not exist"}});
}

}  // namespace
}  // namespace fluovox::testing
