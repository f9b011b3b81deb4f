#pragma once

#include "fluovox/scene/scene.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/shadow_guess.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace fluovox {

/// Guesses of how much light gets to where paths scatter, for the laser lines and lights of a scene where they pay:
/// light that shines alike on all there is, one thick grid, and paths enough. Made once; any number of threads may read
/// it. Memory: about 1.3 bytes per voxel that is not zero for each, at most kMost; some more for a moment while it is
/// made.
class LightShadows {
public:
    static constexpr std::size_t kMost = 4;

    /// None.
    LightShadows() = default;
    /// `paths`: as many will be followed. The scene must outlive this.
    LightShadows(const Scene& scene, const Illumination& illumination, std::int64_t paths);

    /// Of a line and a light of the illumination; null where there is none.
    const ShadowGuess* find(std::size_t line, std::size_t light) const {
        const auto found = guesses_.find({line, light});
        return found == guesses_.end() ? nullptr : &found->second;
    }
    bool empty() const { return guesses_.empty(); }
    std::size_t memory_bytes() const;

private:
    std::map<std::pair<std::size_t, std::size_t>, ShadowGuess> guesses_;
};

}  // namespace fluovox
