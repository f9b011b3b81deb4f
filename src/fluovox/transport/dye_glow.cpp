#include "fluovox/transport/dye_glow.h"

#include "fluovox/optics/light_sampling.h"
#include "fluovox/transport/film_response.h"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace fluovox {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};

// Places a photon may choose among: more make the choice better, and cost time.
constexpr double kPlacesPerPhoton = 4;

// Beside the film a place may still shine onto it, by way of scattering or through another part of the aperture.
constexpr double kOutOfView = 0.1;

std::uint64_t mask_word(const VoxelLattice& lattice, std::size_t brick, std::size_t word) {
    return lattice.masks.empty() ? kAll : lattice.masks[brick][word];
}

}  // namespace

DyeGlow::DyeGlow(const Scene& scene, const PhotonSpace& space, const Illumination& illumination,
                 const ExcitationCache& cache)
    : scene_(&scene), space_(&space), illumination_(&illumination), cache_(&cache), camera_(scene.description.camera) {
    const FilmResponse film(scene.description.film, scene.description.render.filter);
    OpticalField field(scene);
    Rng rng(scene.description.render.seed, 0, 0);
    for (std::size_t d = 0; d < scene.dyes.size(); ++d) {
        const Dye& dye = scene.dyes[d];
        seen_emission_.push_back(film.seen_part(dye.emission_per_nm));
        std::vector<double> weights(scene.dyes.size());
        weights[d] = 1;
        auto& lights = direct_.emplace_back(scene.lights.size());
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            if (!cache.leaves_out_direct(l)) continue;
            const auto excitation = illumination.sample(weights, static_cast<int>(l), rng);
            if (!excitation) continue;
            lights[l] = {illumination.uptake(static_cast<int>(l), static_cast<int>(d)),
                         field.optics(Wavelengths::one(excitation->wavelength_nm))};
        }
    }
    for (std::size_t m = 0; m < scene.media.size(); ++m) {
        const int dye = scene.media[m].dye;
        if (dye < 0 || !(seen_emission_[static_cast<std::size_t>(dye)].integral() > 0)) continue;
        Source source;
        source.medium = m;
        source.dye = static_cast<std::size_t>(dye);
        source.lattice = &cache.lattice(m);
        source.volume_um3 = source.lattice->voxel_volume_um3();
        source.weights.assign(scene.dyes.size(), 0);
        source.weights[source.dye] = scene.dyes[source.dye].quantum_yield;
        source.first = {0};
        for (std::size_t brick = 0; brick < source.lattice->bricks.size(); ++brick) {
            int voxels = 0;
            for (std::size_t word = 0; word < 8; ++word)
                voxels += std::popcount(mask_word(*source.lattice, brick, word));
            source.first.push_back(source.first.back() + voxels);
        }
        if (source.weights[source.dye] > 0) sources_.push_back(std::move(source));
    }
}

void DyeGlow::place(std::uint64_t batch, std::int64_t photons, const Progress& progress) {
    struct Block {
        const Source* source;
        std::size_t first, last;
        std::vector<Place> places;
    };
    constexpr std::size_t kBricks = 16;
    std::vector<Block> blocks;
    std::int64_t voxels = 0;
    for (const Source& source : sources_) {
        const std::size_t bricks = source.lattice->bricks.size();
        for (std::size_t first = 0; first < bricks; first += kBricks)
            blocks.push_back({&source, first, std::min(bricks, first + kBricks), {}});
        voxels += source.first.back();
    }
    Rng rng(scene_->description.render.seed, ~batch, 0);
    const double wanted = kPlacesPerPhoton * static_cast<double>(std::max<std::int64_t>(1, photons));
    const Draw draw{batch, std::max(1.0, static_cast<double>(voxels) / wanted), rng.uniform()};
    offset_ = rng.uniform();
    tbb::enumerable_thread_specific<OpticalField> fields([&] { return OpticalField(*scene_); });
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 1), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end() && !progress.stopped(); ++i) {
            Block& block = blocks[i];
            for (std::size_t brick = block.first; brick < block.last; ++brick)
                add_places(*block.source, brick, draw, fields.local(), block.places);
        }
    });
    places_.clear();
    if (progress.stopped()) return;
    double total = 0;
    for (const Block& block : blocks) {
        for (Place place : block.places) {
            place.likely = total += place.likely;
            places_.push_back(place);
        }
    }
}

