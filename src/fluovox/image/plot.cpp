#include "fluovox/image/plot.h"

#include "fluovox/core/atomic_file.h"
#include "fluovox/core/error.h"
#include "fluovox/core/text.h"
#include "fluovox/image/plot_axis.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <stdexcept>
#include <string_view>

namespace fluovox {
namespace {

using Pen = std::unique_ptr<cairo_t, decltype(&cairo_destroy)>;
using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

constexpr Rgb kInk = {0.13, 0.13, 0.15};
constexpr Rgb kMuted = {0.38, 0.39, 0.42};
constexpr Rgb kGrid = {0.90, 0.90, 0.92};
constexpr double kStripHeight = 8;

/// Maps the plotted ranges to the rectangle of the axes, in pixels.
struct Frame2d {
    double left = 0, top = 0, right = 0, bottom = 0;
    std::pair<double, double> x_range, y_range;

    double x(double value) const {
        return left + (right - left) * (value - x_range.first) / (x_range.second - x_range.first);
    }
    double y(double value) const {
        return bottom - (bottom - top) * (value - y_range.first) / (y_range.second - y_range.first);
    }
};

void widen_if_empty(std::pair<double, double>& range) {
    if (range.second > range.first && std::isfinite(range.second - range.first)) return;
    const double middle = std::isfinite(range.first) ? range.first : 0;
    const double half = middle == 0 ? 0.5 : 0.5 * std::fabs(middle);
    range = {middle - half, middle + half};
}

Frame2d make_frame(const Plot& plot) {
    std::vector<double> xs;
    std::vector<double> ys = {0};
    for (const PlotCurve& curve : plot.curves) {
        if (curve.x.size() != curve.y.size() || (!curve.error.empty() && curve.error.size() != curve.x.size())) {
            throw std::logic_error("a curve needs as many y (and errors) as x");
        }
        xs.insert(xs.end(), curve.x.begin(), curve.x.end());
        for (std::size_t i = 0; i < curve.y.size(); ++i) {
            const double error = curve.error.empty() ? 0 : curve.error[i];
            ys.push_back(curve.y[i] + error);
            ys.push_back(curve.y[i] - error);
        }
    }
    Frame2d frame;
    const bool titled = !plot.title.empty() || !plot.subtitle.empty();
    frame.left = 72;
    frame.right = plot.width_px - 24;
    frame.top = titled ? 74 : 44;
    frame.bottom = plot.height_px - 58 - (plot.x_is_wavelength ? kStripHeight + 4 : 0);
    frame.x_range = plot.x_range.value_or(finite_range(xs));
    const auto [low, high] = finite_range(ys);
    frame.y_range =
        plot.y_range.value_or(std::pair{low < 0 ? low - 0.08 * (high - low) : 0, high + 0.1 * (high - low)});
    widen_if_empty(frame.x_range);
    widen_if_empty(frame.y_range);
    return frame;
}

void set_color(cairo_t* pen, const Rgb& color, double alpha = 1) {
    cairo_set_source_rgba(pen, color.r, color.g, color.b, alpha);
}

void set_font(cairo_t* pen, double size, bool bold = false) {
    cairo_select_font_face(pen, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(pen, size);
}

double text_width(cairo_t* pen, const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(pen, text.c_str(), &extents);
    return extents.x_advance;
}

/// Text whose baseline starts (`anchor` 0), is centred (0.5) or ends (1) at x.
void draw_text(cairo_t* pen, const std::string& text, double x, double y, double anchor) {
    cairo_move_to(pen, x - anchor * text_width(pen, text), y);
    cairo_show_text(pen, text.c_str());
}

void draw_line(cairo_t* pen, double x0, double y0, double x1, double y1) {
    cairo_move_to(pen, x0, y0);
    cairo_line_to(pen, x1, y1);
    cairo_stroke(pen);
}

/// Fills the current path with the colours of the wavelengths along x.
void fill_with_wavelengths(cairo_t* pen, const Frame2d& frame, double alpha) {
    const auto [from, to] = frame.x_range;
    cairo_pattern_t* gradient = cairo_pattern_create_linear(frame.left, 0, frame.right, 0);
    constexpr int kStops = 64;
    for (int i = 0; i <= kStops; ++i) {
        const double share = static_cast<double>(i) / kStops;
        const Rgb color = display_color(from + share * (to - from));
        cairo_pattern_add_color_stop_rgba(gradient, share, color.r, color.g, color.b, alpha);
    }
    cairo_set_source(pen, gradient);
    cairo_fill(pen);
    cairo_pattern_destroy(gradient);
}

void draw_axes(cairo_t* pen, const Plot& plot, const Frame2d& frame) {
    set_font(pen, 13);
    cairo_set_line_width(pen, 1);
    const AxisTicks y_ticks = axis_ticks(frame.y_range.first, frame.y_range.second, 6);
    for (std::size_t i = 0; i < y_ticks.at.size(); ++i) {
        const double y = frame.y(y_ticks.at[i]);
        set_color(pen, kGrid);
        draw_line(pen, frame.left, y, frame.right, y);
        set_color(pen, kMuted);
        draw_text(pen, y_ticks.labels[i], frame.left - 8, y + 4.5, 1);
    }
    double tick_top = frame.bottom;
    if (plot.x_is_wavelength) {
        cairo_rectangle(pen, frame.left, frame.bottom + 3, frame.right - frame.left, kStripHeight);
        fill_with_wavelengths(pen, frame, 1);
        tick_top += kStripHeight + 4;
    }
    const AxisTicks x_ticks = axis_ticks(frame.x_range.first, frame.x_range.second, 9);
    for (std::size_t i = 0; i < x_ticks.at.size(); ++i) {
        const double x = frame.x(x_ticks.at[i]);
        set_color(pen, kGrid);
        draw_line(pen, x, frame.top, x, frame.bottom);
        set_color(pen, kMuted);
        draw_line(pen, x, tick_top, x, tick_top + 5);
        draw_text(pen, x_ticks.labels[i], x, tick_top + 20, 0.5);
    }
    draw_line(pen, frame.left, frame.bottom, frame.right, frame.bottom);
    set_color(pen, kInk);
    draw_text(pen, plot.x_label, 0.5 * (frame.left + frame.right), plot.height_px - 12, 0.5);
    cairo_save(pen);
    cairo_translate(pen, 20, 0.5 * (frame.top + frame.bottom));
    cairo_rotate(pen, -std::acos(0.0));
    draw_text(pen, plot.y_label, 0, 0, 0.5);
    cairo_restore(pen);
}

/// The corners of the line through points `from` to `to` (of `offset` times the error above them), in pixels.
std::vector<std::pair<double, double>> corners(const PlotCurve& curve, const Frame2d& frame, std::size_t from,
                                               std::size_t to, double offset) {
    std::vector<std::pair<double, double>> points;
    for (std::size_t i = from; i < to; ++i) {
        const double error = curve.error.empty() ? 0 : curve.error[i];
        const double y = frame.y(curve.y[i] + offset * error);
        if (!curve.steps) {
            points.emplace_back(frame.x(curve.x[i]), y);
            continue;
        }
        const double here = curve.x[i];
        const double before = i > 0 ? curve.x[i - 1] : (i + 1 < curve.x.size() ? 2 * here - curve.x[i + 1] : here - 1);
        const double after = i + 1 < curve.x.size() ? curve.x[i + 1] : 2 * here - before;
        points.emplace_back(frame.x(0.5 * (before + here)), y);
        points.emplace_back(frame.x(0.5 * (here + after)), y);
    }
    return points;
}

void trace(cairo_t* pen, std::span<const std::pair<double, double>> points) {
    for (const auto& [x, y] : points)
        cairo_line_to(pen, x, y);
}

/// One stretch of a curve in which every value is finite.
void draw_stretch(cairo_t* pen, const Plot& plot, const PlotCurve& curve, const Frame2d& frame, std::size_t from,
                  std::size_t to) {
    const auto line = corners(curve, frame, from, to, 0);
    if (curve.filled) {
        const double zero = frame.y(std::clamp(0.0, frame.y_range.first, frame.y_range.second));
        cairo_move_to(pen, line.front().first, zero);
        trace(pen, line);
        cairo_line_to(pen, line.back().first, zero);
        cairo_close_path(pen);
        set_color(pen, curve.color, 0.15);
        plot.x_is_wavelength ? fill_with_wavelengths(pen, frame, 0.22) : cairo_fill(pen);
    }
    if (!curve.error.empty()) {
        const auto above = corners(curve, frame, from, to, 1);
        auto below = corners(curve, frame, from, to, -1);
        std::reverse(below.begin(), below.end());
        trace(pen, above);
        trace(pen, below);
        cairo_close_path(pen);
        set_color(pen, curve.color, 0.22);
        cairo_fill(pen);
    }
    trace(pen, line);
    set_color(pen, curve.color);
    cairo_stroke(pen);
}

void set_line(cairo_t* pen, const PlotCurve& curve) {
    constexpr std::array<double, 2> kDashes = {7, 4};
    cairo_set_line_width(pen, 2.2);
    cairo_set_line_join(pen, CAIRO_LINE_JOIN_ROUND);
    cairo_set_dash(pen, kDashes.data(), curve.dashed ? 2 : 0, 0);
}

void draw_curves(cairo_t* pen, const Plot& plot, const Frame2d& frame) {
    cairo_save(pen);
    cairo_rectangle(pen, frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top + 1);
    cairo_clip(pen);
    for (const PlotCurve& curve : plot.curves) {
        set_line(pen, curve);
        const auto drawable = [&](std::size_t i) {
            return std::isfinite(curve.x[i]) && std::isfinite(curve.y[i]) &&
                   (curve.error.empty() || std::isfinite(curve.error[i]));
        };
        for (std::size_t from = 0; from < curve.x.size();) {
            std::size_t to = from;
            while (to < curve.x.size() && drawable(to))
                ++to;
            if (to > from) draw_stretch(pen, plot, curve, frame, from, to);
            from = to + 1;
        }
    }
    cairo_restore(pen);
}

void draw_marks(cairo_t* pen, const Plot& plot, const Frame2d& frame) {
    set_font(pen, 13, true);
    for (const PlotMark& mark : plot.marks) {
        const double x = frame.x(mark.x);
        const double y = frame.y(mark.y);
        set_color(pen, mark.color);
        cairo_arc(pen, x, y, 3.5, 0, 4 * std::acos(0.0));
        cairo_fill(pen);
        const bool center = mark.side == PlotMark::Side::Center;
        const double away = center ? 0 : (mark.side == PlotMark::Side::Left ? -8 : 8);
        const double anchor = center ? 0.5 : (mark.side == PlotMark::Side::Left ? 1 : 0);
        draw_text(pen, mark.label, x + away, center ? y - 9 : y - 4, anchor);
    }
}

void draw_titles(cairo_t* pen, const Plot& plot, const Frame2d& frame) {
    set_font(pen, 20, true);
    set_color(pen, kInk);
    draw_text(pen, plot.title, frame.left, 32, 0);
    set_font(pen, 13);
    set_color(pen, kMuted);
    draw_text(pen, plot.subtitle, frame.left, 54, 0);
}

/// On the right above the axes, written from the right so that it never reaches into the curves.
void draw_legend(cairo_t* pen, const Plot& plot, const Frame2d& frame) {
    constexpr double kSample = 28;
    set_font(pen, 13);
    double x = frame.right;
    for (std::size_t i = plot.curves.size(); i-- > 0;) {
        const PlotCurve& curve = plot.curves[i];
        if (curve.label.empty()) continue;
        x -= text_width(pen, curve.label);
        set_color(pen, kInk);
        draw_text(pen, curve.label, x, 28, 0);
        x -= kSample + 7;
        set_line(pen, curve);
        set_color(pen, curve.color);
        draw_line(pen, x, 23.5, x + kSample, 23.5);
        x -= 22;
    }
    cairo_set_dash(pen, nullptr, 0, 0);
}

void draw(const Plot& plot, cairo_surface_t* surface, double scale) {
    const Pen pen(cairo_create(surface), cairo_destroy);
    cairo_scale(pen.get(), scale, scale);
    set_color(pen.get(), {1, 1, 1});
    cairo_paint(pen.get());
    const Frame2d frame = make_frame(plot);
    draw_axes(pen.get(), plot, frame);
    draw_curves(pen.get(), plot, frame);
    draw_marks(pen.get(), plot, frame);
    draw_titles(pen.get(), plot, frame);
    draw_legend(pen.get(), plot, frame);
    if (const cairo_status_t status = cairo_status(pen.get()); status != CAIRO_STATUS_SUCCESS) {
        throw OutputError(std::string("the plot could not be drawn: ") + cairo_status_to_string(status));
    }
}

cairo_status_t append(void* text, const unsigned char* bytes, unsigned int count) {
    static_cast<std::string*>(text)->append(static_cast<const char*>(static_cast<const void*>(bytes)), count);
    return CAIRO_STATUS_SUCCESS;
}

}  // namespace

std::string plot_svg(const Plot& plot) {
    std::string text;
    {
        const Surface surface(cairo_svg_surface_create_for_stream(append, &text, plot.width_px, plot.height_px),
                              cairo_surface_destroy);
        draw(plot, surface.get(), 1);
        cairo_surface_finish(surface.get());
    }
    // Cairo numbers the surfaces of the process here; the same plot must be the same text.
    constexpr std::string_view kName = "id=\"surface";
    if (const std::size_t at = text.find(kName); at != std::string::npos) {
        const std::size_t number = at + kName.size();
        text.erase(number, text.find('"', number) - number);
    }
    return text;
}

std::string plot_png(const Plot& plot) {
    constexpr int kScale = 2;
    const Surface surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, kScale * plot.width_px, kScale * plot.height_px),
        cairo_surface_destroy);
    draw(plot, surface.get(), kScale);
    std::string bytes;
    cairo_surface_write_to_png_stream(surface.get(), append, &bytes);
    return bytes;
}

bool is_plot_path(const std::filesystem::path& path) {
    const std::string ending = lower_case(path.extension().string());
    return ending == ".svg" || ending == ".png";
}

void save_plot(const Plot& plot, const std::filesystem::path& path) {
    if (!is_plot_path(path)) throw OutputError(path.string() + ": a plot's name must end in .svg or .png");
    write_text_file(path, lower_case(path.extension().string()) == ".svg" ? plot_svg(plot) : plot_png(plot));
}

}  // namespace fluovox
