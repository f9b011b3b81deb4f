#include "fluovox/transport/fluence.h"

#include "fluovox/core/version.h"
#include "fluovox/spectral/photons.h"
#include "fluovox/transport/endless.h"
#include "fluovox/transport/photon_media.h"
#include "fluovox/transport/photon_source.h"
#include "fluovox/transport/photon_tracer.h"
#include "fluovox/transport/voxel_tally.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

namespace fluovox {
namespace {

// Fields of the voxel tally; absorbed by medium m is kAbsorbed + m.
constexpr int kAbsorbed = 2;

/// Where a photon on this ray goes through the box for the last time: 0..5 for -x +x -y +y -z +z. One that misses it
/// counts for the face it flies towards most.
int exit_face(const Bounds& box, const Ray& ray) {
    int face = -1;
    double nearest = std::numeric_limits<double>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
        const double d = ray.direction[axis];
        if (d == 0) continue;
        const double t = ((d > 0 ? box.max[axis] : box.min[axis]) - ray.origin[axis]) / d;
        if (t < nearest) {
            nearest = t;
            face = 2 * axis + (d > 0 ? 1 : 0);
        }
    }
    constexpr double kRounding_um = 1e-3;
    if (face >= 0 && nearest > -kRounding_um) return face;
    int axis = 0;
    for (int other = 1; other < 3; ++other) {
        if (std::abs(ray.direction[other]) > std::abs(ray.direction[axis])) axis = other;
    }
    return 2 * axis + (ray.direction[axis] > 0 ? 1 : 0);
}

/// Adds up what happens to photons: the sums of one batch, and the voxels of all.
class BudgetSink {
public:
    BudgetSink(const Scene& scene, const PhotonSpace& space, const BudgetLayout& layout,
               std::vector<VoxelTally>& voxels)
        : scene_(&scene), bounds_(space.bounds()), layout_(layout), size_(layout.size()), voxels_(&voxels) {
        for (const SceneMedium& medium : scene.media) {
            if (medium.grid) grid_boxes_.emplace_back(BoxRegion{medium.grid->bounds().min, medium.grid->bounds().max});
        }
    }

    /// Row of sums: photons of both classes, watts per photon/s of both classes, those that met a medium, path.
    void start_batch(std::vector<double>& row) { row_ = row.data(); }
    void finish_batch() {
        row_[path_and_met_at(size_)] = row_[met_at(size_)] + row_[path_at(size_)] / path_unit_um(bounds_);
    }
    void launched(const Photon& photon, std::uint64_t seed, std::uint64_t number) {
        set_class(photon);
        add(BudgetLayout::kLaunched, photon.weight);
        met_ = false;
        // The voxels' rounding has numbers of its own, so that asking for grids does not change the photons.
        if (!voxels_->empty()) voxel_rng_ = Rng(seed, number, kVoxelStream);
    }

    void emission(const Photon& photon) {
        set_class(photon);
        add(BudgetLayout::kLaunched, photon.weight);
    }
    void flight(const Photon& photon, const Flight& flight, const Zone& zone) {
        if (photon.order == 0) add_path(photon, flight, zone);
        if (!voxels_->empty()) flight_in_voxels(flight, zone);
    }
    void absorbed(const Photon& /*photon*/, int medium, double weight) {
        add(BudgetLayout::absorbed(static_cast<std::size_t>(medium)), weight);
    }
    void absorbed(const Photon& photon, int medium, double weight, Vec3 position) {
        absorbed(photon, medium, weight);
        for (VoxelTally& voxels : *voxels_)
            voxels.add_point(position, kAbsorbed + medium, weight * relative_energy_, voxel_rng_);
    }
    void converted(const Photon& /*photon*/, int dye, double absorbed, double reemitted) {
        const auto d = static_cast<std::size_t>(dye);
        const double back = absorbed * scene_->dyes[d].quantum_yield;
        add(layout_.reemitted(d), reemitted);
        add(layout_.yield_loss(d), absorbed - back);
        add(layout_.not_followed(d), back - reemitted);
    }
    void escaped(const Photon& photon) {
        const int face = exit_face(bounds_, photon.ray);
        const int escape = static_cast<int>(escape_of(photon));
        add(layout_.escaped(face, escape), photon.weight);
        if (layout_.bins() == 0) return;
        const double cosine = std::min(1.0, std::abs(photon.ray.direction[face / 2]));
        const double angle = std::acos(cosine) * 2 / std::numbers::pi;
        const auto bins = static_cast<double>(layout_.bins());
        const auto bin = static_cast<std::size_t>(std::min(angle * bins, bins - 1));
        add(layout_.angle(face, escape, bin), photon.weight);
    }
    void cut(const Photon& /*photon*/, double weight) { add(BudgetLayout::kCut, weight); }
    void vertex(const Photon& /*photon*/, int /*medium*/) {}

