#pragma once

#include "fluovox/image/plot.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/fluence.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fluovox::validation {

/// A number somebody else found, and how we find it.
struct Case {
    std::string name;
    double expected = 0;
    double uncertainty = 0;  ///< of `expected`, one sigma
    std::string source;
    Scene scene;
    std::function<Estimate(const FluenceResult&)> measure;
    double scale = 1;   ///< the number for a share of one of the light launched, for the precision that is asked
    double size = 0;    ///< the value that the precision is asked of; 0: `expected`
    double aim = 0;     ///< standard error to run to; 0: that which is asked
    bool many = false;  ///< many values tested at once, as a deviation whose standard error is 1
    /// Of pictures: the share of the launched light that reaches the sensor, found on the way. `scale` follows from it.
    std::shared_ptr<double> reaches_sensor = {};
    FluenceSettings settings = {};
    /// For what is not one run of `scene`: the number with so many photons (or samples) of this seed.
    std::function<Estimate(std::int64_t, std::uint64_t)> estimate = {};
    std::int64_t fixed = 0;  ///< photons or samples; 0: as many as the precision needs
    double finer = 1;        ///< than the precision that is asked
};

struct Outcome {
    const Case* what = nullptr;
    Estimate got;
    std::int64_t photons = 0;
    double seconds = 0;

    double z() const;
    /// Which of the two bounds on the standard error holds: 1e-3 of the value, 3e-4 of the launched, both, or neither.
    bool fine_in_value() const;
    bool fine_in_launched() const;
    bool precise() const { return what->many || fine_in_value() || fine_in_launched(); }
    std::string precision() const;
};

/// One run of a case.
Estimate estimate_of(const Case& what, std::int64_t photons, std::uint64_t seed);

/// Runs one case to a standard error of 1e-3 of the value or 3e-4 of the launched, whichever is larger: a short run
/// tells how many photons that takes, another with other random numbers is the result (with more of them, should its
/// standard error still be too large).
Outcome run(const Case& what, std::uint64_t seed);

std::vector<Case> slab_cases();
std::vector<Case> geometry_cases();
std::vector<Case> fluorescence_cases();
std::vector<Case> layer_cases();
std::vector<Case> body_cases();
std::vector<Case> ray_cases();
/// Plots that cases make on the way, by file name.
using PlotBook = std::vector<std::pair<std::string, Plot>>;
std::vector<Case> cache_cases(const std::shared_ptr<PlotBook>& plots);
std::vector<Case> image_cases(const std::shared_ptr<PlotBook>& plots);
std::vector<Case> figure_cases(const std::shared_ptr<PlotBook>& plots);

/// A half space of equal optics at both wavelengths, where fluorescence is extra albedo.
Case cascade_case(double scattering, double dye, double yield, std::optional<int> orders, double expected);
/// Watts of a clear cuvette with the energy that photons lose (Stokes), or without.
Case watts_case(bool with_stokes);
/// Of the wide slab of voxels: absorbed (0) or reflected.
Case voxel_slab(const std::string& name, double angle, double majorant_factor, std::size_t measure);

/// The same cases with a mistake of one per cent or a term left out in the scene: each must miss its reference.
std::vector<Case> broken_cases();

/// A probability as the deviation of a normal distribution that has it (above zero: unlikely large), for tests of many
/// values at once; compare with 0, standard error 1.
Estimate deviation_of(double chi_squared, double degrees_of_freedom);
/// The same for the largest of many |t| of Student's distribution.
Estimate deviation_of_largest(double t, double count, double degrees_of_freedom);
/// Mean and standard error of runs with seeds of their own.
Estimate mean_of_runs(int runs, std::uint64_t seed, const std::function<double(std::uint64_t)>& run);
/// The same for runs that use one thread each: as many at once as there are cores.
Estimate mean_of_runs_at_once(int runs, std::uint64_t seed, const std::function<double(std::uint64_t)>& run);

// Scenes of one light; lengths in micrometres stand for any unit.
Light normal_pencil(Vec3 position, Vec3 direction = {0, 0, 1});
/// Lambertian light on the face z = 0 of a slab, from below, over a small square.
Light lambertian_below();
Scene scene_of(std::vector<SceneMedium> media, Light light);

/// Rows of a table in tests/reference without its comments; the first is its header.
std::vector<std::vector<std::string>> load_reference(const std::string& file);

// What is measured.
std::function<Estimate(const FluenceResult&)> leaves(int face);  ///< not specular
std::function<Estimate(const FluenceResult&)> fluorescence_leaves(int face);
std::function<Estimate(const FluenceResult&)> absorbed_by(std::size_t medium);

}  // namespace fluovox::validation
