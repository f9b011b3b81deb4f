// fluovox_validate [-o FOLDER] [--seed N] [--quick] [WORD]: all cases, or those whose name holds WORD; --quick: some of
// each kind that take a second together.
// fluovox_validate --spread RUNS [--share X] [--seed N] [WORD]: short runs of each case, X of the usual length where
// that is fixed: whether they lie about each other and the reference as their standard errors say.

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/image/plot.h"

#include "validation/case.h"
#include "validation/spread.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace fluovox::validation {
namespace {

namespace fs = std::filesystem;

/// What all z values together say.
struct Verdict {
    double bound = 0;  ///< of |z| for this many cases (Sidak, 1 % for all of them together)
    double chi_squared = 0;
    double p_high = 0, p_low = 0;  ///< chance of a larger or smaller chi-squared
    int outside = 0;
    int coarse = 0;  ///< with a larger standard error than is asked

    bool passes() const { return outside == 0 && coarse == 0 && p_high > 0.001 && p_low > 0.001; }
};

Verdict judge(const std::vector<Outcome>& outcomes) {
    Verdict verdict;
    const auto n = static_cast<double>(outcomes.size());
    const double each = 1 - std::pow(1 - 0.01, 1 / n);
    verdict.bound = boost::math::quantile(boost::math::normal(), 1 - 0.5 * each);
    for (const Outcome& outcome : outcomes) {
        verdict.chi_squared += outcome.z() * outcome.z();
        if (!(std::abs(outcome.z()) <= verdict.bound)) ++verdict.outside;
        if (!outcome.precise()) ++verdict.coarse;
    }
    const boost::math::chi_squared distribution(n);
    verdict.p_high = boost::math::cdf(boost::math::complement(distribution, verdict.chi_squared));
    verdict.p_low = boost::math::cdf(distribution, verdict.chi_squared);
    return verdict;
}

std::string verdict_text(const std::vector<Outcome>& outcomes, const Verdict& v) {
    return fmt::format(
        "{} cases; |z| may be up to {:.2f} (Sidak, 1 %); {} beyond. {} with a larger standard error than is asked. "
        "Chi-squared {:.1f} for {} values: p = {:.3f} above, {:.3f} below. {}",
        outcomes.size(), v.bound, v.outside, v.coarse, v.chi_squared, outcomes.size(), v.p_high, v.p_low,
        v.passes() ? "PASSED" : "FAILED");
}

Plot plot_of_z(const std::vector<Outcome>& outcomes, double bound) {
    Plot plot;
    plot.title = "Deviation of each case from its reference";
    plot.x_label = "case";
    plot.y_label = "z, standard errors";
    PlotCurve curve;
    curve.steps = true;
    curve.color = {0.1, 0.35, 0.7};
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
        curve.x.push_back(static_cast<double>(i + 1));
        curve.y.push_back(outcomes[i].z());
    }
    plot.curves.push_back(curve);
    for (const double y : {-bound, 0.0, bound})
        plot.curves.push_back(
            {"", {0.5, static_cast<double>(outcomes.size()) + 0.5}, {y, y}, {}, {0.5, 0.5, 0.5}, true});
    return plot;
}

Plot plot_of_quantiles(const std::vector<Outcome>& outcomes) {
    Plot plot;
    plot.title = "All z together against the normal distribution";
    plot.x_label = "z, standard errors";
    plot.y_label = "share of cases below";
    std::vector<double> z;
    for (const Outcome& outcome : outcomes)
        z.push_back(outcome.z());
    std::sort(z.begin(), z.end());
    PlotCurve got;
    got.label = "fluovox";
    got.color = {0.1, 0.35, 0.7};
    for (std::size_t i = 0; i < z.size(); ++i) {
        got.x.push_back(z[i]);
        got.y.push_back((static_cast<double>(i) + 0.5) / static_cast<double>(z.size()));
    }
    PlotCurve normal;
    normal.label = "normal distribution";
    normal.dashed = true;
    for (int i = -35; i <= 35; ++i) {
        normal.x.push_back(0.1 * i);
        normal.y.push_back(boost::math::cdf(boost::math::normal(), 0.1 * i));
    }
    plot.curves = {got, normal};
    return plot;
}

