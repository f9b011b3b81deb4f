#include "fluovox/scene/stack.h"

#include "fluovox/core/rng.h"

#include <cmath>
#include <cstdint>
#include <variant>

namespace fluovox {
namespace {

/// A turn about an axis through a point, then a shift.
class Motion {
public:
    Motion(const StackDescription::Views& views, double angle_rad, Vec3 along, double offset_um)
        : axis_(views.axis), center_(views.center), cosine_(std::cos(angle_rad)), sine_(std::sin(angle_rad)) {
        if (angle_rad == 0) {  // exactly as written
            cosine_ = 1;
            sine_ = 0;
        }
        shift_ = offset_um * direction(along);
    }

    /// Rodrigues' formula.
    Vec3 direction(Vec3 v) const {
        if (sine_ == 0 && cosine_ == 1) return v;
        return cosine_ * v + sine_ * cross(axis_, v) + ((1 - cosine_) * dot(axis_, v)) * axis_;
    }
    Vec3 point(Vec3 p) const {
        if (sine_ == 0 && cosine_ == 1) return p + shift_;
        return center_ + direction(p - center_) + shift_;
    }

    void operator()(SheetLight& sheet) const {
        sheet.position = point(sheet.position);
        sheet.waist = point(sheet.waist);
        sheet.direction = direction(sheet.direction);
        sheet.normal = direction(sheet.normal);
    }
    void operator()(BeamLight& beam) const {
        beam.position = point(beam.position);
        beam.waist = point(beam.waist);
        beam.direction = direction(beam.direction);
    }
    template <class Other>
    void operator()(Other& /*stays*/) const {}

private:
    Vec3 axis_, center_, shift_;
    double cosine_, sine_;
};

}  // namespace

int plane_count(const StackDescription& stack) {
    constexpr double kRounding = 1e-6;  // 20 um in steps of 0.1 um are 200 steps
    return 1 + static_cast<int>(std::floor((stack.stop_um - stack.start_um) / stack.step_um + kRounding));
}

double plane_offset_um(const StackDescription& stack, int plane) {
    return stack.start_um + plane * stack.step_um;
}

Scene scene_at(const Scene& scene, int view, int plane) {
    Scene moved = scene;
    SceneDescription& description = moved.description;
    const StackDescription stack = *description.stack;
    description.stack.reset();
    const Motion motion(stack.views, stack.views.angles_rad[static_cast<std::size_t>(view)], stack.along,
                        plane_offset_um(stack, plane));
    Camera& camera = description.camera;
    camera.position = motion.point(camera.position);
    camera.target = motion.point(camera.target);
    camera.up = motion.direction(camera.up);
    for (LightDescription& light : description.lights)
        std::visit(motion, light.light.shape);
    for (Light& light : moved.lights)
        std::visit(motion, light.shape);
    Rng rng(description.render.seed, static_cast<std::uint64_t>(view), static_cast<std::uint64_t>(plane));
    description.render.seed = static_cast<std::uint64_t>(0x1.0p53 * rng.uniform());
    return moved;
}

}  // namespace fluovox
