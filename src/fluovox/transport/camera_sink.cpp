#include "fluovox/transport/camera_sink.h"

#include "fluovox/transport/film_layers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

namespace fluovox {

CameraSink::CameraSink(const Scene& scene, double photons_per_s)
    : scene_(&scene),
      camera_(scene.description.camera),
      response_(scene.description.film, scene.description.render.filter),
      field_(scene),
      photons_per_s_(photons_per_s),
      channels_(scene.description.film.channels.size()),
      layers_(count_film_layers(scene)),
      of_one_(channels_),
      per_dye_(scene.description.film.per_dye) {
    for (const SceneMedium& medium : scene.media)
        g_ = std::max(g_, mean_cosine(medium.phase));
}

std::span<const DirectionLobe> CameraSink::lobes(const Photon& photon) const {
    if (!seen_ || !(g_ > 0)) return {};
    const Vec3 axis = camera_.to_camera(photon.ray.origin);
    lobes_ = {DirectionLobe{axis, g_}, DirectionLobe{axis, g_ * g_ * g_}};
    return lobes_;
}

void CameraSink::start(const Photon& photon, const Light& light, Rng& rng) {
    rng_ = &rng;
    set_wavelength(photon);
    if (!seen_) return;
    if (const auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
        connect_surface(photon, rectangle->normal);
    } else if (!std::holds_alternative<PointLight>(light.shape)) {
        if (const auto hit = camera_.catch_ray(photon.ray)) add(photon, photon.ray.origin, *hit, hit->factor);
    }
}

void CameraSink::finish(Splats& splats, Order order) {
    if (order == Order::AsItWas) {
        splats.insert(splats.end(), splats_.begin(), splats_.end());
        splats_.clear();
        return;
    }
    std::stable_sort(splats_.begin(), splats_.end(), [](const Splat& a, const Splat& b) { return a.at < b.at; });
    const std::size_t first = splats.size();
    for (std::size_t i = 0; i < splats_.size();) {
        Splat sum = splats_[i];
        for (++i; i < splats_.size() && splats_[i].at == sum.at; ++i)
            sum.value += splats_[i].value;
        sum.begins_photon = splats.size() == first;
        sum.begins_layer = sum.begins_photon || splats.back().at / channels_ != sum.at / channels_;
        splats.push_back(sum);
    }
    splats_.clear();
}

void CameraSink::vertex(const Photon& photon, int medium) {
    if (!seen_) return;
    const PhaseFunction& phase = scene_->media[static_cast<std::size_t>(medium)].phase;
    connect(photon, [&](Vec3 to_camera) { return phase_per_sr(phase, dot(photon.ray.direction, to_camera)); });
}

void CameraSink::emission(const Photon& photon) {
    set_wavelength(photon);
    if (seen_) connect(photon, [](Vec3 /*to_camera*/) { return 1 / (4 * std::numbers::pi); });
}

// Through several points of the aperture where that makes an image of several pixels: so the light of one photon is
// spread over them. `per_sr`: of direction.
template <class PerSr>
void CameraSink::connect(const Photon& photon, const PerSr& per_sr) {
    constexpr double kMost = 16;
    const double connections = std::floor(std::min(kMost, camera_.pixels_covered(photon.ray.origin)));
    for (int i = 0; i < static_cast<int>(connections); ++i) {
        const auto hit = camera_.connect(photon.ray.origin, *rng_);
        if (hit) add(photon, photon.ray.origin, *hit, per_sr(hit->to_camera) * hit->factor / connections);
    }
}

void CameraSink::set_wavelength(const Photon& photon) {
    seen_ = response_.sees(photon.wavelength_nm);
    const Wavelengths& set = optics_.wavelengths;
    if (!seen_ || (set.count() > 0 && photon.wavelength_nm == set.nm[0])) return;
    field_.set_optics(Wavelengths::one(photon.wavelength_nm), optics_);
    std::fill(of_one_.begin(), of_one_.end(), 0);
    response_.add(photon.wavelength_nm, photons_per_s_, of_one_);
}

// Lambertian light as it leaves its surface.
void CameraSink::connect_surface(const Photon& photon, Vec3 normal) {
    connect(photon, [&](Vec3 to_camera) { return std::max(0.0, dot(normal, to_camera)) / std::numbers::pi; });
}

void CameraSink::add(const Photon& photon, Vec3 from, const CameraConnection& hit, double factor) {
    if (!(factor > 0)) return;
    const Ray ray{from, hit.to_camera};
    field_.gather(ray, spans_);
    const double passed = field_.transmittance(ray, spans_, hit.distance_um, optics_, Loss::Extinction, *rng_)[0];
    if (!(passed > 0)) return;
    const double photons = photon.weight * factor * passed;
    const std::size_t pixel =
        static_cast<std::size_t>(hit.y) * static_cast<std::size_t>(scene_->description.camera.width) +
        static_cast<std::size_t>(hit.x);
    const bool converted = photon.order > 0;
    for (std::size_t c = 0; c < channels_; ++c) {
        const double value = photons * of_one_[c];
        if (value == 0) continue;
        const auto splat = [&](std::size_t layer) {
            splats_.push_back({pixel * values_per_pixel() + layer * channels_ + c, value});
        };
        splat(0);
        if (layers_ > 1) splat(converted ? kFluorescencePlace : kElasticPlace);
        if (converted && per_dye_) splat(kFirstDyePlace + static_cast<std::size_t>(photon.dye));
    }
}

}  // namespace fluovox
