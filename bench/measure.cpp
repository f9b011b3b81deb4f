#include "measure.h"

#include "fluovox/core/memory.h"
#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace fluovox::bench {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

double cpu_seconds() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

Figures in_own_process(int threads, const std::function<Figures()>& work) {
    int ends[2];  // NOLINT(*-avoid-c-arrays): pipe wants one
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("no process");
    if (child == 0) {
        ::close(ends[0]);
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(threads));
        Figures figures = work();
        figures["peak_bytes"] = static_cast<double>(peak_resident_bytes());
        {
            const File out(::fdopen(ends[1], "w"), std::fclose);
            for (const auto& [name, value] : figures)
                std::fprintf(out.get(), "%s %.17g\n", name.c_str(), value);
        }
        std::_Exit(0);
    }
    ::close(ends[1]);
    Figures figures;
    const File in(::fdopen(ends[0], "r"), std::fclose);
    char name[64];  // NOLINT(*-avoid-c-arrays): fscanf wants one
    double value = 0;
    while (std::fscanf(in.get(), "%63s %lf", name, &value) == 2)
        figures[name] = value;
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) throw std::runtime_error("a measured run failed");
    return figures;
}

/// What a milky cube absorbs of a photon that enters it in the middle of a face.
double absorbed_in_plain_cube(int photon) {
    constexpr double kSize = 60;
    constexpr double kScattering = 1;
    constexpr double kAbsorption = 0.005;
    constexpr double kG = 0.01;
    Rng rng(7, static_cast<std::uint64_t>(photon), 1);
    Vec3 p{30, 30, 0};
    Vec3 d{0, 0, 1};
    double weight = 1;
    double absorbed = 0;
    for (;;) {
        const double step = -std::log(1 - rng.uniform()) / kScattering;
        double wall = step;
        for (int axis = 0; axis < 3; ++axis) {
            if (d[axis] != 0) wall = std::min(wall, ((d[axis] > 0 ? kSize : 0) - p[axis]) / d[axis]);
        }
        const double left = weight * std::exp(-kAbsorption * wall);
        absorbed += weight - left;
        weight = left;
        if (wall < step) return absorbed;
        p = p + wall * d;
        if (weight < 0.1) {
            if (rng.uniform() >= 0.2) return absorbed;
            weight *= 5;
        }
        const double f = (1 - kG * kG) / (1 - kG + 2 * kG * rng.uniform());
        const double cosine = (1 + kG * kG - f * f) / (2 * kG);
        const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
        const double azimuth = 2 * std::numbers::pi * rng.uniform();
        const Frame frame = Frame::around(d);
        d = frame.to_world({sine * std::cos(azimuth), sine * std::sin(azimuth), cosine});
    }
}

}  // namespace

Figures measure(int threads, int repeats, const std::function<Figures()>& work) {
    std::map<std::string, std::vector<double>> all;
    for (int i = 0; i < repeats; ++i) {
        for (const auto& [name, value] : in_own_process(threads, work))
            all[name].push_back(value);
    }
    Figures medians;
    for (auto& [name, values] : all) {
        std::sort(values.begin(), values.end());
        medians[name] = values[values.size() / 2];
    }
    return medians;
}

double seconds_of(const std::function<void()>& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void time_into(Figures& figures, const std::function<void()>& work) {
    const double before = cpu_seconds();
    figures["seconds"] = seconds_of(work);
    figures["cpu"] = cpu_seconds() - before;
}

double resident_bytes() {
    std::ifstream in("/proc/self/statm");
    double pages = 0;
    double resident = 0;
    in >> pages >> resident;
    return resident * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

double plain_cube_rate() {
    constexpr int kPhotons = 60'000;
    double absorbed = 0;
    Figures figures;
    time_into(figures, [&] {
        for (int i = 0; i < kPhotons; ++i)
            absorbed += absorbed_in_plain_cube(i);
    });
    return absorbed > 0 ? kPhotons / figures["cpu"] / 1e3 : 0;
}

double plain_loop_rate() {
    constexpr int kSteps = 20'000'000;
    double left = 1;
    int crossings = 0;
    Figures figures;
    time_into(figures, [&] {
        Rng rng(1, 2, 3);
        for (int i = 0; i < kSteps; ++i) {
            left -= 0.01 * -std::log(1 - rng.uniform());
            if (left < 0) {
                left = 1;
                ++crossings;
            }
        }
    });
    return crossings > 0 ? kSteps / figures["cpu"] / 1e6 : 0;
}

}  // namespace fluovox::bench
