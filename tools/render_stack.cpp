#include "render_stack.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/digest.h"
#include "fluovox/core/progress.h"
#include "fluovox/core/version.h"
#include "fluovox/image/apng.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/plane_store.h"
#include "fluovox/image/sensor.h"
#include "fluovox/image/stack_pictures.h"
#include "fluovox/scene/stack.h"
#include "fluovox/transport/ground_truth.h"
#include "fluovox/transport/render.h"
#include "fluovox/transport/stack_view.h"

#include "plane_progress.h"
#include "stack_report.h"
#include "stack_stamp.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <variant>
#include <vector>

namespace fluovox::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kFrame_ms = 120;

/// One stack to be made: what it is, where its planes wait, what it is called.
class StackJob {
public:
    StackJob(const CommandLine& line, const Scene& scene, fs::path output, StackFormat format);

    ExitCode run();

private:
    int views() const { return static_cast<int>(stack_.views.angles_rad.size()); }
    int images() const { return views() * planes_; }
    void drop_truth_that_cannot_be();
    std::string work_key() const;
    void require_disk(const PlaneStore& store) const;
    std::optional<std::vector<PlaneFigures>> finished_planes() const;
    void require_replaceable_outputs() const;
    bool render_planes(const PlaneStore& store);
    void save_exr_plane(const PlaneStore& store, int image, const Scene& here, const Film& film) const;
    void assemble(const PlaneStore& store, int view);
    void write_stack(const PlaneStore& store, const fs::path& path, const StackInfo& info, const PlaneSource& source,
                     const std::optional<StackLabels>& labels = std::nullopt);
    void write_truth(const PlaneStore& store, const StackInfo& stack, int view, const GroundTruth& truth);
    bool wants(const std::string& truth) const { return truth_.contains(truth); }
    bool can_count_photons() const {
        const Camera& camera = scene_.description.camera;
        return camera.exposure_s > 0 && camera.numerical_aperture > 0;
    }
    fs::path truth_path(int view, const std::string& kind) const;
    PlaneSource source(const PlaneStore& store, int view) const;
    StackReport report(std::vector<PlaneFigures> planes, std::optional<double> seconds) const;
    void list_finished_outputs();
    std::vector<PlaneFigures> figures_of(const PlaneStore& store) const;
    std::map<std::string, std::vector<fs::path>> parts(int view) const;

    fs::path beside(int view, const std::string& end) const;
    fs::path view_path(int view) const { return beside(view, split_stack_name(output_).second); }
    fs::path plane_path(int view, int plane) const { return beside(view, exr_plane_ending(plane)); }
    fs::path folder() const { return {output_.string() + ".planes"}; }

    const CommandLine& line_;
    const Scene& scene_;
    const StackDescription& stack_;
    fs::path output_;
    StackFormat format_;
    SampleType type_ = SampleType::Float32;
    std::string layer_ = kTotalLayer;
    std::string estimator_;
    std::set<std::string> truth_;
    int planes_;
    std::size_t plane_pixels_, channels_;
    std::string key_;
    std::vector<fs::path> outputs_;
};

StackJob::StackJob(const CommandLine& line, const Scene& scene, fs::path output, StackFormat format)
    : line_(line),
      scene_(scene),
      stack_(*scene.description.stack),
      output_(std::move(output)),
      format_(format),
      estimator_(provenance_of(scene).estimator),
      planes_(plane_count(stack_)),
      plane_pixels_(static_cast<std::size_t>(scene.description.camera.width) *
                    static_cast<std::size_t>(scene.description.camera.height)),
      channels_(scene.description.film.channels.size()) {
    const std::string type = line.values()["type"].as<std::string>();
    if (type != "float32" && type != "uint16") line.fail("--type is float32 or uint16, not \"" + type + '"');
    if (type == "uint16") type_ = SampleType::UInt16;
    if (type_ == SampleType::UInt16 && format == StackFormat::Exr) line.fail("--type uint16 does not go with .exr");
    layer_ = line.values()["layer"].as<std::string>();
    std::vector<std::string> dyes;
    for (const Dye& dye : scene.dyes)
        dyes.push_back(dye.name);
    const std::vector<std::string> layers = film_layers(dyes, scene.description.film.per_dye);
    if (std::find(layers.begin(), layers.end(), layer_) == layers.end()) {
        line.fail(fmt::format("--layer \"{}\" is none of this scene's layers: {}", layer_, fmt::join(layers, ", ")));
    }
    if (line.values().count("value-per-count") > 0) {
        const double value = line.values()["value-per-count"].as<double>();
        if (!(value > 0) || !std::isfinite(value)) line.fail("--value-per-count must be a number above zero");
        if (type_ != SampleType::UInt16) line.fail("--value-per-count goes with --type uint16");
    }
    truth_ = read_truth(line);
    drop_truth_that_cannot_be();
    key_ = work_key();
}

