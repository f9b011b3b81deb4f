#include "fluovox/image/compare.h"
#include "fluovox/image/exr.h"
#include "fluovox/image/png.h"

#include "commands.h"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <iostream>

namespace fluovox::tools {
namespace {

constexpr const char* kUsage = "fluovox diff A.exr B.exr [-o difference.png] [--p-values map.png] [--json]";
constexpr const char* kExamples =
    "  fluovox diff before.exr after.exr              are they the same within their noise? exit 0 yes, 1 no\n"
    "  fluovox diff a.exr b.exr -o difference.png     and where: red brighter, blue darker, full colour significant\n"
    "  fluovox diff a.exr b.exr --json                p-value and means for a script\n"
    "\nTests pixels, tiles of 8 x 8 pixels and the mean of the image, in every layer and channel, at p < 1e-3 for all\n"
    "together. The images must come from different seeds. Exit code 2: the images cannot be read or compared.\n";

/// `diff` has no exit code but 2 for input that is missing, damaged or does not fit.
template <typename Work>
auto with_trouble(Work work) {
    try {
        return work();
    } catch (const InputError& e) {
        throw Error(ExitCode::Usage, e.what());
    }
}

std::filesystem::path png_path(const CommandLine& command, const char* option) {
    std::filesystem::path path = command.values()[option].as<std::string>();
    if (path.extension() != ".png") command.fail(fmt::format("--{} {} must end in .png", option, path.string()));
    return path;
}

void warn(const RenderedImage& image, const std::string& name) {
    if (image.nan_count > 0) {
        std::cerr << fmt::format("fluovox: warning: {}: {} samples were not finite\n", name, image.nan_count);
    }
    if (image.bound_violations > 0) {
        std::cerr << fmt::format("fluovox: warning: {}: a bound was exceeded {} times\n", name, image.bound_violations);
    }
}

void warn(const RenderedImage& a, const std::string& name_a, const RenderedImage& b, const std::string& name_b) {
    warn(a, name_a);
    warn(b, name_b);
    if (a.provenance.seed == b.provenance.seed && a.means != b.means) {
        std::cerr << "fluovox: note: both images have seed " << a.provenance.seed
                  << "; shared random numbers make the test less sensitive\n";
    }
}

void print_text(const Comparison& result) {
    std::cout << fmt::format("{}: p = {:.3g}", result.same ? "same" : "different", result.p_value);
    if (result.p_value < 1) std::cout << " (" << result.where << ')';
    std::cout << fmt::format("\n{} of {} pixels differ; means {:.6g} and {:.6g}\n", result.differing, result.pixels,
                             result.mean_a, result.mean_b);
}

}  // namespace

ExitCode run_diff(const std::vector<std::string>& arguments) {
    CommandLine command(kUsage, kExamples);
    auto add = command.options().add_options();
    add("image", po::value<std::vector<std::string>>()->value_name("FILE"), "the two images");
    add("output,o", po::value<std::string>()->value_name("PNG"), "picture of the differences in standard errors");
    add("p-values", po::value<std::string>()->value_name("PNG"), "picture of each pixel's p-value");
    command.positional("image", -1);
    if (!command.parse(arguments)) return ExitCode::Ok;
    const auto& values = command.values();
    const auto names =
        values.count("image") > 0 ? values["image"].as<std::vector<std::string>>() : std::vector<std::string>{};
    if (names.size() != 2) command.fail("diff takes two images");
    for (const char* option : {"output", "p-values"}) {
        if (values.count(option) > 0) png_path(command, option);
    }

    const RenderedImage a = with_trouble([&] { return load_exr(names[0]); });
    const RenderedImage b = with_trouble([&] { return load_exr(names[1]); });
    const Comparison result = with_trouble([&] { return compare(a, b); });

    if (!command.common().quiet) warn(a, names[0], b, names[1]);
    if (values.count("output") > 0) {
        save_png(png_path(command, "output"), difference_picture(result, a.width, a.height));
    }
    if (values.count("p-values") > 0) {
        save_png(png_path(command, "p-values"), p_value_picture(result, a.width, a.height));
    }
    if (command.common().json) {
        const nlohmann::ordered_json json = {{"same", result.same},     {"p_value", result.p_value},
                                             {"pixels", result.pixels}, {"differing", result.differing},
                                             {"mean_a", result.mean_a}, {"mean_b", result.mean_b},
                                             {"where", result.where}};
        std::cout << json.dump(2) << '\n';
    } else if (!command.common().quiet) {
        print_text(result);
    }
    return result.same ? ExitCode::Ok : ExitCode::Different;
}

}  // namespace fluovox::tools