    /// Places in a row, for a layout of that size.
    static std::size_t row_size(std::size_t size) { return 4 * size + 3; }
    static std::size_t met_at(std::size_t size) { return 4 * size; }
    static std::size_t path_at(std::size_t size) { return 4 * size + 1; }
    /// Both together, the path in sizes of the box: from the three variances follows the covariance.
    static std::size_t path_and_met_at(std::size_t size) { return 4 * size + 2; }
    static double path_unit_um(const Bounds& bounds) {
        const double size = length(bounds.size());
        return std::isfinite(size) && size > 0 ? size : 1;
    }
    /// Wavelength whose photons count one in the voxels.
    static constexpr double kVoxelReference_nm = 500;

    void set_optics(const PhotonMedia* media) { media_ = media; }

private:
    static constexpr std::uint64_t kVoxelStream = 1;

    void set_class(const Photon& photon) {
        emission_ = photon.order > 0;
        class_row_ = row_ + (emission_ ? size_ : 0);
        energy_ = photon_energy_J(photon.wavelength_nm);
        relative_energy_ = kVoxelReference_nm / photon.wavelength_nm;
    }
    void add(std::size_t at, double weight) {
        class_row_[at] += weight;
        class_row_[2 * size_ + at] += weight * energy_;
    }
    // In media: within regions, or within the box of a grid.
    void add_path(const Photon& photon, const Flight& flight, const Zone& zone) {
        const double length = zone.inside != 0 ? flight.length_um : length_in_grids(flight);
        if (!met_ && (length > 0 || photon.refractions > 0)) {
            met_ = true;
            row_[met_at(size_)] += 1;
        }
        double path = length > 0 ? flight.weight * length : 0;
        if (zone.absorption > 0) path = flight.lost / zone.absorption;
        if (!std::isfinite(path)) return;
        row_[path_at(size_)] += path;
    }
    double length_in_grids(const Flight& flight) const {
        double length = 0;
        double counted_to = 0;
        // Boxes may overlap: each goes on from where the one before it ended.
        std::vector<Interval>& chords = chords_;
        chords.clear();
        for (const Region& box : grid_boxes_)
            chords.push_back(intersect(box, flight.ray));
        std::sort(chords.begin(), chords.end(), [](const auto& a, const auto& b) { return a.begin < b.begin; });
        for (const Interval& chord : chords) {
            const double begin = std::max(chord.begin, counted_to);
            const double end = std::min(chord.end, flight.length_um);
            if (!(end > begin)) continue;
            length += end - begin;
            counted_to = end;
        }
        return length;
    }
    void flight_in_voxels(const Flight& flight, const Zone& zone) {
        shares_.clear();
        shares_.push_back({emission_ ? 1 : 0, relative_energy_});
        for (const int medium : zone.media) {
            const double absorption = media_->optics(medium).absorption;
            if (absorption > 0) shares_.push_back({kAbsorbed + medium, absorption * relative_energy_});
        }
        for (VoxelTally& voxels : *voxels_)
            voxels.add_flight({flight.ray, flight.length_um, flight.weight, zone.absorption}, shares_, voxel_rng_);
    }

    const Scene* scene_;
    Bounds bounds_;
    BudgetLayout layout_;
    std::size_t size_;
    std::vector<VoxelTally>* voxels_;
    std::vector<Region> grid_boxes_;
    mutable std::vector<Interval> chords_;
    bool met_ = false;
    const PhotonMedia* media_ = nullptr;
    Rng voxel_rng_{0, 0, 0};
    std::vector<VoxelTally::Share> shares_;
    double* row_ = nullptr;
    double* class_row_ = nullptr;
    bool emission_ = false;
    double energy_ = 0, relative_energy_ = 1;
};

/// Means over batches of photons, and how they scatter. The last batch may be smaller than the others and then counts
/// less. Weighted sums as by West, Commun. ACM 22 (1979) 532.
class BatchMeans {
public:
    explicit BatchMeans(std::size_t size) : mean_(size, 0), squares_(size, 0) {}

