#include "cli/run_program.h"

#include <nlohmann/json.hpp>

#include <string>

namespace fluovox::testing {
namespace {

const std::string kMilk = R"([[medium]]
scattering = "1 /mm"
absorption = "0.05 /mm"
region = { box = { min = ["0 mm", "0 mm", "0 mm"], max = ["10 mm", "10 mm", "10 mm"] } }
[[medium]]
dye = "EGFP"
concentration = "10 uM"
region = { sphere = { center = ["5 mm", "5 mm", "5 mm"], radius = "3 mm" } }
)";

std::string light(const std::string& keys) {
    return "[[light]]\nwavelength = \"488 nm\"\n" + keys;
}

const std::string kPencil = light(
    "kind = \"beam\"\npower = \"1 mW\"\nradius = \"0 um\"\nposition = [\"5 mm\", \"5 mm\", \"-1 mm\"]\n"
    "direction = [0, 0, 1]\n");

class FluenceProgram : public ProgramTest {};

TEST_F(FluenceProgram, BudgetAddsUpForEveryKindOfLightAndNothingIsWarnedOf) {
    const std::vector<std::pair<std::string, std::string>> lights = {
        {"pencil", kPencil},
        {"point", light("kind = \"point\"\npower = \"1 mW\"\nposition = [\"5 mm\", \"5 mm\", \"5 mm\"]\n")},
        {"rectangle",
         light("kind = \"rectangle\"\npower = \"1 mW\"\ncenter = [\"5 mm\", \"5 mm\", \"-1 mm\"]\nnormal = "
               "[0, 0, 1]\nup = [0, 1, 0]\nsize = [\"9 mm\", \"9 mm\"]\n")},
        {"focus",
         light("kind = \"beam\"\npower = \"1 mW\"\nradius = \"10 um\"\nnumerical_aperture = 0.3\nwaist = [\"5 "
               "mm\", \"5 mm\", \"5 mm\"]\nposition = [\"5 mm\", \"5 mm\", \"-1 mm\"]\ndirection = [0, 0, 1]\n")},
        {"sheet",
         light("kind = \"sheet\"\npower = \"1 mW\"\nwidth = \"5 mm\"\nthickness = \"10 um\"\n"
               "numerical_aperture = 0.1\nwaist = [\"5 mm\", \"5 mm\", \"5 mm\"]\nposition = [\"5 mm\", \"5 mm\", "
               "\"-1 mm\"]\nnormal = [1, 0, 0]\ndirection = [0, 0, 1]\n")},
        {"uniform", light("kind = \"uniform\"\nradiance = \"1 W/m2/sr\"\n")}};
    for (const auto& [name, text] : lights) {
        write(name + ".toml", kMilk + text);
        const ProgramResult run =
            this->run({"fluence", name + ".toml", "--photons", "5000", "--json", name + ".json", "-q"});
        EXPECT_EQ(run.exit_code, 0) << run.err;
        EXPECT_EQ(run.err, "") << name;
        const auto json = nlohmann::json::parse(read(name + ".json"));
        EXPECT_NEAR(json["excitation"]["total"]["value"].get<double>(), 1, 1e-9) << name;
        EXPECT_GT(json["emission"]["launched"]["value"].get<double>(), 0) << name;
        EXPECT_NEAR(json["emission"]["total"]["value"].get<double>(),
                    json["emission"]["launched"]["value"].get<double>(), 1e-9);
        if (name != "uniform") {
            EXPECT_NEAR(json["watts"]["excitation"]["total"]["value"].get<double>(), 1e-3, 1e-12) << name;
        }
    }
}

TEST_F(FluenceProgram, SmallSharesAreReadableAndGridsOfWattsHoldNoMoles) {
    std::string thin = kMilk;
    thin.replace(thin.find("10 uM"), 5, "1 pM");
    write("thin.toml", thin + kPencil);
    expect_rows({
        {"one part in many millions",
         {"fluence", "thin.toml", "--photons", "2000", "-o", "f.vdb", "--voxel-size", "1mm", "-q"},
         0,
         "^$",
         "absorbed by EGFP +[1-9][0-9.]*e-0[6-9] \\+- "},
        {"watts", {"info", "f.vdb"}, 0, "^$", "range +min [^\n]+ W/mm2\n"},
    });
    EXPECT_FALSE(found("mol", run({"info", "f.vdb"}).out));
    EXPECT_TRUE(found("\"total_mol\": null", run({"info", "f.vdb", "--json"}).out));
}

TEST_F(FluenceProgram, SceneWithoutDyeIsNotWarnedOfEither) {
    write("clear.toml", kMilk.substr(0, kMilk.find("[[medium]]\ndye")) + kPencil);
    EXPECT_EQ(run({"fluence", "clear.toml", "--photons", "2000", "-q"}).err, "");
}

TEST_F(FluenceProgram, LightThatCannotGetOutEndsAndIsSaidToBeCut) {
    const std::string glass =
        "[[medium]]\nrefractive_index = 1.5\nregion = { sphere = { center = [\"0 um\", \"0 um\", \"0 um\"], radius = "
        "\"1 "
        "mm\" } }\n";
    write("trapped.toml",
          glass + light("kind = \"point\"\npower = \"1 mW\"\nposition = [\"0.9 mm\", \"0 um\", \"0 um\"]\n"));
    write("endless.toml", "[[medium]]\nscattering = \"1 /mm\"\nregion = \"everywhere\"\n" +
                              light("kind = \"point\"\npower = \"1 mW\"\nposition = [\"0 um\", \"0 um\", \"0 um\"]\n"));
    write("partly.toml", glass +
                             "[[medium]]\nrefractive_index = 1.33\nregion = { sphere = { center = [\"1 mm\", \"0 um\", "
                             "\"0 um\"], radius = \"1 mm\" } }\n" +
                             kPencil);
    write("wide.toml", kMilk + light("kind = \"beam\"\npower = \"1 mW\"\nradius = \"10 um\"\nnumerical_aperture = 1.2\n"
                                     "position = [\"5 mm\", \"5 mm\", \"-1 mm\"]\ndirection = [0, 0, 1]\n"));
    write("outside.toml",
          glass + light("kind = \"beam\"\npower = \"1 mW\"\nradius = \"10 um\"\nnumerical_aperture = 1.2\n"
                        "position = [\"0 mm\", \"0 mm\", \"-2 mm\"]\ndirection = [0, 0, 1]\n"));
    expect_rows({
        {"total reflection",
         {"fluence", "trapped.toml", "--photons", "2000", "-q"},
         0,
         "^warning: 6\\d % of the light was cut",
         "cut \\(roulette"},
        {"no end",
         {"fluence", "endless.toml"},
         3,
         "^endless.toml:1:1: error: light of 488 nm would scatter here for ever"},
        {"half inside",
         {"fluence", "partly.toml"},
         3,
         "^partly.toml:4:1: error: \"host1\" and \"host2\" overlap in part"},
        {"half inside, only checked", {"check", "partly.toml"}, 3, ""},
        {"aperture", {"fluence", "wide.toml"}, 3, "numerical_aperture = 1.2 must be below 1"},
        {"aperture that only another medium allows",
         {"fluence", "outside.toml"},
         3,
         "numerical_aperture = 1.2 must be below 1"},
    });
}

TEST_F(FluenceProgram, LightThatMeetsNoMediumIsWarnedOfAndByHowMuchItMisses) {
    std::string beside = kPencil;
    beside.replace(beside.find("\"5 mm\""), 6, "\"15 mm\"");
    write("miss.toml", kMilk + beside);
    expect_rows({{"on stderr",
                  {"fluence", "miss.toml", "--photons", "2000", "-q", "--json", "miss.json"},
                  0,
                  "^warning: no photon met a medium: all light passes them by\n"
                  "warning: host1: the beam passes it 5 mm away\n"
                  "warning: EGFP: the beam passes it 7 mm away\n$"}});
    const auto missed = nlohmann::json::parse(read("miss.json"));
    EXPECT_EQ(missed.at("warnings").at(0), "no photon met a medium: all light passes them by");
    EXPECT_EQ(missed.at("met_a_medium").at("value"), 0);
    write("meet.toml", kMilk + kPencil);
    ASSERT_EQ(run({"fluence", "meet.toml", "--photons", "2000", "-q", "--json", "meet.json"}).err, "");
    const auto met = nlohmann::json::parse(read("meet.json"));
    EXPECT_TRUE(met.at("warnings").empty());
    EXPECT_EQ(met.at("met_a_medium").at("value"), 1);
}

TEST_F(FluenceProgram, SaysWhenThePhotonsWereTooFewForThePrecisionAskedFor) {
    write("scene.toml", kMilk + kPencil);
    expect_rows({
        {"too few",
         {"fluence", "scene.toml", "--photons", "3000", "--rse", "1e-4", "-q"},
         0,
         "^warning: 3000 photons were not enough for the relative standard error asked for \\(--rse 1e-4\\)"},
    });
    EXPECT_EQ(run({"fluence", "scene.toml", "--rse", "0.1", "-q"}).err, "");
}

TEST_F(FluenceProgram, SameSeedGivesTheSameBudgetForAnyNumberOfThreads) {
    write("scene.toml", kMilk + kPencil);
    expect_rows({
        {"one thread", {"fluence", "scene.toml", "--photons", "3000", "--json", "a.json", "--threads", "1"}, 0},
        {"two", {"fluence", "scene.toml", "--photons", "3000", "--json", "b.json", "--threads", "2"}, 0},
        {"another seed", {"fluence", "scene.toml", "--photons", "3000", "--json", "c.json", "--seed", "2"}, 0},
    });
    EXPECT_EQ(read("a.json"), read("b.json"));
    EXPECT_NE(read("a.json"), read("c.json"));
}

TEST_F(FluenceProgram, ScenesTellWhichPhaseFunctionTheyHave) {
    std::string scene =
        kMilk + kPencil +
        "[camera]\nposition = [\"0 um\", \"0 um\", \"2 mm\"]\ntarget = [\"0 um\", \"0 um\", \"0 um\"]\n"
        "field = \"60 um\"\nresolution = [2, 2]\n[film]\nspectrum = { from = \"500 nm\", to = \"600 nm\", "
        "bins = 2 }\n";
    scene.insert(scene.find("absorption"), "phase_function = { file = \"phase.csv\" }\n");
    write("phase.csv", "angle_deg,value\n0,30\n20,5\n90,1\n180,2\n");
    write("scene.toml", scene);
    expect_rows({{"table", {"fluence", "scene.toml", "--photons", "2000"}, 0},
                 {"printed", {"check", "scene.toml", "--print"}, 0, "", "\"kind\": \"table\""},
                 {"not normalised, which is said", {"check", "scene.toml"}, 0, "integrates to .* scaled to 1"}});
    write("phase.csv", "angle_deg,value\n0,0\n180,0\n");
    expect_rows({{"nothing in it", {"fluence", "scene.toml"}, 3, "phase.csv.*cannot be normalised"}});
}

}  // namespace
}  // namespace fluovox::testing
