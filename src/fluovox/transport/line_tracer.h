#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/optics/light_sampling.h"
#include "fluovox/scene/scene.h"
#include "fluovox/transport/optical_field.h"
#include "fluovox/volume/shadow_grid.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace fluovox {

class PathRecord;
class ShadowGuess;
class WeightWindow;
struct PathTask;

/// What the media and lights of a scene do at one wavelength, so that the steps of a path need not look at those that
/// do nothing.
struct LinePlan {
    /// A grid that is tracked with a coefficient, per um and unit of its value; what a collision with it leaves.
    struct TrackedGrid {
        int medium = 0;
        double coefficient = 0;
        double left = 1;
    };
    struct ShiningLight {
        std::size_t index = 0;
        double photons = 0;
        const ShadowGuess* guess = nullptr;  ///< of what gets to where the tracked grid scatters; or null
    };

    const PathOptics* optics = nullptr;
    std::vector<TrackedGrid> scattering, absorbing, dimming;
    std::vector<ShiningLight> lights;
    const WeightWindow* window = nullptr;  ///< where there are guesses; or null
    bool is_thick = false;                 ///< light is likely to be scattered on its way through all of the scene
    bool seeks_sections = false;           ///< some light is worth looking for along a ray
    double dim_later = 1;                  ///< see RatioTracking; of transmittances behind a path's first vertex
};

/// Elastic light of one wavelength along a ray: what PathTracer does, without what only spectra need. Absorption by
/// grids that mostly scatter is a factor at each collision, so one walk serves both; that of other grids is tracked, of
/// constant media exact. Light that shines on all there is is only looked for where paths scatter, as a point drawn
/// along the ray would seldom be better.
class LineTracer {
public:
    LineTracer(const Scene& scene, OpticalField& field);

    /// The plan of a task's first wavelength; its optics must outlive it.
    void make_plan(const PathTask& task, LinePlan& plan) const;

    /// Photons s^-1 um^-2 sr^-1 that arrive along `ray`, scattered so many times at most, unbiased; no conversions.
    /// `pdf_per_sr`: see PathTask::pdf_start_per_sr.
    double radiance(const Ray& ray, const LinePlan& plan, int scatterings, double pdf_per_sr, Rng& rng);
    /// The same of a ray from the camera, with the course of the path.
    double record(const Ray& ray, const LinePlan& plan, int scatterings, Rng& rng, PathRecord& record);

    /// How a light of the plan shines wherever paths scatter, where that is the same all over and where light is looked
    /// for there alone; or null.
    const LightSample* even_light(const LinePlan::ShiningLight& light, const LinePlan& plan) const {
        const std::optional<LightSample>& even = even_[light.index];
        return plan.is_thick && even ? &*even : nullptr;
    }

private:
    // Where a stretch ends: the medium that scatters there, or -1; what absorption on the way leaves; the voxel of its
    // grid.
    struct Flight {
        double t_um = 0;
        int medium = -1;
        double left = 1;
        Voxel voxel;
    };
    struct Path {
        Ray ray;
        double pdf_per_sr = 0;  // of the direction, where lights were sampled from the same point; else 0
        double dim = kDim;      // for its transmittances: see RatioTracking
        double beta = 1;        // what light at its origin is worth
    };
    // Light that is scattered at a vertex, once it is known how much of it gets there.
    struct Awaited {
        const ShadowGuess* guess = nullptr;
        ShadowGrid::Place place;
        Ray ray;           // to the light
        double worth = 0;  // of all of it
    };

    static constexpr double kDim = 0.1;

    template <class Record>
    double follow(Path path, const LinePlan& plan, int scatterings, Rng& rng, Record& record);
    bool is_thick(const PathOptics& optics) const;
    bool find_lit_sections(const Ray& ray, const LinePlan& plan);
    double lit_pdf(std::size_t light, double t_um) const;
    Flight fly(const Ray& ray, const LinePlan& plan, Rng& rng);
    double absorption_left(const Ray& ray, double end_um, const LinePlan& plan, Rng& rng);
    double transmittance(const Ray& ray, const std::vector<MediumSpan>& spans, double end_um, double dim,
                         const LinePlan& plan, Rng& rng);
    double track_through(const std::vector<LinePlan::TrackedGrid>& grids, const Ray& ray, double end_um, double depth,
                         double dim, Rng& rng);
    void await(const Path& path, const Flight& flight, Vec3 position, const LinePlan::ShiningLight& shining,
               double worth, const LinePlan& plan);
    double add_awaited(const LinePlan& plan, Rng& rng);
    double shadow(Vec3 position, const LightSample& light, double dim, const LinePlan& plan, Rng& rng);
    double scattering_density(const Ray& ray, double t_um, const LinePlan& plan) const;
    double seen_along(const Path& path, bool may_scatter, const LinePlan& plan, Rng& rng);
    double from_rectangles(const Path& path, const LinePlan& plan, Rng& rng);
    double from_surround(const Path& path, const LinePlan& plan, Rng& rng);
    double scattered_once(const Path& path, const LinePlan& plan, Rng& rng);
    double scattered_here(const Path& path, const Flight& flight, const LinePlan& plan, Rng& rng);
    void turn(Path& path, const Flight& flight, Rng& rng) const;

    const Scene* scene_;
    OpticalField* field_;
    bool has_rectangles_ = false, has_surround_ = false;
    // Per light: how it shines everywhere where there are media, where that is the same all over.
    std::vector<std::optional<LightSample>> even_;
    double size_um_ = 0;  // diagonal of the box of all media
    // Along the ray of a path.
    std::vector<MediumSpan> spans_, shadow_spans_;
    std::vector<LitSection> lit_;
    std::size_t sections_ = 0;
    std::vector<Lanes> by_medium_;
    std::vector<Awaited> awaited_;
};

}  // namespace fluovox