// "all" is all that there is; what is asked for by name must be there.
void StackJob::drop_truth_that_cannot_be() {
    const auto need = [&](const char* kind, bool there, const std::string& why) {
        if (!wants(kind) || there) return;
        if (line_.values()["truth"].as<std::string>() != "all") line_.fail(why);
        warn(line_.common(), why);
        truth_.erase(kind);
    };
    const std::vector<LightDescription>& lights = scene_.description.lights;
    need("photons", can_count_photons(),
         "expected photons need camera.exposure and camera.numerical_aperture in the scene: add, for example, --set "
         "camera.exposure=20ms");
    need("concentration", !scene_.dyes.empty(), "the concentration of dyes needs a [[medium]] with a dye in the scene");
    need("irradiance",
         std::any_of(
             lights.begin(), lights.end(),
             [](const LightDescription& light) { return !std::holds_alternative<UniformLight>(light.light.shape); }),
         "irradiance needs a [[light]] that has a place in the scene, not kind = \"uniform\" alone");
}

std::string StackJob::work_key() const {
    Digest digest;
    digest.add(fmt::format(
        "{} {} {} {} {} {} ", version(), estimator_, layer_, static_cast<int>(format_), static_cast<int>(type_),
        line_.values().count("value-per-count") > 0 ? line_.values()["value-per-count"].as<double>() : 0.0));
    digest.add(fmt::format("{} ", fmt::join(truth_, ",")));
    digest.add(to_json(scene_.description));
    // The same grid written again differs in the random identifier that OpenVDB puts behind its version.
    constexpr std::size_t kIdentifier = 21;
    constexpr std::size_t kIdentifierBytes = 36;
    std::set<fs::path> files;
    for (const MediumDescription& medium : scene_.description.media) {
        if (medium.grid && files.insert(medium.grid->file).second)
            digest.add_file(medium.grid->file, kIdentifier, kIdentifierBytes);
    }
    return digest.finish();
}

fs::path StackJob::beside(int view, const std::string& end) const {
    std::string name = split_stack_name(output_).first;
    if (views() > 1) {
        const double degrees = stack_.views.angles_rad[static_cast<std::size_t>(view)] * 57.29577951308232;
        const bool whole = std::abs(degrees - std::round(degrees)) < 1e-6;
        name += whole ? fmt::format("-view{:03.0f}", degrees) : fmt::format("-view{:.6g}", degrees);
    }
    return output_.parent_path() / (name + end);
}

/// What has to be there besides the pictures, by what it is.
std::map<std::string, std::vector<fs::path>> StackJob::parts(int view) const {
    std::map<std::string, std::vector<fs::path>> parts;
    if (format_ != StackFormat::Exr) parts["stack"] = {view_path(view)};
    for (int plane = 0; plane < planes_ && format_ == StackFormat::Exr; ++plane)
        parts["stack"].push_back(plane_path(view, plane));
    for (const std::string& kind : truth_) {
        const bool apart =
            (kind != "labels" || format_ != StackFormat::OmeZarr) && (kind != "concentration" || !scene_.dyes.empty());
        if (apart) parts[kind] = {truth_path(view, kind)};
    }
    return parts;
}

// The projection is the last file to be written, and says which work it ends and what was written before it.
std::optional<std::vector<PlaneFigures>> StackJob::finished_planes() const {
    std::vector<PlaneFigures> planes;
    for (int view = 0; view < views(); ++view) {
        const std::optional<StackStamp> stamp = load_stamp(beside(view, ".png"));
        if (!stamp || stamp->key != key_ || stamp->planes.size() != static_cast<std::size_t>(planes_))
            return std::nullopt;
        for (const auto& [name, files] : parts(view)) {
            const auto written = stamp->parts.find(name);
            if (written != stamp->parts.end() && still_holds(files, written->second)) continue;
            std::error_code ignored;
            if (fs::exists(files.front(), ignored)) {
                warn(line_.common(), fmt::format("{} is not as it was written (damaged, cut short or replaced): the "
                                                 "stack is rendered again",
                                                 files.front().string()));
            }
            return std::nullopt;
        }
        planes.insert(planes.end(), stamp->planes.begin(), stamp->planes.end());
    }
    return planes;
}

