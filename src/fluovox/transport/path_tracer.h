#pragma once

#include "fluovox/core/rng.h"
#include "fluovox/core/vec.h"
#include "fluovox/optics/light_sampling.h"
#include "fluovox/scene/scene.h"
#include "fluovox/spectral/lanes.h"
#include "fluovox/transport/direction_lobes.h"
#include "fluovox/transport/illumination.h"
#include "fluovox/transport/line_tracer.h"
#include "fluovox/transport/optical_field.h"
#include "fluovox/transport/path_prepass.h"
#include "fluovox/transport/source_table.h"

#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace fluovox {

/// Radiance per wavelength of a path, photons s^-1 um^-2 sr^-1 (per nm where the wavelengths are a continuum).
struct PathRadiance {
    Lanes elastic;              ///< never converted
    std::vector<Lanes> by_dye;  ///< by the dye that converted it last

    Lanes converted() const;
};

/// What one stretch of a path, at fixed wavelengths, looks for.
struct PathTask {
    static constexpr int kNoLimit = std::numeric_limits<int>::max();

    const PathOptics* optics = nullptr;
    /// Photons of each light at the wavelengths; empty: light that was not converted is of no interest.
    std::vector<Lanes> light_photons;
    int orders = 0;               ///< conversions allowed
    int scatterings = kNoLimit;   ///< elastic events allowed, on this stretch and those it leads to
    double pdf_start_per_sr = 0;  ///< density the first direction was drawn with, where lights were also sampled; or 0
};

/// Light of a laser line that was not converted, all of it.
PathTask line_task(const Illumination::Line& line, const PathOptics& optics);

/// The unbiased reference estimator, from the camera backward. On each ray it adds up
/// - emitters hit (rectangles; uniform light where the path leaves),
/// - light of the sources scattered once on the way here: sampled at the path's own vertices and along the stretch that
///   each light shines on, combined by multiple importance sampling (Veach & Guibas 1995),
/// - conversion: a source term, not a collision, so that a clear dye glows without noise. Points are drawn where dye
/// may
///   be and where light shines; from each the path goes on at an excitation wavelength.
/// Conversion of the lights' photons is taken at the first ray, and once more at one of the later rays, drawn in
/// proportion to the dye seen; that of photons converted before at one of all rays, so that a cascade does not branch.
/// Several emission wavelengths share a path by spectral multiple importance sampling (Wilkie et al. 2014).
class PathTracer {
public:
    /// `prepass`, of this scene, must outlive it.
    PathTracer(const Scene& scene, const Illumination& illumination, const PathPrepass& prepass = {});

    /// One unbiased estimate of the radiance that arrives at the origin of `ray` from
    /// its direction.
    void estimate(const Ray& ray, const PathTask& task, Rng& rng, PathRadiance& result);

    PathTracer(const PathTracer&) = delete;
    PathTracer& operator=(const PathTracer&) = delete;

    /// The same of light of a laser line of `illumination` that was not converted, scattered so many times at most;
    /// photons s^-1 um^-2 sr^-1.
    double line_radiance(std::size_t line, const Ray& ray, int scatterings, Rng& rng) {
        return line_tracer_.radiance(ray, line_plans_[line], scatterings, 0, rng);
    }

    OpticalField& field() { return field_; }
    const Illumination& illumination() const { return *illumination_; }

private:
    // Storage of one level of recursion (a path that goes on at another wavelength is one level deeper).
    struct Level {
        std::vector<MediumSpan> spans, shadow_spans;
        std::vector<LitSection> lit;
        std::vector<Lanes> by_medium;
        std::vector<Lanes> emission;     // per dye: photons per nm at the wavelengths
        std::vector<double> brightness;  // per dye: excited how strongly, times the sum of its emission
        std::vector<double> uM, weights;
        SourceTable sources;
        PathOptics optics;  // of the wavelength the next level goes on with
        PathTask task;
        PathRadiance radiance;
    };

    // A ray of a path with what the path is worth at its origin.
    struct Stretch {
        Ray ray;
        Lanes beta;             // contribution over the mean density of all wavelengths
        Lanes density;          // each wavelength's own density over that mean
        int scatterings = 0;    // still allowed
        double pdf_per_sr = 0;  // of the ray's direction, where lights were also sampled; or 0
    };

    // Where a stretch is scattered, with the mean density of finding it there by the path's own ways.
    struct Vertex {
        Scattering at;
        double density = 0;  // per um; only where light is looked for
    };

