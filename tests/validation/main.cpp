// fluovox_validate [-o FOLDER] [WORD]: all cases, or those whose name holds WORD.

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/image/plot.h"

#include "validation/case.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
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

    bool passes() const { return outside == 0 && p_high > 0.001 && p_low > 0.001; }
};

Verdict judge(const std::vector<Outcome>& outcomes) {
    Verdict verdict;
    const auto n = static_cast<double>(outcomes.size());
    const double each = 1 - std::pow(1 - 0.01, 1 / n);
    verdict.bound = boost::math::quantile(boost::math::normal(), 1 - 0.5 * each);
    for (const Outcome& outcome : outcomes) {
        verdict.chi_squared += outcome.z() * outcome.z();
        if (!(std::abs(outcome.z()) <= verdict.bound)) ++verdict.outside;
    }
    const boost::math::chi_squared distribution(n);
    verdict.p_high = boost::math::cdf(boost::math::complement(distribution, verdict.chi_squared));
    verdict.p_low = boost::math::cdf(distribution, verdict.chi_squared);
    return verdict;
}

std::string verdict_text(const std::vector<Outcome>& outcomes, const Verdict& v) {
    return fmt::format(
        "{} cases; |z| may be up to {:.2f} (Sidak, 1 %); {} beyond. Chi-squared {:.1f} for {} values: p = {:.3f} "
        "above, "
        "{:.3f} below. {}",
        outcomes.size(), v.bound, v.outside, v.chi_squared, outcomes.size(), v.p_high, v.p_low,
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

void write_report(const fs::path& folder, const std::vector<Outcome>& outcomes, const Verdict& verdict) {
    std::string text =
        "# Validation\n\nEvery number below was found by others, or follows in closed form; `tools/validate.sh` "
        "makes this page.\n\n" +
        verdict_text(outcomes, verdict) +
        "\n\n![z of each case](validation-z.png)\n\n![all z](validation-normal.png)\n\n"
        "| case | expected | got | standard error | z | source |\n| --- | ---: | ---: | ---: | ---: | --- |\n";
    for (const Outcome& o : outcomes)
        text += fmt::format("| {} | {:.6g} | {:.6g} | {:.2g} | {:+.2f} | {} |\n", o.what->name, o.what->expected,
                            o.got.value, o.got.standard_error, o.z(), o.what->source);
    fs::create_directories(folder);
    save_plot(plot_of_z(outcomes, verdict.bound), folder / "validation-z.png");
    save_plot(plot_of_quantiles(outcomes), folder / "validation-normal.png");
    write_text_file(folder / "validation.md", text);
}

int validate(const fs::path& folder, const std::string& word) {
    std::vector<Case> cases = slab_cases();
    for (auto more : {geometry_cases, fluorescence_cases}) {
        for (Case& another : more())
            cases.push_back(std::move(another));
    }
    std::vector<Outcome> outcomes;
    fmt::print("{:<88} {:>11} {:>11} {:>9} {:>6}\n", "case", "expected", "got", "std.err.", "z");
    std::uint64_t seed = 1;
    double seconds = 0;
    for (const Case& next : cases) {
        ++seed;
        if (next.name.find(word) == std::string::npos) continue;
        const Outcome& o = outcomes.emplace_back(run(next, seed));
        seconds += o.seconds;
        fmt::print("{:<88} {:>11.6g} {:>11.6g} {:>9.2g} {:>+6.2f}   {:.2g} photons, {:.1f} s\n", next.name,
                   next.expected, o.got.value, o.got.standard_error, o.z(), static_cast<double>(o.photons), o.seconds);
        std::fflush(stdout);
    }
    if (outcomes.empty()) throw UsageError("no case has \"" + word + "\" in its name");
    const Verdict verdict = judge(outcomes);
    fmt::print("\n{}\n{:.0f} s\n", verdict_text(outcomes, verdict), seconds);
    write_report(folder, outcomes, verdict);
    return verdict.passes() ? 0 : 1;
}

}  // namespace
}  // namespace fluovox::validation

int main(int argc, char** argv) {
    std::filesystem::path folder = ".";
    std::string word;
    try {
        for (int i = 1; i < argc; ++i) {
            const std::string argument = argv[i];
            if (argument == "-o" && i + 1 < argc) {
                folder = argv[++i];
            } else {
                word = argument;
            }
        }
        return fluovox::validation::validate(folder, word);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "fluovox_validate: error: %s\n", e.what());
        return 2;
    }
}