void StackJob::require_disk(const PlaneStore& store) const {
    int left = 0;
    for (int image = 0; image < images(); ++image)
        left += store.has(image) ? 0 : 1;
    const auto values = static_cast<double>(plane_pixels_ * channels_);
    double result = values * (type_ == SampleType::UInt16 ? 2 : 4);
    if (format_ == StackFormat::OmeZarr) result *= 1.34;  // its smaller levels
    if (format_ == StackFormat::Exr) {                    // means and variances of every layer
        const std::size_t layers = 3 + (scene_.description.film.per_dye ? scene_.dyes.size() : 0);
        result = values * 8 * static_cast<double>(layers);
    }
    const double per_pixel = (wants("labels") ? 2.0 : 0.0) +
                             4 * static_cast<double>((wants("concentration") ? scene_.dyes.size() : 0) +
                                                     (wants("irradiance") ? scene_.description.lights.size() : 0) +
                                                     (wants("photons") ? channels_ : 0));
    result += static_cast<double>(plane_pixels_) * per_pixel;
    const double needed = left * store.plane_bytes() + images() * result;
    std::error_code failure;
    const fs::space_info space = fs::space(store.folder(), failure);
    if (failure || needed <= static_cast<double>(space.available)) return;
    throw OutputError(
        fmt::format("{}: the stack ({} planes of {} x {} pixels, {} channels) needs about {:.3g} GB of disk "
                    "and {:.3g} GB are free: take fewer planes or pixels, or write elsewhere",
                    output_.string(), images(), scene_.description.camera.width, scene_.description.camera.height,
                    channels_, needed / 1e9, static_cast<double>(space.available) / 1e9));
}

// Before the work begins: what is in the way of an output, and is none of ours, stays.
void StackJob::require_replaceable_outputs() const {
    if (format_ != StackFormat::OmeZarr) require_writable(output_);
    std::set<fs::path> pictures;
    for (int view = 0; view < views(); ++view) {
        if (!pictures.insert(beside(view, ".png")).second) line_.fail("two of the stack's views have the same angle");
        std::vector<fs::path> stacks;
        if (format_ != StackFormat::Exr) stacks.push_back(view_path(view));
        for (const std::string& kind : truth_)
            stacks.push_back(truth_path(view, kind));
        for (const fs::path& path : stacks) {
            if (format_ == StackFormat::OmeZarr) {
                require_replaceable_zarr(path);
            } else {
                require_writable(path);
            }
        }
        require_writable(beside(view, ".png"));
        require_writable(beside(view, ".apng"));
    }
}

bool StackJob::render_planes(const PlaneStore& store) {
    const auto progress = make_progress(line_.common());
    PlaneProgress plane_progress(*progress);
    int left = 0;
    for (int image = 0; image < images(); ++image)
        left += store.has(image) ? 0 : 1;
    if (left < images() && !line_.common().quiet)
        fmt::print(stderr, "fluovox: {} of {} planes are there already\n", images() - left, images());
    progress->start("rendering", left * PlaneProgress::kUnits);
    for (int image = 0; image < images(); ++image) {
        if (store.has(image)) continue;
        const auto begin = std::chrono::steady_clock::now();
        const Scene here = scene_at(scene_, image / planes_, image % planes_);
        const RenderResult result = render(here, plane_progress);
        if (result.stopped) {
            fmt::print(stderr,
                       "fluovox: stopped after {} of {} planes, which are kept in {}; run the same command "
                       "again to go on\n",
                       images() - left, images(), store.folder().string());
            return false;
        }
        if (format_ == StackFormat::Exr) save_exr_plane(store, image, here, result.film);
        PlaneFigures figures;
        const std::vector<float> values = plane_values(result.film, result.film.layer(layer_), figures);
        figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        store.save(image, values, figures);
        --left;
    }
    return true;
}