// Where the cache holds something there is a place for that; and one voxel in `one_in` gets a place for light straight
// from the lights, which then stands for so many.
void DyeGlow::add_places(const Source& source, std::size_t brick, const Draw& draw, OpticalField& field,
                         std::vector<Place>& places) const {
    const auto index = static_cast<std::size_t>(&source - sources_.data());
    std::vector<MediumSpan> spans;
    Cell cell{brick, 0, source.first[brick]};
    for (std::size_t word = 0; word < 8; ++word) {
        for (std::uint64_t left = mask_word(*source.lattice, brick, word); left != 0; left &= left - 1, ++cell.number) {
            cell.in_brick = static_cast<int>(word) * 64 + std::countr_zero(left);
            const double cached = cache_->absorbed_per_s(source.medium, brick, cell.in_brick);
            const double begin = static_cast<double>(cell.number) / draw.one_in + draw.offset;
            const bool straight = std::floor(begin) != std::floor(begin + 1 / draw.one_in);
            if (!straight && !(cached > 0)) continue;
            Rng rng(scene_->description.render.seed, ~draw.batch,
                    static_cast<std::uint64_t>(cell.number) << 8U | (index + 1));
            Place place;
            place.source = index;
            place.position = position_in(source, brick, cell.in_brick, rng);
            if (cached > 0) {
                place.brick = static_cast<std::uint32_t>(brick);
                place.in_brick = cell.in_brick;
                place.absorbed_per_s = cached;
                place.likely = use_of(source, place.position, rng) * cached;
                places.push_back(place);
            }
            if (!straight) continue;
            place.absorbed_per_s = -1;
            place.uM = dye_uM(*scene_, source.medium, place.position);
            if (!(place.uM > 0)) continue;
            place.volume_um3 = source.volume_um3 * draw.one_in;
            place.likely = use_of(source, place.position, rng) * place.uM * place.volume_um3 *
                           likely_direct(source, place.position, field, spans);
            if (place.likely > 0) places.push_back(place);
        }
    }
}

// One of a few places in a voxel, drawn in proportion to the dye there.
Vec3 DyeGlow::position_of_dye(const Source& source, std::size_t brick, int in_brick, Rng& rng) const {
    constexpr int kTries = 8;
    Vec3 chosen;
    double sum = 0;
    for (int i = 0; i < kTries; ++i) {
        const Vec3 position = position_in(source, brick, in_brick, rng);
        const double uM = tapped_dye_uM(*scene_, source.medium, position, rng);
        sum += uM;
        if (i == 0 || rng.uniform() * sum < uM) chosen = position;
    }
    return chosen;
}

Vec3 DyeGlow::position_in(const Source& source, std::size_t brick, int in_brick, Rng& rng) {
    const Voxel origin = source.lattice->bricks[brick];
    const double u = rng.uniform();
    const double v = rng.uniform();
    return source.lattice->world_from_index.point({origin.x + (in_brick >> 6) + u - 0.5,
                                                   origin.y + (in_brick >> 3 & 7) + v - 0.5,
                                                   origin.z + (in_brick & 7) + rng.uniform() - 0.5});
}

// About how much of what is absorbed here the camera can see.
double DyeGlow::use_of(const Source& source, Vec3 position_um, Rng& rng) const {
    const double seen = seen_emission_[source.dye].integral() * scene_->dyes[source.dye].quantum_yield;
    return seen * (camera_.connect(position_um, rng) ? 1 : kOutOfView);
}

