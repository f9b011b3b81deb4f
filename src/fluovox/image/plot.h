#pragma once

#include "fluovox/spectral/color.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fluovox {

/// One line of a plot.
struct PlotCurve {
    std::string label;               ///< for the legend; empty: none
    std::vector<double> x, y;        ///< equally many; a y that is not finite breaks the line
    std::vector<double> error = {};  ///< half height of a band around the line, one for each x, or empty
    Rgb color = {0.2, 0.2, 0.2};     ///< encoded sRGB, 0..1
    bool dashed = false;
    bool steps = false;   ///< constant around each x, as the bins of a spectrometer, instead of straight between them
    bool filled = false;  ///< the area down to zero is tinted: in the colours of the wavelengths where x is one
};

/// A point with a text beside it: a peak.
struct PlotMark {
    enum class Side { Left, Center, Right };

    double x = 0, y = 0;
    std::string label;
    Side side = Side::Center;  ///< where the text stands; above the point when Center
    Rgb color = {0.2, 0.2, 0.2};
};

/// A plot of curves over one axis.
struct Plot {
    std::string title;     ///< may be empty, as may every text here
    std::string subtitle;  ///< smaller, under the title
    std::string x_label, y_label;
    std::vector<PlotCurve> curves;
    std::vector<PlotMark> marks = {};
    std::optional<std::pair<double, double>> x_range = {};  ///< otherwise what the curves need
    std::optional<std::pair<double, double>> y_range =
        {};                               ///< otherwise from zero, or below, to above the highest value
    bool x_is_wavelength = false;         ///< x is in nm: a strip of its colours lies along the axis
    int width_px = 900, height_px = 520;  ///< of the SVG; a PNG has twice as many pixels each way
};

/// The plot as the text of an SVG file (without a script, date or external font).
std::string plot_svg(const Plot& plot);

/// The plot as the bytes of a PNG file.
std::string plot_png(const Plot& plot);

/// Whether `save_plot` knows the ending of `path`: .svg or .png.
bool is_plot_path(const std::filesystem::path& path);

/// Writes the plot as SVG or PNG, as the ending of `path` says (without regard to case), by `write_atomically`.
/// Throws OutputError, also for any other ending.
void save_plot(const Plot& plot, const std::filesystem::path& path);

}  // namespace fluovox