void StackJob::save_exr_plane(const PlaneStore& store, int image, const Scene& here, const Film& film) const {
    StackInfo info = describe_stack(scene_, image / planes_);
    info.key = key_;
    Provenance provenance = provenance_of(here);
    provenance.stack_note = exr_plane_note(info, image % planes_);
    save_exr(store.folder() / fmt::format("{:05}.exr", image), film, here.description.film, provenance);
}

PlaneSource StackJob::source(const PlaneStore& store, int view) const {
    return [this, &store, view](int plane, int channel, std::span<float> values) {
        store.load(view * planes_ + plane, static_cast<std::size_t>(channel) * plane_pixels_, values);
    };
}

void StackJob::write_stack(const PlaneStore& store, const fs::path& path, const StackInfo& info,
                           const PlaneSource& source, const std::optional<StackLabels>& labels) {
    // Written among the planes first: what a killed run leaves half done goes with them.
    const fs::path fresh = store.folder() / ("result" + split_stack_name(path).second);
    std::error_code failure;
    fs::remove_all(fresh, failure);
    if (format_ == StackFormat::OmeTiff || format_ == StackFormat::Exr) save_ome_tiff(fresh, info, source);
    if (format_ == StackFormat::ImageJ) save_imagej_tiff(fresh, info, source);
    if (format_ == StackFormat::OmeZarr) save_ome_zarr(fresh, info, source, labels);
    if (fs::is_directory(path, failure)) fs::remove_all(path, failure);
    fs::rename(fresh, path, failure);
    if (failure) throw OutputError(fmt::format("{}: {}", path.string(), failure.message()));
    outputs_.push_back(path);
}

fs::path StackJob::truth_path(int view, const std::string& kind) const {
    return beside(view, "-" + kind + (format_ == StackFormat::Exr ? ".ome.tif" : split_stack_name(output_).second));
}

// Labels of a Zarr stack are inside it; everything else is a stack of its own beside the first.
void StackJob::write_truth(const PlaneStore& store, const StackInfo& stack, int view, const GroundTruth& truth) {
    if (wants("labels") && format_ != StackFormat::OmeZarr) {
        write_stack(store, truth_path(view, "labels"), GroundTruth::labels_info(stack),
                    [&](int plane, int /*channel*/, std::span<float> values) { truth.labels(plane, values); });
    }
    if (wants("concentration")) {
        write_stack(
            store, truth_path(view, "concentration"), truth.concentration_info(stack),
            [&](int plane, int channel, std::span<float> values) { truth.concentration(plane, channel, values); });
    }
    if (wants("irradiance")) {
        write_stack(store, truth_path(view, "irradiance"), truth.irradiance_info(stack),
                    [&](int plane, int channel, std::span<float> values) { truth.irradiance(plane, channel, values); });
    }
    if (!wants("photons")) return;
    StackInfo info = stack;
    info.type = SampleType::Float32;
    info.quantity = "expected photons";
    info.unit = "photons";
    double most = 0;
    for (int channel = 0; channel < static_cast<int>(info.channels.size()); ++channel)
        most = std::max(most, photons_per_value(stack, channel, stack.exposure_s));
    info.max_value = most * stack.max_value;
    const PlaneSource radiance = source(store, view);
    write_stack(store, truth_path(view, "photons"), info, [&](int plane, int channel, std::span<float> values) {
        radiance(plane, channel, values);
        const double photons = photons_per_value(stack, channel, stack.exposure_s);
        for (float& value : values)
            value = static_cast<float>(photons * static_cast<double>(value));
    });
}

