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

/// Seconds that `work` takes.
double seconds_of(const std::function<void()>& work);

/// Millions of steps per second of a plain loop on one thread: a random number, an exponential step, a comparison.
/// What a machine can do at best, for comparing figures between machines.
double plain_loop_rate();

}  // namespace fluovox::bench
