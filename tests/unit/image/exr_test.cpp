#include "fluovox/image/exr.h"

#include "fluovox/core/error.h"
#include "fluovox/core/version.h"

#include "test_images.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>

namespace fluovox {
namespace {

namespace fs = std::filesystem;

class Exr : public ::testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }

    static std::string content(const fs::path& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write(const fs::path& file, const std::string& bytes) {
        std::ofstream(file, std::ios::binary) << bytes;
    }

    /// 7 x 70 pixels (more than one strip of lines), all layers.
    static Film noisy_film(const FilmSpec& spec) {
        Film film(7, 70, film_layers({"EGFP", "My.Dye"}, true), static_cast<int>(spec.channels.size()));
        testing::fill(film, 4, 1, [](int pixel, int channel, std::mt19937_64& random) {
            return 1e-5 * (pixel + 1) * (channel + 1) * std::lognormal_distribution<double>(0, 1)(random);
        });
        return film;
    }

    const fs::path folder_ =
        fs::path(::testing::TempDir()) /
        (std::string("fluovox_exr_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
    const fs::path file_ = folder_ / "image.exr";
    const FilmSpec spec_ = testing::spectrometer(480, 620, 3);
    const Provenance from_ = {"{\"title\": \"a scene\"}", 18446744073709551615ULL, 64, "path", {"EGFP", "My.Dye"}};
};

void expect_equal(const RenderedImage& a, const RenderedImage& b) {
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.layers, b.layers);
    EXPECT_EQ(a.means, b.means);
    EXPECT_EQ(a.variances, b.variances);
    EXPECT_EQ(a.variances_of_all, b.variances_of_all);
    EXPECT_EQ(a.variances_of_regions, b.variances_of_regions);
    EXPECT_EQ(a.variance_unit, b.variance_unit);
    EXPECT_EQ(a.counts, b.counts);
    EXPECT_EQ(a.version, b.version);
    EXPECT_EQ(a.nan_count, b.nan_count);
    EXPECT_EQ(a.bound_violations, b.bound_violations);
    EXPECT_EQ(a.provenance.scene_json, b.provenance.scene_json);
    EXPECT_EQ(a.provenance.seed, b.provenance.seed);
    EXPECT_EQ(a.provenance.samples, b.provenance.samples);
    EXPECT_EQ(a.provenance.estimator, b.provenance.estimator);
    EXPECT_EQ(a.provenance.dyes, b.provenance.dyes);
    EXPECT_EQ(a.film.is_spectral, b.film.is_spectral);
    EXPECT_EQ(a.film.unit, b.film.unit);
    EXPECT_EQ(a.film.from_nm, b.film.from_nm);
    EXPECT_EQ(a.film.to_nm, b.film.to_nm);
    ASSERT_EQ(a.film.channels.size(), b.film.channels.size());
    for (std::size_t i = 0; i < a.film.channels.size(); ++i) {
        EXPECT_EQ(a.film.channels[i].name, b.film.channels[i].name);
        EXPECT_EQ(a.film.channels[i].center_nm, b.film.channels[i].center_nm);
        EXPECT_EQ(a.film.channels[i].counts_photons, b.film.channels[i].counts_photons);
        EXPECT_EQ(a.film.channels[i].response.wavelengths_nm(), b.film.channels[i].response.wavelengths_nm());
        EXPECT_EQ(a.film.channels[i].response.values(), b.film.channels[i].response.values());
    }
}

TEST_F(Exr, EverythingComesBack) {
    Film film = noisy_film(spec_);
    film.add_bound_violations(7);
    film.add(3, std::vector<double>(film.values_per_sample(), std::nan("")));
    save_exr(file_, film, spec_, from_);
    const RenderedImage image = load_exr(file_);
    expect_equal(image, make_image(film, spec_, from_));
    EXPECT_EQ(image.nan_count, 1);
    EXPECT_EQ(image.counts[3], 5);
    EXPECT_EQ(image.counts[4], 4);
    EXPECT_FLOAT_EQ(static_cast<float>(image.mean(3, 100, 2)), static_cast<float>(film.mean(3, 100, 2)));
    EXPECT_NEAR(image.variance(2, 100, 1) / film.variance_of_mean(2, 100, 1), 1, 1e-6);
    EXPECT_NEAR(image.mean_of_all(2, 100) / film.mean_of_all(2, 100), 1, 1e-6);
    EXPECT_NEAR(image.variance_of_all(2, 100) / film.variance_of_mean_of_all(2, 100), 1, 1e-6);
}

TEST_F(Exr, VariancesOfRegionsComeBackWherePixelsShareSamples) {
    Film film(7, 70, film_layers({"EGFP", "My.Dye"}, true), 3);
    std::mt19937_64 random(1);
    std::vector<double> values(static_cast<std::size_t>(film.pixels()) * film.values_per_sample());
    for (int sample = 0; sample < 4; ++sample) {
        for (double& value : values)
            value = std::exponential_distribution<double>(1)(random);
        film.add_shared(values);
    }
    save_exr(file_, film, spec_, from_);
    const RenderedImage image = load_exr(file_);
    expect_equal(image, make_image(film, spec_, from_));
    ASSERT_TRUE(image.shares_samples());
    EXPECT_NEAR(image.variance_of_region(2, 3, 8) / film.variance_of_region_mean(2, 8, 3), 1, 1e-6);
}

TEST_F(Exr, DetectorChannelsComeBack) {
    const FilmSpec spec = testing::two_detectors();
    const Film film = noisy_film(spec);
    save_exr(file_, film, spec, from_);
    expect_equal(load_exr(file_), make_image(film, spec, from_));
}

TEST_F(Exr, PhotonsPerSecondFitIntoFloat) {
    FilmSpec spec = testing::spectrometer(480, 620, 1);
    spec.unit = FilmUnit::Photons;
    Film film(2, 2, {"total"}, 1);
    for (const double x : {1e22, 3e22, 2e22})
        film.add(1, std::array{x});
    save_exr(file_, film, spec, from_);
    const RenderedImage image = load_exr(file_);
    EXPECT_NEAR(image.variance(0, 1, 0) / film.variance_of_mean(0, 1, 0), 1, 1e-6);
    EXPECT_EQ(Imf::InputFile(file_.c_str()).header().channels().findChannel("S0.550,000nm"), nullptr);
    EXPECT_NE(Imf::InputFile(file_.c_str()).header().channels().findChannel("photons.550,000nm"), nullptr);
}

TEST_F(Exr, HasExactlyOneSpectralSetForForeignReaders) {
    save_exr(file_, noisy_film(spec_), spec_, from_);
    const Imf::InputFile file(file_.c_str());
    // What the reference reader of the layout looks for.
    const std::regex spectral(
        R"(^((S([0-3]))|T)\.(\d*,?\d*([Ee][+-]?\d+)?)(Y|Z|E|P|T|G|M|k|h|da|d|c|m|u|n|p)?(m|Hz)$)");
    int sets = 0;
    for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) {
        sets += std::regex_match(it.name(), spectral) ? 1 : 0;
        EXPECT_EQ(it.channel().type, Imf::FLOAT) << it.name();
    }
    EXPECT_EQ(sets, 3);
    for (const char* name : {"S0.503,333nm", "elastic.550,000nm", "fluorescence.550,000nm", "variance.550,000nm",
                             "variance.fluorescence.550,000nm", "dye.EGFP.550,000nm", "variance.dye.My_Dye.550,000nm",
                             "variance.all.channels", "variance.dye.EGFP.all.channels", "R", "G", "B"}) {
        EXPECT_NE(file.header().channels().findChannel(name), nullptr) << name;
    }
    const auto text = [&](const char* name) {
        return file.header().typedAttribute<Imf::StringAttribute>(name).value();
    };
    EXPECT_EQ(text("spectralLayoutVersion"), "1.0");
    EXPECT_EQ(text("emissiveUnits"), "W.m^-2.sr^-1");
    EXPECT_EQ(text("fluovox:radianceUnits"), "W.m^-2.sr^-1.nm^-1");
    EXPECT_EQ(text("fluovox:version"), version());
    EXPECT_EQ(text("fluovox:seed"), "18446744073709551615");
    EXPECT_EQ(text("fluovox:count"), "4");
    EXPECT_EQ(text("fluovox:nanCount"), "0");
    EXPECT_EQ(file.header().findTypedAttribute<Imf::StringAttribute>("capDate"), nullptr);
}

TEST_F(Exr, ChannelsNamedLikeThePreviewTakeItsPlace) {
    FilmSpec spec = testing::two_detectors();
    spec.channels[0].name = "G";
    const Film film = noisy_film(spec);
    save_exr(file_, film, spec, from_);
    expect_equal(load_exr(file_), make_image(film, spec, from_));
    EXPECT_EQ(Imf::InputFile(file_.c_str()).header().channels().findChannel("R"), nullptr);
}

TEST_F(Exr, SameFilmSameBytesForAnyNumberOfThreads) {
    const Film film = noisy_film(spec_);
    save_exr(file_, film, spec_, from_);
    const std::string once = content(file_);
    const int threads = Imf::globalThreadCount();
    Imf::setGlobalThreadCount(4);
    save_exr(file_, film, spec_, from_);
    Imf::setGlobalThreadCount(threads);
    EXPECT_EQ(content(file_), once);
}

TEST_F(Exr, DebiansOwnReaderAgrees) {
    if (std::system("command -v exrinfo >/dev/null") != 0) GTEST_SKIP() << "exrinfo (package openexr) is not installed";
    save_exr(file_, noisy_film(spec_), spec_, from_);
    const std::string command = "exrinfo -s -a '" + file_.string() + "' > '" + (folder_ / "info").string() + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    const std::string info = content(folder_ / "info");
    EXPECT_NE(info.find("'S0.550,000nm'"), std::string::npos) << info;
    EXPECT_NE(info.find("7 x 70"), std::string::npos) << info;
}

TEST_F(Exr, RefusesWhatIsNotOurs) {
    const auto message = [this] {
        try {
            load_exr(file_);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("nothing thrown");
    };
    EXPECT_NE(message().find("no such file"), std::string::npos);
    write(file_, "");
    EXPECT_NE(message().find("not a readable OpenEXR"), std::string::npos);
    write(file_, "some text that is long enough to be a header");
    EXPECT_NE(message().find("not a readable OpenEXR"), std::string::npos);
    {
        const std::vector<Imf::Rgba> pixels(16, Imf::Rgba(0, 0, 0));
        Imf::RgbaOutputFile foreign(file_.c_str(), 4, 4);
        foreign.setFrameBuffer(pixels.data(), 1, 4);
        foreign.writePixels(4);
    }
    EXPECT_NE(message().find("not one that fluovox rendered"), std::string::npos) << message();
    EXPECT_THROW(load_exr(folder_), InputError);
}

TEST_F(Exr, TruncatedFilesAreErrors) {
    save_exr(file_, noisy_film(spec_), spec_, from_);
    const std::string whole = content(file_);
    const fs::path cut = folder_ / "cut.exr";
    for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 211) {
        write(cut, whole.substr(0, length));
        EXPECT_THROW(load_exr(cut), InputError) << length;
    }
}

TEST_F(Exr, DamagedFilesAreErrorsOrImagesButNeverACrash) {
    save_exr(file_, noisy_film(spec_), spec_, from_);
    const std::string whole = content(file_);
    std::mt19937_64 random(5);
    const fs::path damaged = folder_ / "damaged.exr";
    int refused = 0;
    for (int i = 0; i < 300; ++i) {
        std::string bytes = whole;
        const std::size_t reach = i % 2 == 0 ? 6000 : bytes.size();  // half of the time in the header
        for (int k = 0; k < 1 + i % 4; ++k)
            bytes[random() % std::min(reach, bytes.size())] = static_cast<char>(random());
        write(damaged, bytes);
        try {
            load_exr(damaged);
        } catch (const InputError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 50);
}

/// Files of this process cannot grow beyond a size, as on a full disk.
class SmallDisk {
public:
    explicit SmallDisk(rlim_t bytes) {
        std::signal(SIGXFSZ, SIG_IGN);
        ::getrlimit(RLIMIT_FSIZE, &before_);
        rlimit limit = before_;
        limit.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;
    ~SmallDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

private:
    rlimit before_{};
};

TEST_F(Exr, AFullDiskAnywhereLeavesTheOldFile) {
    const Film film = noisy_film(spec_);
    save_exr(file_, film, spec_, from_);
    const std::string old = content(file_);
    for (std::size_t bytes = 0; bytes < old.size(); bytes += 1 + old.size() / 23) {
        const SmallDisk disk(bytes);
        EXPECT_THROW(save_exr(file_, film, spec_, from_), OutputError) << bytes;
    }
    {
        const SmallDisk disk(old.size() - 1);
        EXPECT_THROW(save_exr(file_, film, spec_, from_), OutputError);
    }
    EXPECT_EQ(content(file_), old);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
    EXPECT_THROW(save_exr(folder_ / "no" / "such.exr", film, spec_, from_), OutputError);
}

}  // namespace
}  // namespace fluovox