std::string table_of(const std::vector<Outcome>& outcomes, bool sources) {
    std::string text =
        fmt::format("| case | expected | got | standard error | z |{}\n| --- | ---: | ---: | ---: | ---: |{}\n",
                    sources ? " precise in | source |" : "", sources ? " --- | --- |" : "");
    for (const Outcome& o : outcomes) {
        text += fmt::format("| {} | {:.6g} | {:.6g} | {:.2g} | {:+.2f} |", o.what->name, o.what->expected, o.got.value,
                            o.got.standard_error, o.z());
        text += sources ? fmt::format(" {} | {} |\n", o.precision(), o.what->source) : "\n";
    }
    return text;
}

void write_report(const fs::path& folder, const std::vector<Outcome>& outcomes, const std::vector<Outcome>& broken,
                  const Verdict& verdict, const PlotBook& plots) {
    std::string text =
        "# Validation\n\nEvery number below was found by others, or follows in closed form, or comes from the other of "
        "two estimators that share little; `tools/validate.sh` makes this page. Where many values are tested at once "
        "their chi-squared is given as the deviation of a normal distribution with the same probability.\n\n" +
        verdict_text(outcomes, verdict) +
        "\n\nThe standard error is asked to be at most 1e-3 of the value or 3e-4 of the light launched, whichever is "
        "larger; \"precise in\" says which of the two it keeps. Of a picture little of the light launched is seen: the "
        "share is given where it counts.\n\n![z of each case](validation-z.png)\n\n![all "
        "z](validation-normal.png)\n\n" +
        table_of(outcomes, true);
    if (!broken.empty()) {
        text += "\n## What it notices\n\nThe same cases with a mistake in them; each must lie beyond the bound.\n\n" +
                table_of(broken, false);
    }
    if (!plots.empty()) text += "\n## Spectra and beads\n\n";
    fs::create_directories(folder);
    for (const auto& [name, plot] : plots) {
        text += fmt::format("![{}]({}.png)\n\n", plot.title, name);
        save_plot(plot, folder / (name + ".png"));
    }
    save_plot(plot_of_z(outcomes, verdict.bound), folder / "validation-z.png");
    save_plot(plot_of_quantiles(outcomes), folder / "validation-normal.png");
    write_text_file(folder / "validation.md", text);
}

struct Request {
    fs::path folder = ".";
    std::string word;
    bool quick = false;
    std::uint64_t seed = 1;  ///< other random numbers for all cases
    SpreadSettings spread;
};

/// Some of every kind that a second is enough for.
bool is_quick(const std::string& name) {
    constexpr std::array kBegins = {"van de Hulst slab: a",
                                    "van de Hulst slab in voxels",
                                    "half space: a 0.5, tau inf, g 0, n 1, normal",
                                    "slab with index: a 0.5",
                                    "isotropic slab: a 0.9, tau 1",
                                    "Henyey-Greenstein slab: a 0.9, tau 4, g 0.9",
                                    "slab of index 1.4 between slides",
                                    "clear",
                                    "cascade in a half space, albedo 0.5",
                                    "90 degree cell, absorbance 1 and 0.1"};
    return std::any_of(kBegins.begin(), kBegins.end(), [&](const char* begin) { return name.starts_with(begin); });
}

void print_heading() {
    fmt::print("{:<88} {:>11} {:>11} {:>9} {:>6}   {}\n", "case", "expected", "got", "std.err.", "z", "precise in");
}

std::vector<Outcome> run_all(const std::vector<Case>& cases, const Request& request, std::uint64_t first_seed) {
    std::vector<Outcome> outcomes;
    std::uint64_t seed = first_seed;
    for (const Case& next : cases) {
        ++seed;
        if (next.name.find(request.word) == std::string::npos || (request.quick && !is_quick(next.name))) continue;
        const Outcome& o = outcomes.emplace_back(run(next, seed));
        fmt::print("{:<88} {:>11.6g} {:>11.6g} {:>9.2g} {:>+6.2f}   {}; {:.2g} photons, {:.1f} s\n", next.name,
                   next.expected, o.got.value, o.got.standard_error, o.z(), o.precision(),
                   static_cast<double>(o.photons), o.seconds);
        std::fflush(stdout);
    }
    return outcomes;
}