    void add(const std::vector<double>& sums, double photons) {
        ++count_;
        photons_ += photons;
        for (std::size_t i = 0; i < mean_.size(); ++i) {
            const double value = sums[i] / photons;
            const double delta = value - mean_[i];
            mean_[i] += delta * (photons / photons_);
            squares_[i] += photons * delta * (value - mean_[i]);
        }
    }
    std::vector<Estimate> estimates(double factor) const {
        std::vector<Estimate> result(mean_.size());
        const auto n = static_cast<double>(count_);
        for (std::size_t i = 0; i < result.size(); ++i) {
            const double variance = count_ > 1 ? squares_[i] / (n - 1) / photons_ : 0;
            result[i] = {factor * mean_[i], factor * std::sqrt(variance)};
        }
        return result;
    }

private:
    std::int64_t count_ = 0;
    double photons_ = 0;
    std::vector<double> mean_, squares_;
};

bool known_well(const LightBudget& budget, double relative_error) {
    const auto fine = [&](const Estimate& e) {
        return e.value < 0.01 * budget.launched.value || e.standard_error <= relative_error * e.value;
    };
    const auto& all = budget.escaped[LightBudget::kAll];
    return std::all_of(budget.absorbed.begin(), budget.absorbed.end(), fine) &&
           std::all_of(all.begin(), all.end(), fine);
}

/// One run: what all threads share.
class FluenceRun {
public:
    FluenceRun(const Scene& scene, const FluenceSettings& settings)
        : scene_(&scene),
          settings_(settings),
          space_(scene),
          source_(scene, space_),
          layout_(scene.media.size(), scene.dyes.size(), settings.angle_bins),
          means_(BudgetSink::row_size(layout_.size())) {
        limits_.orders = scene.description.render.fluorescence_orders.value_or(kAllOrders);
        if (scene.description.render.max_scatterings) {
            limits_.scatterings = *scene.description.render.max_scatterings;
            limits_.scatterings_are_physical = true;
        }
        limits_.majorant_factor = settings.majorant_factor;
        if (settings.grids) make_voxels();
    }

    FluenceResult run(Progress& progress) {
        progress.start("photons", settings_.photons);
        // Batches are the same however many are done at once; their number only limits how well errors are known.
        constexpr std::int64_t kBatches = 2000;
        constexpr std::int64_t kRoundBatch = 500;
        batch_ = settings_.relative_error ? kRoundBatch : std::max<std::int64_t>(1, settings_.photons / kBatches);
        std::int64_t round = settings_.relative_error ? 64 : kRoundBatch;
        while (done_ < settings_.photons && !progress.stopped()) {
            trace_round(round, progress);
            if (!settings_.relative_error) continue;
            const EnergyBudget budget = budgets(means_.estimates(1), 0);
            if (known_well(budget.excitation, *settings_.relative_error) &&
                known_well(budget.emission, *settings_.relative_error)) {
                precise_ = true;
                break;
            }
            round = std::min<std::int64_t>(4 * kRoundBatch, done_ / batch_ / 2 + 1);
        }
        return result(progress.stopped());
    }

private:
    static constexpr int kAllOrders = 1000;

    struct Worker {
        Worker(const FluenceRun& run, std::vector<VoxelTally>& voxels)
            : tracer(*run.scene_, run.space_, run.limits_), sink(*run.scene_, run.space_, run.layout_, voxels) {
            sink.set_optics(&tracer.media());
        }
        PhotonTracer<BudgetSink> tracer;
        BudgetSink sink;
    };

