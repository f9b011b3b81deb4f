#include "fluovox/image/relative_error.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace fluovox {
namespace {

using Pixels = std::vector<std::pair<double, double>>;  // brightness, relative error

std::optional<double> median_error(const Pixels& pixels, std::size_t count) {
    std::vector<double> errors;
    for (std::size_t p = 0; p < std::min(count, pixels.size()); ++p)
        errors.push_back(pixels[p].second);
    if (errors.empty()) return std::nullopt;
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
}

}  // namespace

RelativeErrors relative_errors(const Film& film, int layer, BrightestOf tenth_of) {
    Pixels lit;
    for (int p = 0; p < film.pixels(); ++p) {
        const double mean = film.mean_of_all(layer, p);
        if (mean > 0 && film.count(p) > 1)
            lit.emplace_back(mean, std::sqrt(film.variance_of_mean_of_all(layer, p)) / mean);
    }
    std::sort(lit.begin(), lit.end(), std::greater<>());
    const std::size_t tenth = tenth_of == BrightestOf::LitPixels
                                  ? (lit.size() + 9) / 10
                                  : std::max(std::size_t{1}, static_cast<std::size_t>(film.pixels()) / 10);
    return {median_error(lit, lit.size()), median_error(lit, tenth)};
}

std::string relative_error_text(std::optional<double> error, bool has_light) {
    if (error) return fmt::format("{:.3g} %", 100 * *error);
    return has_light ? "unknown (one sample per pixel)" : "unknown (no light)";
}

}  // namespace fluovox