void StackJob::assemble(const PlaneStore& store, int view) {
    StackInfo info = describe_stack(scene_, view);
    info.key = key_;
    info.type = type_;
    for (int image = 0; image < images(); ++image)  // one scale for all views
        info.max_value = std::max(info.max_value, store.figures(image).max_value);
    if (type_ == SampleType::UInt16 && info.max_value > 0) info.value_per_count = info.max_value / 65535;
    if (line_.values().count("value-per-count") > 0)
        info.value_per_count = line_.values()["value-per-count"].as<double>();
    std::optional<GroundTruth> truth;
    if (!truth_.empty()) truth.emplace(scene_, view);
    if (format_ != StackFormat::Exr) {
        std::optional<StackLabels> labels;
        if (wants("labels"))
            labels = StackLabels{
                "labels", [&](int plane, int /*channel*/, std::span<float> values) { truth->labels(plane, values); }};
        write_stack(store, view_path(view), info, source(store, view), labels);
    } else {
        for (int plane = 0; plane < planes_; ++plane) {
            const fs::path from = store.folder() / fmt::format("{:05}.exr", view * planes_ + plane);
            std::error_code failure;
            if (fs::exists(from)) fs::rename(from, plane_path(view, plane), failure);
            if (failure) throw OutputError(fmt::format("{}: {}", plane_path(view, plane).string(), failure.message()));
            outputs_.push_back(plane_path(view, plane));
        }
    }
    if (truth) write_truth(store, info, view, *truth);
    const StackPictures pictures = make_stack_pictures(info, scene_.description.film, source(store, view));
    save_apng(beside(view, ".apng"), pictures.frames, kFrame_ms);
    StackStamp stamp{key_, {}, {}};
    for (const auto& [name, files] : parts(view))
        stamp.parts[name] = content_of(files);
    for (int plane = 0; plane < planes_; ++plane)
        stamp.planes.push_back(store.figures(view * planes_ + plane));
    save_png(
        beside(view, ".png"), pictures.projection,
        {{"Description", "brightest values along the stack; " + pictures.exposure}, {kStampRemark, to_json(stamp)}});
    outputs_.push_back(beside(view, ".png"));
    outputs_.push_back(beside(view, ".apng"));
}

std::vector<PlaneFigures> StackJob::figures_of(const PlaneStore& store) const {
    std::vector<PlaneFigures> planes;
    planes.reserve(static_cast<std::size_t>(images()));
    for (int image = 0; image < images(); ++image)
        planes.push_back(store.figures(image));
    return planes;
}

StackReport StackJob::report(std::vector<PlaneFigures> planes, std::optional<double> seconds) const {
    return {output_, outputs_, format_, estimator_, std::move(planes), seconds};
}

// Names of what is there; only the animation may have gone, which is no data.
void StackJob::list_finished_outputs() {
    for (int view = 0; view < views(); ++view) {
        const auto there = parts(view);
        for (const char* part : {"stack", "labels", "concentration", "irradiance", "photons"}) {
            const auto files = there.find(part);
            if (files != there.end()) outputs_.insert(outputs_.end(), files->second.begin(), files->second.end());
        }
        outputs_.push_back(beside(view, ".png"));
        std::error_code ignored;
        if (fs::exists(beside(view, ".apng"), ignored)) outputs_.push_back(beside(view, ".apng"));
    }
}

ExitCode StackJob::run() {
    const auto begin = std::chrono::steady_clock::now();
    for (const std::string& doubt : doubts_about_stack(scene_))
        warn(line_.common(), doubt);
    const bool overwrite = line_.values()["overwrite"].as<bool>();
    if (auto planes = overwrite ? std::nullopt : finished_planes()) {
        list_finished_outputs();
        warn_of_planes(line_, scene_, *planes);
        print_stack_report(line_, scene_, report(std::move(*planes), std::nullopt));
        return ExitCode::Ok;
    }
    require_replaceable_outputs();
    const PlaneStore store(folder(), key_, plane_pixels_ * channels_, overwrite);
    try {
        require_disk(store);
        if (!render_planes(store)) return ExitCode::Stopped;
        for (int view = 0; view < views(); ++view)
            assemble(store, view);
    } catch (const OutputError& e) {
        // Planes that are finished stay; a folder without any goes.
        bool any = false;
        for (int image = 0; image < images() && !any; ++image)
            any = store.has(image);
        if (!any) store.remove();
        throw OutputError(std::string(e.what()) + (any ? "; finished planes are kept, run again to go on" : ""));
    }
    std::vector<PlaneFigures> planes = figures_of(store);
    warn_of_planes(line_, scene_, planes);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    print_stack_report(line_, scene_, report(std::move(planes), seconds));
    store.remove();
    return ExitCode::Ok;
}

}  // namespace

ExitCode render_stack(const CommandLine& line, const Scene& scene, const fs::path& output, StackFormat format) {
    return StackJob(line, scene, output, format).run();
}

}  // namespace fluovox::tools
