#pragma once

#include "fluovox/core/bounds.h"
#include "fluovox/core/vec.h"
#include "fluovox/scene/scene.h"
#include "fluovox/volume/region.h"

#include <cstdint>
#include <vector>

namespace fluovox {

/// Which of the scene's surfaces a photon is inside of, one bit each. It is carried along and changed where a surface
/// is crossed, never found again from the position, so rounding cannot put a photon on the wrong side.
using Inside = std::uint64_t;

/// The regions of a scene as closed surfaces between which media and refractive index are constant.
class PhotonSpace {
public:
    static constexpr int kMaxSurfaces = 64;
    /// Surfaces nearer to each other than this are one: the faces of stacked layers.
    static constexpr double kSame_um = 1e-6;

    /// Throws SceneError where regions of different refractive index overlap in part, or there are too many regions.
    explicit PhotonSpace(const Scene& scene);

    struct Crossing {
        double t_um = 0;  ///< infinite: there is none ahead
        Inside changed = 0;
    };

    /// Where a photon that sets out along `ray` is. On a surface it counts as where it comes from: a beam that starts
    /// on a face enters through it.
    Inside inside_at(const Ray& ray) const;
    /// The next surface, or several that coincide.
    Crossing next_crossing(const Ray& ray, Inside inside) const;
    /// A distance within which there is no surface in any direction; infinite where there are none.
    double clearance(Vec3 position_um) const;
    /// Unit normal of the surfaces crossed.
    Vec3 normal(Inside changed, Vec3 position_um) const;
    /// That of the innermost region that has one; 1 outside.
    double refractive_index(Inside inside) const;
    /// The constant media there, without those that others replace.
    std::vector<int> media(Inside inside) const;

    bool refracts() const { return refracts_; }
    /// The box around all regions and grids; infinite where they are.
    const Bounds& bounds() const { return bounds_; }

private:
    struct Surface {
        Region region;
        int medium = 0;
        double index = 0;   // 0: it has none
        double volume = 0;  // to tell the inner from the outer
        bool constant = true;
    };

    void add(const Scene& scene, std::size_t i);
    void require_nested(const Scene& scene) const;
    static bool is_inner(const Surface& a, const Surface& b);

    const Scene* scene_;
    std::vector<Surface> surfaces_;
    Inside everywhere_ = 0;
    bool refracts_ = false;
    Bounds bounds_;
};

/// Share of unpolarized light that is reflected where it meets, from index n1 and at cosine `cosine` to the normal, a
/// surface to index n2 (Fresnel's equations; Born & Wolf, Principles of Optics, 1.5.2). 1: total reflection.
/// `transmitted_cosine` becomes the cosine behind the surface.
double fresnel_reflectance(double n1, double n2, double cosine, double& transmitted_cosine);

}  // namespace fluovox
