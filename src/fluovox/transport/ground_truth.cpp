#include "fluovox/transport/ground_truth.h"

#include "fluovox/core/rng.h"
#include "fluovox/optics/light_sampling.h"
#include "fluovox/scene/stack.h"
#include "fluovox/transport/optical_field.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace fluovox {

/// The voxels of one plane in space.
struct GroundTruth::Lattice {
    Vec3 corner;                 // of the top left pixel, in the plane's middle
    Vec3 across, down, through;  // one pixel, one pixel, one step
    int width = 0;

    /// `x`, `y`, `z` within the voxel of a pixel, 0 to 1.
    Vec3 point(std::size_t pixel, double x, double y, double z) const {
        const std::size_t column = pixel % static_cast<std::size_t>(width);
        const std::size_t row = pixel / static_cast<std::size_t>(width);
        return corner + (static_cast<double>(column) + x) * across + (static_cast<double>(row) + y) * down +
               (z - 0.5) * through;
    }
};

namespace {

StackInfo derived(const StackInfo& stack, const std::string& quantity, const std::string& unit) {
    StackInfo info = stack;
    info.quantity = quantity;
    info.unit = unit;
    info.type = SampleType::Float32;
    info.value_per_count = 1;
    info.max_value = 0;
    info.channels.clear();
    return info;
}

StackChannel channel_named(const std::string& name) {
    StackChannel channel;
    channel.name = name;
    return channel;
}

/// Runs `value(pixel)` for all pixels.
template <class Value>
void fill(std::span<float> values, const Value& value) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, values.size(), 256), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
            values[i] = static_cast<float>(value(i));
    });
}

double wavelength_of(const Light& light) {
    if (!light.spectrum.lines.empty()) return light.spectrum.lines.front().wavelength_nm;
    return light.spectrum.energy_per_nm.peak_nm();
}

}  // namespace

GroundTruth::GroundTruth(const Scene& scene, int view) : scene_(&scene), view_(view) {
    double voxel_um = 0;
    for (std::size_t i = 0; i < scene.media.size(); ++i) {
        const SceneMedium& medium = scene.media[i];
        const MediumDescription& description = scene.description.media[i];
        label_fields_.emplace_back();
        if (medium.dye < 0 || !medium.grid) continue;
        label_fields_.back() = LabelField::load(description.grid->file, description.grid->um_per_length.value_or(1));
        const Affine& affine = medium.grid->world_from_index();
        const double size = length({affine.rows[0].x, affine.rows[1].x, affine.rows[2].x});
        voxel_um = voxel_um > 0 ? std::min(voxel_um, size) : size;
    }
    const Camera& camera = scene.description.camera;
    constexpr int kFinest = 4;
    if (voxel_um > 0 && camera.kind == Camera::Kind::Telecentric) {
        const double voxels = camera.field_um / camera.height / voxel_um;
        fineness_ = std::clamp(static_cast<int>(std::ceil(voxels)), 2, kFinest);
    }
    const std::vector<LightDescription>& lights = scene.description.lights;
    for (std::size_t table = 0; table < lights.size(); ++table) {
        if (!std::holds_alternative<UniformLight>(lights[table].light.shape))
            lit_by_.push_back(static_cast<int>(table));
    }
}

GroundTruth::Lattice GroundTruth::lattice(int plane) const {
    const Camera camera = scene_at(*scene_, view_, plane).description.camera;
    const Camera next = scene_at(*scene_, view_, plane + 1).description.camera;
    const Vec3 axis = normalized(camera.target - camera.position);
    const Vec3 right = normalized(cross(axis, camera.up));
    const Vec3 up = cross(right, axis);
    const double pixel = pixel_um(camera);
    Lattice lattice;
    lattice.across = pixel * right;
    lattice.down = -pixel * up;
    lattice.through = next.position - camera.position;
    lattice.corner = camera.position + camera.focus_um * axis - (0.5 * camera.width) * lattice.across -
                     (0.5 * camera.height) * lattice.down;
    lattice.width = camera.width;
    return lattice;
}

int GroundTruth::label_at(Vec3 position_um) const {
    int number = 0;
    int found = 0;
    for (std::size_t i = 0; i < scene_->media.size(); ++i) {
        const SceneMedium& medium = scene_->media[i];
        if (medium.dye < 0) continue;
        ++number;
        if (label_fields_[i]) {
            const int label = label_fields_[i]->at(position_um);
            if (label != 0) found = label;
        } else if (medium.grid ? medium.grid->trilinear(position_um) >= 0.5 * medium.grid->max()
                               : contains(medium.region, position_um)) {
            found = number;
        }
    }
    return found;
}