    // Where dye glows on a stretch, with what its glow is worth to the path.
    struct GlowPoint {
        double t_um = 0;
        double density = 0;  // that it was drawn with, per um
        Lanes weight;
    };

    // One of many, drawn in proportion to the weights they come with (Chao, Biometrika 69 (1982) 653).
    template <class T>
    struct Drawn {
        T item;
        double weight = 0, all = 0;  // of this one; of all that were offered

        void offer(const T& candidate, double candidate_weight, Rng& rng) {
            if (!(candidate_weight > 0)) return;
            all += candidate_weight;
            if (rng.uniform() * all >= candidate_weight) return;
            item = candidate;
            weight = candidate_weight;
        }
    };

    // A path on its way, and stretches of it to come back to.
    struct Walk {
        Stretch stretch;
        bool is_first = true;
        Drawn<Stretch> later;  // where lights excite: of all stretches but the first
        Drawn<Stretch> any;    // where dyes excite: of all of them
    };

    void trace(const Ray& ray, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result);
    bool converts(const PathTask& task) const;
    void find_lights(const Walk& walk, const PathTask& task, Level& level) const;
    void convert_along(Walk& walk, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result);
    void weigh_dyes(const PathOptics& optics, Level& level) const;
    bool go_on(Stretch& path, const PathTask& task, Level& level, Rng& rng, PathRadiance& result);
    std::optional<Vertex> next_vertex(Stretch& path, const PathTask& task, Level& level, Rng& rng);
    bool revisit(Drawn<Stretch>& drawn, const PathTask& task, Level& level);

    void find_lit_sections(const Ray& ray, const PathTask* task, Level& level) const;
    static double lit_pdf(const Level& level, std::size_t light, double t_um);
    static std::optional<std::size_t> choose_lit_section(const Level& level, Rng& rng);

    void add_rectangles(const Stretch& path, const PathTask& task, Level& level, Rng& rng, PathRadiance& result);
    void add_scattered_once(const Stretch& path, const PathTask& task, Level& level, Rng& rng, PathRadiance& result);
    void add_lights_at(const Stretch& path, const Vertex& vertex, const PathTask& task, Level& level, Rng& rng,
                       PathRadiance& result);
    void add_surround(const Stretch& path, const PathTask& task, Level& level, Rng& rng, PathRadiance& result);
    Lanes transmittance_to_light(Vec3 position, const LightSample& light, const PathOptics& optics, Level& level,
                                 Rng& rng);

    // Conversion (conversion.cpp).
    void convert(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result);
    void convert_again(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng, PathRadiance& result);
    void convert_at_source(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng,
                           PathRadiance& result);
    void convert_where_lit(const Stretch& path, const PathTask& task, std::size_t depth, Rng& rng,
                           PathRadiance& result);
    std::optional<GlowPoint> sample_source(const Stretch& path, const PathTask& task, Level& level, Rng& rng);
    void excite_by_lights(const Stretch& path, const GlowPoint& point, std::size_t depth, Rng& rng,
                          PathRadiance& result);
    void excite_by_dyes(const Stretch& path, const GlowPoint& point, const PathTask& task, std::size_t depth, Rng& rng,
                        PathRadiance& result);
    Excitation excitation_by_dyes(const std::vector<double>& weights, Rng& rng) const;
    bool find_dye(const Stretch& path, double t_um, Level& level, Rng& rng);
    double direct_fluence(Vec3 position, std::size_t light, const Excitation& excitation, const PathOptics& optics,
                          Level& level, Rng& rng);
    void add_glow(const Lanes& weight, double wavelength_nm, double fluence, const Level& level, PathRadiance& result);
    const PathOptics& excitation_optics(const Excitation& excitation, Level& level) const;

    Level& level(std::size_t depth);

    const Scene* scene_;
    const Illumination* illumination_;
    OpticalField field_;
    LineTracer line_tracer_;               // elastic light of one wavelength
    std::vector<PathOptics> line_optics_;  // per laser line
    std::vector<LinePlan> line_plans_;
    LinePlan plan_;                                  // of another wavelength
    std::vector<std::vector<Spectrum>> dye_to_dye_;  // [absorber][emitter]: emission x absorption, to draw from
    // Excitation that was scattered forward still comes more or less from where a collimated light shines: paths that
    // look for it set out there more often than elsewhere.
    std::vector<DirectionLobe> lobes_;
    bool has_far_lights_ = false;  // lights that a ray can run into: uniform or rectangle
    std::vector<std::unique_ptr<Level>> levels_;
};

}  // namespace fluovox
