#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace fluovox::testing {

/// Expects `volume` to be `truth` within a share of it. With FLUOVOX_FIGURES set in the environment it also prints what
/// came out, as a row of the table of tools/bench_voxelize.sh: name, what it may be off by and what it is, both in %.
inline void expect_volume(const std::string& name, double volume, double truth, double within) {
    const double error = volume / truth - 1;
    EXPECT_LE(std::abs(error), within) << name << ": " << volume << " instead of " << truth;
    if (std::getenv("FLUOVOX_FIGURES") == nullptr) return;
    std::printf("figure: %-48s %8g %+10.4f\n", name.c_str(), 100 * within, 100 * error);
}

}  // namespace fluovox::testing
