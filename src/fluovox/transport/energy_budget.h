#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace fluovox {

/// A number that was measured with photons.
struct Estimate {
    double value = 0;
    double standard_error = 0;
};

/// Light before any conversion, and after.
enum class LightClass { Excitation, Emission };

/// What became of the light of one class; all numbers in one unit.
struct LightBudget {
    static constexpr int kFaces = 6, kAll = 6;  ///< -x +x -y +y -z +z, and all together
    static constexpr int kEscapes = 3;          ///< specular, ballistic, scattered

    Estimate launched, cut, total;
    std::vector<Estimate> absorbed;                                            ///< per medium
    std::array<std::array<Estimate, kEscapes>, kFaces + 1> escaped;            ///< per face and Escape
    std::array<Estimate, kFaces + 1> not_specular;                             ///< ballistic and scattered together
    std::array<std::array<std::vector<Estimate>, kEscapes>, kFaces> by_angle;  ///< even bins of the angle to the normal
    std::vector<Estimate> reemitted, yield_loss, not_followed;                 ///< per dye, of what it absorbed
};

/// Two classes of light in one unit: shares of the photons launched, or watts.
struct EnergyBudget {
    LightBudget excitation, emission;
};

/// Places of a LightBudget's numbers in a flat row, the same for both classes and units.
class BudgetLayout {
public:
    BudgetLayout(std::size_t media, std::size_t dyes, int angle_bins)
        : media_(media), dyes_(dyes), bins_(static_cast<std::size_t>(angle_bins)) {}

    static constexpr std::size_t kLaunched = 0, kCut = 1, kTotal = 2;
    static std::size_t absorbed(std::size_t medium) { return 3 + medium; }
    std::size_t escaped(int face, int escape) const {
        return 3 + media_ + static_cast<std::size_t>(face) * 3 + static_cast<std::size_t>(escape);
    }
    std::size_t not_specular(int face) const { return escaped(7, 0) + static_cast<std::size_t>(face); }
    std::size_t reemitted(std::size_t dye) const { return not_specular(7) + dye; }
    std::size_t yield_loss(std::size_t dye) const { return reemitted(dye) + dyes_; }
    std::size_t not_followed(std::size_t dye) const { return yield_loss(dye) + dyes_; }
    std::size_t angle(int face, int escape, std::size_t bin) const {
        return not_followed(dyes_) + (static_cast<std::size_t>(face) * 3 + static_cast<std::size_t>(escape)) * bins_ +
               bin;
    }
    std::size_t size() const { return angle(6, 0, 0); }
    std::size_t media() const { return media_; }
    std::size_t dyes() const { return dyes_; }
    std::size_t bins() const { return bins_; }

    /// Fills in what follows from the rest: all faces together, and the total.
    void complete(double* row) const;
    /// The row as a budget.
    LightBudget budget(const Estimate* row) const;

private:
    std::size_t media_, dyes_, bins_;
};

}  // namespace fluovox
