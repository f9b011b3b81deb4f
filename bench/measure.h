#pragma once

#include <functional>
#include <map>
#include <string>

namespace fluovox::bench {

/// Named figures of one run.
using Figures = std::map<std::string, double>;

/// Runs `work` `repeats` times with so many threads, each time in a process of its own, so that peak memory and
/// warm-up are of that run alone. The median of each figure; "peak_bytes" is added.
Figures measure(int threads, int repeats, const std::function<Figures()>& work);

/// Does `work` and sets "seconds" (of the clock) and "cpu" (seconds of all threads together).
void time_into(Figures& figures, const std::function<void()>& work);

/// Seconds that `work` takes.
double seconds_of(const std::function<void()>& work);

/// Bytes that the process holds at present (resident set).
double resident_bytes();

/// Millions of steps per second of a plain loop on one thread: a random number, an exponential step, a comparison.
/// What a machine can do at best, for comparing figures between machines.
double plain_loop_rate();

/// Photons per millisecond of a plain loop on one thread, in double precision and without voxels: the cube of 60 mm
/// with mu_a 0.005/mm, mu_s 1/mm, g 0.01, pencil beam in the middle of a face, roulette below a tenth. The yardstick
/// for `fluence` on the same cube.
double plain_cube_rate();

}  // namespace fluovox::bench