    void make_voxels() {
        const int fields = kAbsorbed + static_cast<int>(scene_->media.size());
        std::vector<VoxelLattice> lattices = chosen_lattices();
        double bytes = 0;
        for (const VoxelLattice& lattice : lattices)
            bytes += VoxelTally::bytes(lattice, fields);
        if (bytes > settings_.max_bytes) {
            throw InputError(
                fmt::format("the fluence grids would take {:.3g} GB, more than the limit of {:.3g} GB; ask "
                            "for larger voxels (--voxel-size) or raise --max-bytes",
                            bytes * 1e-9, settings_.max_bytes * 1e-9));
        }
        for (VoxelLattice& lattice : lattices)
            voxels_.emplace_back(std::move(lattice), fields, static_cast<double>(settings_.photons));
    }
    // One for all, or those of each dye's grid; `own_lattice_` then says which medium has which.
    std::vector<VoxelLattice> chosen_lattices() {
        own_lattice_.assign(scene_->media.size(), 0);
        const SourceLocation place{scene_->description.file, 1, 1};
        if (settings_.voxel_um) {
            const Vec3 size = space_.bounds().size();
            const double voxels = size.x * size.y * size.z / std::pow(*settings_.voxel_um, 3);
            if (!std::isfinite(voxels))
                throw SceneError(place, "a medium is infinite, so no voxels can fill its box; give it a finite region");
            if (voxels * 16 > settings_.max_bytes) {
                throw InputError(
                    fmt::format("{:.3g} voxels are too many; ask for larger ones (--voxel-size), or raise "
                                "--max-bytes",
                                voxels));
            }
            return {VoxelLattice::filling(space_.bounds(), *settings_.voxel_um)};
        }
        std::vector<VoxelLattice> lattices;
        for (std::size_t m = 0; m < scene_->media.size(); ++m) {
            const SceneMedium& medium = scene_->media[m];
            if (!medium.grid || medium.dye < 0) continue;
            if (medium.grid->background() > 0) require_room_for_box(*medium.grid);
            VoxelLattice lattice = VoxelLattice::of(*medium.grid);
            const auto known = std::find(lattices.begin(), lattices.end(), lattice);
            own_lattice_[m] = static_cast<std::size_t>(known - lattices.begin());
            if (known == lattices.end()) lattices.push_back(std::move(lattice));
        }
        if (!lattices.empty()) return lattices;
        throw SceneError(place,
                         "no dye has a grid whose voxels could be used; say how large voxels shall be "
                         "(--voxel-size 1um)");
    }

    // A grid with a background has values in its whole box: that must be known before its bricks are listed.
    void require_room_for_box(const SparseGrid& grid) const {
        const Vec3 size = grid.bounds().size();
        const auto& rows = grid.world_from_index().rows;
        const double voxels = size.x * size.y * size.z / std::abs(dot(rows[0], cross(rows[1], rows[2])));
        if (voxels * 16 <= settings_.max_bytes) return;
        throw InputError(fmt::format(
            "a dye's grid has a background, so that all {:.3g} voxels of its box count, which are too many; "
            "say how large voxels shall be (--voxel-size), or raise --max-bytes",
            voxels));
    }