StackInfo GroundTruth::labels_info(const StackInfo& stack) {
    StackInfo info = derived(stack, "labels", "");
    info.channels = {channel_named("labels")};
    info.type = SampleType::UInt16;
    info.max_value = 65535;
    return info;
}

void GroundTruth::labels(int plane, std::span<float> values) const {
    const Lattice at = lattice(plane);
    fill(values, [&](std::size_t i) { return static_cast<double>(label_at(at.point(i, 0.5, 0.5, 0.5))); });
}

double GroundTruth::concentration_at(int dye, Vec3 position_um) const {
    double uM = 0;
    for (const SceneMedium& medium : scene_->media) {
        if (medium.dye != dye) continue;
        if (medium.grid) {
            if (medium.grid->bounds().contains(position_um) || medium.grid->background() > 0)
                uM += medium.grid->trilinear(position_um);
            continue;
        }
        const bool replaced = std::any_of(medium.cut_by.begin(), medium.cut_by.end(), [&](int other) {
            return contains(scene_->media[static_cast<std::size_t>(other)].region, position_um);
        });
        if (!replaced && contains(medium.region, position_um)) uM += medium.amount;
    }
    return uM;
}

StackInfo GroundTruth::concentration_info(const StackInfo& stack) const {
    StackInfo info = derived(stack, "concentration", "umol/L");
    for (const Dye& dye : scene_->dyes) {
        info.channels.push_back(channel_named(dye.name));
        info.channels.back().dye = dye.name;
    }
    for (const SceneMedium& medium : scene_->media) {
        if (medium.dye >= 0)
            info.max_value = std::max(info.max_value, medium.grid ? medium.grid->max() : medium.amount);
    }
    return info;
}

void GroundTruth::concentration(int plane, int dye, std::span<float> values) const {
    const Lattice at = lattice(plane);
    const int n = fineness_;
    fill(values, [&](std::size_t i) {
        double sum = 0;
        for (int s = 0; s < n * n * n; ++s) {
            const auto middle = [n](int k) { return (k + 0.5) / n; };
            sum += concentration_at(dye, at.point(i, middle(s % n), middle(s / n % n), middle(s / n / n)));
        }
        return sum / (n * n * n);
    });
}

StackInfo GroundTruth::irradiance_info(const StackInfo& stack) const {
    StackInfo info = derived(stack, "irradiance", "W/mm2");
    for (const int light : lit_by_) {
        const double nm = wavelength_of(scene_->description.lights[static_cast<std::size_t>(light)].light);
        info.channels.push_back(channel_named(fmt::format("light {} ({:.4g} nm)", light + 1, nm)));
        info.channels.back().excitation_nm = nm;
    }
    return info;
}

void GroundTruth::irradiance(int plane, int channel, std::span<float> values) const {
    constexpr int kSamples = 16;  // directions of a focused light, walks through grids
    constexpr double kPerMm2 = 1e6;
    const Lattice at = lattice(plane);
    const Scene here = scene_at(*scene_, view_, plane);
    const int table = lit_by_[static_cast<std::size_t>(channel)];
    std::vector<Light> parts;
    for (std::size_t l = 0; l < here.lights.size(); ++l) {
        if (here.light_tables[l] == table) parts.push_back(here.lights[l]);
    }
    tbb::enumerable_thread_specific<OpticalField> fields([&] { return OpticalField(here); });
    const PathOptics optics = fields.local().optics(Wavelengths::one(wavelength_of(parts.front())));
    fill(values, [&](std::size_t i) {
        OpticalField& field = fields.local();
        Rng rng(here.description.render.seed, i, 0x4952524144ULL);
        const Vec3 p = at.point(i, 0.5, 0.5, 0.5);
        std::vector<MediumSpan> spans;
        double W_per_um2 = 0;
        for (const Light& light : parts) {
            double sum = 0;
            for (int s = 0; s < kSamples; ++s) {
                const double u = (s + rng.uniform()) / kSamples;
                const auto sample = sample_light(light, p, u, rng.uniform());
                if (!sample) continue;
                const Ray ray{p, sample->to_light};
                field.gather(ray, spans);
                sum += sample->fluence_per_um2 *
                       field.transmittance(ray, spans, sample->distance_um, optics, Loss::Extinction, rng)[0];
            }
            W_per_um2 += light.power_W * sum / kSamples;
        }
        return kPerMm2 * W_per_um2;
    });
}

}  // namespace fluovox
