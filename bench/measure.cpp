#include "measure.h"

#include "fluovox/core/memory.h"
#include "fluovox/core/rng.h"

#include <sys/wait.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace fluovox::bench {
namespace {

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
        std::FILE* out = ::fdopen(ends[1], "w");
        for (const auto& [name, value] : figures)
            std::fprintf(out, "%s %.17g\n", name.c_str(), value);
        std::fclose(out);
        std::_Exit(0);
    }
    ::close(ends[1]);
    Figures figures;
    std::FILE* in = ::fdopen(ends[0], "r");
    char name[64];  // NOLINT(*-avoid-c-arrays): fscanf wants one
    double value = 0;
    while (std::fscanf(in, "%63s %lf", name, &value) == 2)
        figures[name] = value;
    std::fclose(in);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (status != 0) throw std::runtime_error("a measured run failed");
    return figures;
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

double plain_loop_rate() {
    constexpr int kSteps = 20'000'000;
    double left = 1;
    int crossings = 0;
    const double seconds = seconds_of([&] {
        Rng rng(1, 2, 3);
        for (int i = 0; i < kSteps; ++i) {
            left -= 0.01 * rng.exponential();
            if (left < 0) {
                left = 1;
                ++crossings;
            }
        }
    });
    return crossings > 0 ? kSteps / seconds / 1e6 : 0;
}

}  // namespace fluovox::bench