    void trace_round(std::int64_t batches, Progress& progress) {
        const std::int64_t left = (settings_.photons - done_ + batch_ - 1) / batch_;
        batches = std::min(batches, left);
        const std::int64_t first = done_ / batch_;
        std::vector<std::vector<double>> rows(static_cast<std::size_t>(batches));
        tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, batches, 1), [&](const auto& range) {
            auto& worker = workers_.local();
            if (!worker) worker = std::make_unique<Worker>(*this, voxels_);
            for (std::int64_t b = range.begin(); b < range.end() && !progress.stopped(); ++b)
                trace_batch(*worker, first + b, rows[static_cast<std::size_t>(b)], progress);
        });
        if (progress.stopped()) return;
        for (std::int64_t b = 0; b < batches; ++b)
            means_.add(rows[static_cast<std::size_t>(b)],
                       static_cast<double>(end_of(first + b) - (first + b) * batch_));
        done_ = end_of(first + batches - 1);
    }

    std::int64_t end_of(std::int64_t batch) const { return std::min((batch + 1) * batch_, settings_.photons); }

    void trace_batch(Worker& worker, std::int64_t batch, std::vector<double>& row, Progress& progress) const {
        row.assign(BudgetSink::row_size(layout_.size()), 0);
        worker.sink.start_batch(row);
        for (std::int64_t n = batch * batch_; n < end_of(batch) && !progress.stopped(); ++n) {
            const auto number = static_cast<std::uint64_t>(n);
            Rng rng(settings_.seed, number, 0);
            const Photon photon = source_.launch(rng);
            worker.sink.launched(photon, settings_.seed, number);
            worker.tracer.follow(photon, rng, worker.sink);
        }
        worker.sink.finish_batch();
        for (std::size_t part = 0; part < 4; ++part)
            layout_.complete(row.data() + part * layout_.size());
        progress.advance(end_of(batch) - batch * batch_);
    }

    // `unit` 0: photons, 1: watts.
    EnergyBudget budgets(const std::vector<Estimate>& row, std::size_t unit) const {
        const Estimate* first = row.data() + 2 * unit * layout_.size();
        return {layout_.budget(first), layout_.budget(first + layout_.size())};
    }

    FluenceResult result(bool stopped) {
        FluenceResult result;
        result.photons = done_;
        const std::vector<Estimate> shares = means_.estimates(1);
        result.share = budgets(shares, 0);
        result.met_a_medium = shares[BudgetSink::met_at(layout_.size())];
        result.mean_path_um = mean_path_um(shares);
        result.watts = budgets(means_.estimates(source_.photons_per_s()), 1);
        result.precise = precise_ || !settings_.relative_error;
        result.stopped = stopped;
        for (const auto& worker : workers_) {
            result.bound_violations += worker->tracer.bound_violations();
            result.scatterings += worker->tracer.scatterings();
        }
        if (!voxels_.empty() && done_ > 0) add_grids(result);
        return result;
    }

    // Of photons that met a medium: a ratio of two sums.
    Estimate mean_path_um(const std::vector<Estimate>& shares) const {
        const Estimate& met = shares[BudgetSink::met_at(layout_.size())];
        const Estimate& path = shares[BudgetSink::path_at(layout_.size())];
        if (!(met.value > 0)) return {};
        const double unit = BudgetSink::path_unit_um(space_.bounds());
        const double path_variance = std::pow(path.standard_error / unit, 2);
        const double met_variance = std::pow(met.standard_error, 2);
        const double both = std::pow(shares[BudgetSink::path_and_met_at(layout_.size())].standard_error, 2);
        const double covariance = 0.5 * (both - path_variance - met_variance);
        const double ratio = path.value / unit / met.value;
        const double variance = path_variance + ratio * ratio * met_variance - 2 * ratio * covariance;
        return {path.value / met.value, unit * std::sqrt(std::max(0.0, variance)) / met.value};
    }

    void add_grids(FluenceResult& result) const {
        // Watts of one photon of the reference wavelength among those launched.
        const double watts =
            source_.photons_per_s() * photon_energy_J(BudgetSink::kVoxelReference_nm) / static_cast<double>(done_);
        constexpr double kPerMm2 = 1e6;
        constexpr double kPerMm3 = 1e9;
        const auto add = [&](std::size_t lattice, int field, double factor, const std::string& name, const char* unit) {
            const VoxelTally& voxels = voxels_[lattice];
            BrickField& grid =
                result.grids.emplace_back(voxels.field(field, factor * watts / voxels.voxel_volume_um3()));
            grid.name = name;
            grid.metadata.value_unit = unit;
            grid.metadata.length_unit = "um";
            grid.metadata.fluovox_version = version();
        };
        for (std::size_t lattice = 0; lattice < voxels_.size(); ++lattice) {
            const std::string of = lattice == 0 ? "" : '.' + scene_->media[first_medium_of(lattice)].name;
            add(lattice, 0, kPerMm2, "fluence.excitation" + of, "W/mm2");
            if (!scene_->dyes.empty()) add(lattice, 1, kPerMm2, "fluence.emission" + of, "W/mm2");
        }
        for (std::size_t m = 0; m < scene_->media.size(); ++m)
            add(own_lattice_[m], kAbsorbed + static_cast<int>(m), kPerMm3, "absorbed." + scene_->media[m].name,
                "W/mm3");
    }
    std::size_t first_medium_of(std::size_t lattice) const {
        return static_cast<std::size_t>(std::find(own_lattice_.begin(), own_lattice_.end(), lattice) -
                                        own_lattice_.begin());
    }

    const Scene* scene_;
    FluenceSettings settings_;
    PhotonSpace space_;
    PhotonSource source_;
    BudgetLayout layout_;
    PhotonLimits limits_;
    std::vector<VoxelTally> voxels_;
    std::vector<std::size_t> own_lattice_;  // of each medium; the first where it has none
    BatchMeans means_;
    std::int64_t batch_ = 1, done_ = 0;
    bool precise_ = false;  // as asked for
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers_;
};

}  // namespace

FluenceResult trace_fluence(const Scene& scene, const FluenceSettings& settings, Progress& progress) {
    require_an_end(scene, travelling_wavelengths_nm(scene));
    return FluenceRun(scene, settings).run(progress);
}

}  // namespace fluovox
