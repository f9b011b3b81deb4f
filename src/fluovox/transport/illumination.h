#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/scene/scene.h"
#include "fluovox/spectral/spectrum.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace fluovox {

class FilmResponse;

/// A wavelength chosen to excite dyes at: one laser line, or a point of the continuous spectra.
struct Excitation {
    double wavelength_nm = 0;
    int line = -1;           ///< index into Illumination::lines, or -1
    double probability = 0;  ///< of the line, or density per nm
};

/// What the lights of a scene send out, in photons, and what the dyes can take of it.
/// Units: photons/s (lines) or photons/s/nm (continuous); for uniform light per um^2 and sr besides.
class Illumination {
public:
    struct Line {
        double wavelength_nm = 0;
        std::vector<double> photons;  ///< per light
    };

    explicit Illumination(const Scene& scene);

    const std::vector<Line>& lines() const { return lines_; }
    /// Places of those that reach some channel of a film.
    std::vector<std::size_t> lines_seen_by(const FilmResponse& film) const;
    bool has_continuous() const { return has_continuous_; }
    /// Photons of one light in an excitation.
    double photons(int light, const Excitation& excitation) const;
    double continuous_photons(int light, double wavelength_nm) const;

    /// How strongly a dye at 1 umol/L is excited by all lights together, times its yield: only for choosing.
    double strength(int dye) const { return strength_[static_cast<std::size_t>(dye)]; }

    /// Photons per second that a dye at 1 umol/L would take of a fluence of one per um^2 and photon of this light, per
    /// um.
    double uptake(int light, int dye) const {
        return of_light_[static_cast<std::size_t>(light)][static_cast<std::size_t>(dye)].total;
    }

    /// Draws an excitation for a mixture of dyes; `weights` of each dye (concentration x yield).
    /// Nothing when no light excites any of them.
    std::optional<Excitation> sample(const std::vector<double>& weights, Rng& rng) const;
    /// As `sample`, with the light of one light only.
    std::optional<Excitation> sample(const std::vector<double>& weights, int light, Rng& rng) const;

private:
    // What one dye takes from one light, or from all.
    struct Uptake {
        std::vector<double> by_line;
        Spectrum continuous;  // photons x absorption
        double total = 0;
    };

    Uptake uptake(const Dye& dye, std::optional<int> light) const;
    std::optional<Excitation> sample(const std::vector<double>& weights, const std::vector<Uptake>& uptakes,
                                     Rng& rng) const;

    const Scene* scene_;
    std::vector<Line> lines_;
    std::vector<Spectrum> continuous_;  // photon spectrum of each light
    bool has_continuous_ = false;
    std::vector<Uptake> of_all_;                 // per dye
    std::vector<std::vector<Uptake>> of_light_;  // per light and dye
    std::vector<double> strength_;
};

}  // namespace fluovox
