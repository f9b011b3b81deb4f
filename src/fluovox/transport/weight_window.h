#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fluovox {

/// The course of one path, to learn from what came of it after each scattering but the first.
class PathRecord {
public:
    struct Scattering {
        std::uint8_t level = 0;  ///< of the light at an earlier one, as WeightWindow takes it
        double worth = 0;        ///< of the path
        double found = 0;        ///< light found until then, that scattered just there included
        int flights = 0;         ///< until then
    };

    void clear() {
        scatterings_.clear();
        level_.reset();
        flights_ = 0;
        has_left_ = false;
    }
    void fly() { ++flights_; }
    void leave() { has_left_ = true; }
    void see_level(std::uint8_t level) { level_ = level; }
    void scatter(double worth, double found) {
        if (level_) scatterings_.push_back({*level_, worth, found, flights_});
    }
    /// Light scattered at the last scattering.
    void add_own(double light) {
        if (!scatterings_.empty()) scatterings_.back().found += light;
    }

    int flights() const { return flights_; }
    bool has_left() const { return has_left_; }
    const std::vector<Scattering>& scatterings() const { return scatterings_; }

private:
    std::vector<Scattering> scatterings_;
    std::optional<std::uint8_t> level_;
    int flights_ = 0;
    bool has_left_ = false;
};

/// What a path must be worth where it is scattered to go on as it is: the lower bound of a weight window (Booth &
/// Hendricks, Nucl. Technol. Fusion 5 (1984) 90). With what is worth less Russian roulette is played: it ends, or is
/// worth that. (Nothing is split.) The bound depends on how much of the light gets to where the path was scattered
/// before: that is as good, and known by then, while for that of the place itself memory would have to be waited for.
///
/// Noise for a given time is about least where a path goes on with the chance, per unit of its worth,
///
///     sqrt(s / c) / sqrt(S / C),
///
/// s being the mean square of the light found later by a path worth 1, c the time that takes, S the variance of a path
/// and C its time (Bolin & Meyer, Rendering Techniques '97, 57; Rath et al., ACM Trans. Graph. 41 (2022) 81:1). The
/// optimum is flat; a fifth less than that chance is used.
class WeightWindow {
public:
    /// The largest of all bounds: so no path ends that would be worth that, and where hardly any of the light of an
    /// image is, noise does not grow without end.
    static constexpr double kMost = 4;

    /// Learns from paths from the camera.
    class Survey {
    public:
        /// A path that found so much light in all.
        void add(const PathRecord& path, double light);
        /// What two paths of the same pixel found.
        void add_pair(double a, double b) { squares_ += 0.5 * (a - b) * (a - b); }

        /// None where too few paths were scattered to tell, or too few would end to be worth the trouble.
        std::optional<WeightWindow> window() const;

    private:
        struct Later {
            double count = 0, time = 0, square = 0;  // sums over scatterings
        };
        static constexpr std::size_t kPlaces = 16;

        static std::size_t place_of(std::size_t level);

        std::array<Later, kPlaces> later_;
        double time_ = 0, squares_ = 0;
        int told_ = 0;  // paths that were scattered more than once
    };

    using Bounds = std::array<float, 256>;
    /// By the level of the light (see ShadowGrid): up to kMost.
    explicit WeightWindow(const Bounds& bounds) : bounds_(bounds) {}

    double lower_bound(std::uint8_t level) const { return bounds_[level]; }

private:
    Bounds bounds_;
};

}  // namespace fluovox
