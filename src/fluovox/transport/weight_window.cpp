#include "fluovox/transport/weight_window.h"

#include "fluovox/transport/roulette.h"

#include <algorithm>
#include <cmath>

namespace fluovox {
namespace {

// In times of a flight from one scattering to the next. The one that leaves goes through all there is; but rays from
// the camera, one beside the other, seldom wait for memory.
double time_of(int flights, bool leaves) {
    constexpr double kLeaves = 3;
    return flights + (leaves ? kLeaves - 1 : 0);
}

}  // namespace

// Narrow ones where there is little light.
std::size_t WeightWindow::Survey::place_of(std::size_t level) {
    return static_cast<std::size_t>(std::sqrt(static_cast<double>(level)));
}

void WeightWindow::Survey::add(const PathRecord& path, double light) {
    time_ += time_of(path.flights(), path.has_left() && path.flights() > 1);
    told_ += path.scatterings().empty() ? 0 : 1;
    for (const PathRecord::Scattering& at : path.scatterings()) {
        const double found = (light - at.found) / at.worth;
        Later& later = later_[place_of(at.level)];
        ++later.count;
        later.time += time_of(path.flights() - at.flights, path.has_left());
        later.square += found * found;
    }
}

std::optional<WeightWindow> WeightWindow::Survey::window() const {
    constexpr double kOfBest = 0.8;
    constexpr double kOthers = 16;  // what a place says counts as what so many scatterings anywhere say
    constexpr double kFewEnd = 0.1;
    constexpr int kFewTell = 256;
    Later all;
    for (const Later& later : later_) {
        all.count += later.count;
        all.time += later.time;
        all.square += later.square;
    }
    if (told_ < kFewTell || squares_ <= 0) return std::nullopt;
    const double variance_per_time = 2 * squares_ / time_;
    std::array<double, kPlaces> bounds{};
    double ended = 0;  // of paths worth 1, at the best chance
    for (std::size_t i = 0; i < kPlaces; ++i) {
        const double time = later_[i].time + kOthers / all.count * all.time;
        const double square = later_[i].square + kOthers / all.count * all.square;
        bounds[i] = std::clamp(std::sqrt(variance_per_time * time / square) / kOfBest, kFaintPath, kMost);
        ended += later_[i].count / all.count * std::max(0.0, 1 - 1 / (kOfBest * bounds[i]));
    }
    if (ended < kFewEnd) return std::nullopt;
    Bounds by_level{};
    for (std::size_t level = 0; level < by_level.size(); ++level)
        by_level[level] = static_cast<float>(bounds[place_of(level)]);
    return WeightWindow(by_level);
}

}  // namespace fluovox