// About what `direct` will find on average: regions take their part of the light, grids do not.
double DyeGlow::likely_direct(const Source& source, Vec3 position_um, OpticalField& field,
                              std::vector<MediumSpan>& spans) const {
    constexpr double kDarkest = 30;  // nothing is seen there, but all must stay possible
    double rate = 0;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        const Direct& direct = direct_[source.dye][l];
        if (!(direct.uptake > 0)) continue;
        const auto light = sample_light(scene_->lights[l], position_um, 0.5, 0.5);
        if (!light) continue;
        field.gather({position_um, light->to_light}, spans);
        const double depth = std::min(kDarkest, hero_depth(spans, direct.optics, light->distance_um));
        rate += direct.uptake * light->fluence_per_um2 * std::exp(-depth);
    }
    return rate;
}

// Photons absorbed per second, um^3 and umol/L of light straight from the lights.
double DyeGlow::direct(const Source& source, Vec3 position_um, OpticalField& field, Rng& rng) const {
    const Dye& dye = scene_->dyes[source.dye];
    double rate = 0;
    PathOptics optics;
    std::vector<MediumSpan> spans;
    for (std::size_t l = 0; l < scene_->lights.size(); ++l) {
        if (!(direct_[source.dye][l].uptake > 0)) continue;
        const auto light = sample_light(scene_->lights[l], position_um, rng.uniform(), rng.uniform());
        if (!light) continue;
        const auto excitation = illumination_->sample(source.weights, static_cast<int>(l), rng);
        if (!excitation) continue;
        const double nm = excitation->wavelength_nm;
        field.set_optics(Wavelengths::one(nm), optics);
        const Ray shadow{position_um, light->to_light};
        field.gather(shadow, spans);
        const double arrives = field.transmittance(shadow, spans, light->distance_um, optics, Loss::Extinction, rng)[0];
        rate += illumination_->photons(static_cast<int>(l), *excitation) / excitation->probability *
                light->fluence_per_um2 * arrives * absorption_per_um_per_uM(dye, nm);
    }
    return rate;
}

DyeGlow::Emission DyeGlow::emit(std::int64_t n, std::int64_t of_all, OpticalField& field, Rng& rng) const {
    const double total = places_.back().likely;
    const double wanted = total * (static_cast<double>(n) + offset_) / static_cast<double>(of_all);
    auto chosen = std::upper_bound(places_.begin(), places_.end(), wanted,
                                   [](double value, const Place& place) { return value < place.likely; });
    if (chosen == places_.end()) --chosen;
    const double likely = chosen->likely - (chosen == places_.begin() ? 0 : std::prev(chosen)->likely);
    const Source& source = sources_[chosen->source];
    const Spectrum& seen = seen_emission_[source.dye];
    const Dye& dye = scene_->dyes[source.dye];

    Emission emission;
    Photon& photon = emission.photon;
    photon.wavelength_nm = seen.sample(rng.uniform());
    const double share = dye.emission_per_nm(photon.wavelength_nm) / seen.pdf(photon.wavelength_nm);
    const double per_absorbed = dye.quantum_yield * share * total / likely / static_cast<double>(of_all);
    emission.scattered = chosen->absorbed_per_s >= 0;
    photon.weight = per_absorbed * (emission.scattered ? chosen->absorbed_per_s
                                                       : chosen->uM * chosen->volume_um3 *
                                                             direct(source, chosen->position, field, rng));
    photon.start_weight = photon.weight;
    photon.ray.origin =
        emission.scattered ? position_of_dye(source, chosen->brick, chosen->in_brick, rng) : chosen->position;
    photon.inside = space_->inside_at({photon.ray.origin, {0, 0, 1}});
    photon.order = 1;
    photon.dye = static_cast<int>(source.dye);
    return emission;
}

}  // namespace fluovox