/// The same seeds for a case whether others run or not.
void print_spreads(const std::vector<Case>& cases, const Request& request) {
    const int runs = request.spread.runs;
    const double of_variance = std::sqrt(2.0 / (runs - 1));
    fmt::print("{:<88} {:>8} {:>8} {:>8}\n", "case", "variance", "z", "z^2");
    SpreadSettings settings = request.spread;
    settings.seed = 1000000 * request.seed;
    double variance = 0;
    int count = 0;
    for (const Case& next : cases) {
        settings.seed += 1000;
        if (next.name.find(request.word) == std::string::npos) continue;
        const Spread s = spread_of(next, settings);
        fmt::print("{:<88} {:>8.3f} {:>+8.3f} {:>8.3f}   {:.1f} s\n", next.name, s.variance, s.z, s.z_squared,
                   s.seconds);
        std::fflush(stdout);
        variance += s.variance;
        ++count;
    }
    fmt::print(
        "\nVariance between {} runs over what they tell: each +- {:.3f}, mean of {} cases {:.3f} +- {:.3f}. "
        "Mean z: +- {:.3f}. Mean z^2: +- {:.3f}\n",
        runs, of_variance, count, variance / count, of_variance / std::sqrt(count), 1 / std::sqrt(runs),
        std::sqrt(2.0 / runs));
}

int validate(const Request& request) {
    const auto plots = std::make_shared<PlotBook>();
    std::vector<Case> cases = slab_cases();
    for (auto more : {layer_cases, geometry_cases, body_cases, fluorescence_cases, ray_cases}) {
        for (Case& another : more())
            cases.push_back(std::move(another));
    }
    for (auto more : {image_cases, cache_cases}) {
        for (Case& another : more(plots))
            cases.push_back(std::move(another));
    }
    const auto begin = std::chrono::steady_clock::now();
    if (request.spread.runs > 0) {
        print_spreads(cases, request);
        return 0;
    }
    print_heading();
    const std::vector<Outcome> outcomes = run_all(cases, request, 100000 * (request.seed - 1) + 1);
    if (outcomes.empty()) throw UsageError("no case has \"" + request.word + "\" in its name");
    const Verdict verdict = judge(outcomes);
    fmt::print("\n{}\n", verdict_text(outcomes, verdict));

    // The mistakes are looked for in a whole run only.
    const std::vector<Case> mistakes = request.word.empty() ? broken_cases() : std::vector<Case>{};
    Request all = request;
    all.quick = false;
    if (!mistakes.empty()) fmt::print("\nWith a mistake in them, these must lie beyond the bound:\n");
    const std::vector<Outcome> broken = run_all(mistakes, all, 100000 * (request.seed - 1) + 9000);
    const auto missed = std::count_if(broken.begin(), broken.end(),
                                      [&](const Outcome& o) { return !(std::abs(o.z()) > verdict.bound); });
    if (!broken.empty())
        fmt::print("{} of {} mistakes noticed\n", broken.size() - static_cast<std::size_t>(missed), broken.size());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    fmt::print("{:.0f} s\n", seconds);
    write_report(request.folder, outcomes, broken, verdict, *plots);
    return verdict.passes() && missed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace fluovox::validation

int main(int argc, char** argv) {
    fluovox::validation::Request request;
    try {
        for (int i = 1; i < argc; ++i) {
            const std::string argument = argv[i];
            if (argument == "-o" && i + 1 < argc) {
                request.folder = argv[++i];
            } else if (argument == "--seed" && i + 1 < argc) {
                request.seed = std::stoull(argv[++i]);
            } else if (argument == "--spread" && i + 1 < argc) {
                request.spread.runs = std::max(2, std::stoi(argv[++i]));
            } else if (argument == "--share" && i + 1 < argc) {
                request.spread.share = std::stod(argv[++i]);
            } else if (argument == "--quick") {
                request.quick = true;
            } else {
                request.word = argument;
            }
        }
        return fluovox::validation::validate(request);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "fluovox_validate: error: %s\n", e.what());
        return 2;
    }
}
