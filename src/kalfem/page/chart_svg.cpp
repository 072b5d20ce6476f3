// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/chart_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>

#include "kalfem/base/text.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/page/typeset.hpp"

namespace kalfem {
namespace {

// Lengths are points, 1/72 inch, as font sizes are.
constexpr double points_per_cm = 72.0 / 2.54;
constexpr double font = 8.0, tick_length = 3.0, margin = 4.0, swatch = 16.0;
constexpr double glyph = 0.53 * font;      ///< width of a mean letter of Helvetica
constexpr std::size_t rows_per_point = 4;  ///< samples kept per point of width: finer than a printer's dots

struct Stroke {
  const char* colour;
  double width;
  const char* dashes;
};

/// As on the page (report.css, report.js), in its light colours.
Stroke stroke_of(Role role) {
  switch (role) {
    case Role::truth:
      return {"#1b2129", 0.8, "4 2.5"};
    case Role::estimate:
      return {"#0072b2", 1.1, ""};
    case Role::measured:
      return {"#98a2ad", 0.7, ""};
    case Role::predicted:
      return {"#d55e00", 1.1, ""};
    case Role::initial:
      return {"#a8508f", 1.0, "1.5 2"};
    case Role::limit:
      return {"#008f68", 0.9, "5 2 1.5 2"};
    case Role::other:
      break;
  }
  return {nullptr, 1.1, ""};
}

/// What is drawn first lies below: dashed curves end on top.
int layer_of(Role role) {
  constexpr Role order[] = {Role::measured, Role::other, Role::predicted, Role::estimate,
                            Role::initial,  Role::limit, Role::truth};
  return static_cast<int>(std::ranges::find(order, role) - std::begin(order));
}

/// One stroke a series: the first series of a role has its colour, the others take a free one.
std::vector<Stroke> strokes_of(const std::vector<Series>& series) {
  constexpr const char* free_colours[] = {"#b07800", "#6f4bb2", "#2b7a78", "#8c564b"};
  std::vector<Stroke> strokes;
  std::set<Role> taken;
  std::size_t next = 0;
  for (const auto& each : series) {
    Stroke stroke = stroke_of(each.role);
    if (!stroke.colour || !taken.insert(each.role).second)
      stroke.colour = free_colours[next++ % std::size(free_colours)];
    strokes.push_back(stroke);
  }
  return strokes;
}

/// A range of values on the paper. Labels are divided by a power of a thousand, so that they stay short.
struct Axis {
  AxisRange range{0.0, 1.0};
  double from = 0.0, to = 1.0;  ///< places of its ends on the paper
  std::vector<double> ticks = {};
  int exponent = 0;

  Axis(AxisRange values, double begin, double end, int most_ticks) : range(values), from(begin), to(end) {
    ticks = axis_ticks(range[0], range[1], most_ticks);
    const double size = std::max(std::abs(range[0]), std::abs(range[1]));
    if (size < 0.1 || size >= 1e4) exponent = 3 * static_cast<int>(std::floor(std::log10(size) / 3.0));
  }

  [[nodiscard]] double at(double value) const {
    return from + (to - from) * (value - range[0]) / (range[1] - range[0]);
  }
  [[nodiscard]] std::string label(double tick) const {
    std::string text = fmt::format("{:.6g}", tick / std::pow(10.0, exponent));
    if (text == "-0") text = "0";
    if (text.starts_with('-')) text.replace(0, 1, "\u2212");
    return text;
  }
};

/// "displacement [m]" with the power of ten that the labels are divided by: "displacement [10⁻³ m]".
std::string with_power(const std::string& label, int exponent) {
  if (exponent == 0) return label;
  constexpr const char* raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string power = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) power += raised[digit - '0'];
  const auto bracket = label.rfind('[');
  if (bracket == std::string::npos) return label + " [" + power + "]";
  const bool no_unit = label.substr(bracket) == "[-]";
  return label.substr(0, bracket + 1) + power + (no_unit ? "]" : " " + label.substr(bracket + 1));
}

/// Range of the finite ones among the values, with some room around them; at least as wide as rounding.
class Extent {
public:
  void take(double value) {
    if (!std::isfinite(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  [[nodiscard]] AxisRange range(double room) const {
    if (!(low_ <= high_)) return {0.0, 1.0};
    const double least = 1e-9 * std::max(std::abs(low_), std::abs(high_));
    const double width = high_ - low_ > least ? high_ - low_ : std::max(2.0 * least, 1e-12);
    return high_ - low_ > least ? AxisRange{low_ - room * width, high_ + room * width}
                                : AxisRange{low_ - width, high_ + width};
  }

private:
  double low_ = std::numeric_limits<double>::infinity(), high_ = -low_;
};

std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

/// Draws one chart.
class Drawing {
public:
  Drawing(const Chart& chart, const FigureSize& size)
      : chart_(chart),
        width_(size.width * points_per_cm),
        height_(size.height * points_per_cm),
        strokes_(strokes_of(chart.series)),
        legend_(legend()),
        x_(x_range(), left(), width_ - 2.5 * margin, std::max(2, static_cast<int>(width_ / 42.0))),
        y_(y_range(), height_ - bottom(), top(), std::max(2, static_cast<int>(height_ / 24.0))) {}

  [[nodiscard]] std::string document() const {
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.3f}cm\" height=\"{:.3f}cm\" viewBox=\"0 0 {:.2f} "
        "{:.2f}\" "
        "font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\" font-size=\"{}\" fill=\"#1b2129\">\n"
        "<title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        "<clipPath id=\"inside\"><rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/></clipPath>\n"
        "{}<g clip-path=\"url(#inside)\" fill=\"none\" stroke-linejoin=\"round\">\n{}</g>\n{}{}</svg>\n",
        width_ / points_per_cm, height_ / points_per_cm, width_, height_, font, escaped(chart_.title), x_.from, y_.to,
        x_.to - x_.from, y_.from - y_.to, grid(), curves(), axes(), legend_.svg);
  }

private:
  struct Legend {
    std::string svg;
    double height = 0.0;
  };

  [[nodiscard]] double left() const { return 42.0; }
  [[nodiscard]] double bottom() const { return 2.0 * font + tick_length + 3.0 * margin; }
  [[nodiscard]] double top() const { return legend_.height + 1.5 * margin; }

  [[nodiscard]] const std::vector<double>& abscissae(const Series& series) const {
    return chart_.scatter ? series.x : chart_.x;
  }

  [[nodiscard]] AxisRange x_range() const {
    if (chart_.x_window) return *chart_.x_window;
    Extent extent;
    for (const auto& series : chart_.series)
      for (const double x : abscissae(series)) extent.take(x);
    return extent.range(chart_.scatter ? 0.04 : 0.0);
  }

  [[nodiscard]] AxisRange y_range() const {
    if (chart_.y_window) return *chart_.y_window;
    const AxisRange shown = x_range();
    Extent extent;
    for (const auto& series : chart_.series)
      for (const auto* values : {&series.y, &series.lower, &series.upper})
        for (std::size_t k = 0; k < values->size(); ++k)
          if (const double x = abscissae(series)[k]; x >= shown[0] && x <= shown[1]) extent.take((*values)[k]);
    return extent.range(0.05);
  }

  /// The entries one beside the other, in as many lines as they need; none for a single curve.
  [[nodiscard]] Legend legend() const {
    Legend legend;
    if (chart_.series.size() < 2) return legend;
    const double begin = left(), line = font + 0.75 * margin;
    double x = begin, y = margin + 0.5 * font;
    for (std::size_t i = 0; i < chart_.series.size(); ++i) {
      const auto label = typeset(chart_.series[i].label);
      const double needed = swatch + margin + glyph * static_cast<double>(letters(label)) + 3.0 * margin;
      if (x > begin && x + needed > width_ - margin) x = begin, y += line;
      if (!chart_.series[i].lower.empty())
        legend.svg += fmt::format(
            "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{}\" height=\"{}\" fill=\"{}\" fill-opacity=\"0.2\"/>\n", x,
            y - 0.4 * font, swatch, 0.8 * font, strokes_[i].colour);
      legend.svg += fmt::format("<path d=\"M{:.2f} {:.2f}h{}\" {}/><text x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n", x, y,
                                swatch, pen(strokes_[i]), x + swatch + margin, y + 0.35 * font, escaped(label));
      x += needed;
    }
    legend.height = y + 0.5 * font;
    return legend;
  }

  static std::string pen(const Stroke& stroke) {
    const std::string dashes = *stroke.dashes == 0 ? "" : fmt::format(" stroke-dasharray=\"{}\"", stroke.dashes);
    return fmt::format("stroke=\"{}\" stroke-width=\"{}\"{}", stroke.colour, stroke.width, dashes);
  }

  [[nodiscard]] std::string grid() const {
    std::string lines;
    for (const double tick : x_.ticks) lines += fmt::format("M{:.2f} {:.2f}V{:.2f}", x_.at(tick), y_.from, y_.to);
    for (const double tick : y_.ticks) lines += fmt::format("M{:.2f} {:.2f}H{:.2f}", x_.from, y_.at(tick), x_.to);
    return "<path d=\"" + lines + "\" stroke=\"#e9ecef\" stroke-width=\"0.5\" fill=\"none\"/>\n";
  }

  [[nodiscard]] std::string axes() const {
    std::string lines = fmt::format("M{:.2f} {:.2f}V{:.2f}H{:.2f}", x_.from, y_.to, y_.from, x_.to), labels;
    for (const double tick : x_.ticks) {
      lines += fmt::format("M{:.2f} {:.2f}v{}", x_.at(tick), y_.from, tick_length);
      labels += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{}</text>\n", x_.at(tick),
                            y_.from + tick_length + margin + 0.6 * font, x_.label(tick));
    }
    for (const double tick : y_.ticks) {
      lines += fmt::format("M{:.2f} {:.2f}h-{}", x_.from, y_.at(tick), tick_length);
      labels += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"end\">{}</text>\n",
                            x_.from - tick_length - 0.5 * margin, y_.at(tick) + 0.35 * font, y_.label(tick));
    }
    labels += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{}</text>\n", 0.5 * (x_.from + x_.to),
                          height_ - margin, escaped(with_power(typeset(chart_.x_label), x_.exponent)));
    labels += fmt::format("<text transform=\"translate({:.2f} {:.2f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                          margin + 0.7 * font, 0.5 * (y_.from + y_.to),
                          escaped(with_power(typeset(chart_.y_label), y_.exponent)));
    return "<path d=\"" + lines + "\" stroke=\"#1b2129\" stroke-width=\"0.6\" fill=\"none\"/>\n" + labels;
  }

  [[nodiscard]] std::string curves() const {
    std::vector<std::size_t> order(chart_.series.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return layer_of(chart_.series[i].role); });
    std::string bands, lines;
    for (const std::size_t i : order) {
      const auto& series = chart_.series[i];
      const auto rows = rows_of(series);
      if (!series.lower.empty())
        bands +=
            fmt::format("<path d=\"{}\" fill=\"{}\" fill-opacity=\"0.2\"/>\n", band(series, rows), strokes_[i].colour);
      lines += fmt::format("<path d=\"{}\" {}/>\n", line(series, rows), pen(strokes_[i]));
    }
    return bands + lines;
  }

  /// The samples to draw: those of the window and one to either side, thinned.
  [[nodiscard]] std::vector<std::size_t> rows_of(const Series& series) const {
    const auto limit = rows_per_point * static_cast<std::size_t>(width_);
    if (chart_.scatter) {
      const std::span<const double> both[] = {series.x, series.y};
      return rows_to_draw(both, 0, series.y.size(), limit);
    }
    const auto& x = chart_.x;
    const auto first = std::ranges::lower_bound(x, x_.range[0]), last = std::ranges::upper_bound(x, x_.range[1]);
    const auto begin = static_cast<std::size_t>(first - x.begin()), end = static_cast<std::size_t>(last - x.begin());
    std::vector<std::span<const double>> all{series.y};
    if (!series.lower.empty()) all.insert(all.end(), {series.lower, series.upper});
    const std::size_t from = begin > 0 ? begin - 1 : 0, to = std::min(end + 1, x.size());
    return from < to ? rows_to_draw(all, from, to, limit) : std::vector<std::size_t>{};
  }

  [[nodiscard]] std::string line(const Series& series, const std::vector<std::size_t>& rows) const {
    const auto& x = abscissae(series);
    std::string path;
    bool drawing = false;
    for (const std::size_t k : rows) {
      const bool known = std::isfinite(x[k]) && std::isfinite(series.y[k]);
      if (known) path += point(drawing ? 'L' : 'M', x[k], series.y[k]);
      drawing = known;
    }
    return path;
  }

  /// For each stretch without a gap the lower edge there and the upper edge back.
  [[nodiscard]] std::string band(const Series& series, const std::vector<std::size_t>& rows) const {
    const auto known = [&](std::size_t k) { return std::isfinite(series.lower[k]) && std::isfinite(series.upper[k]); };
    std::string path;
    for (auto begin = rows.begin(); begin != rows.end();) {
      begin = std::find_if(begin, rows.end(), known);
      const auto end = std::find_if_not(begin, rows.end(), known);
      for (auto at = begin; at != end; ++at) path += point(at == begin ? 'M' : 'L', chart_.x[*at], series.lower[*at]);
      for (auto at = end; at != begin;) --at, path += point('L', chart_.x[*at], series.upper[*at]);
      if (begin != end) path += 'Z';
      begin = end;
    }
    return path;
  }

  /// Points far outside are drawn at twice the height, which renderers can hold.
  [[nodiscard]] std::string point(char verb, double x, double y) const {
    return fmt::format("{}{:.2f} {:.2f}", verb, std::clamp(x_.at(x), -width_, 2.0 * width_),
                       std::clamp(y_.at(y), -height_, 2.0 * height_));
  }

  const Chart& chart_;
  double width_, height_;
  std::vector<Stroke> strokes_;
  Legend legend_;
  Axis x_, y_;
};

}  // namespace

std::vector<double> axis_ticks(double low, double high, int most) {
  const double width = high - low;
  if (!(width > 0.0) || !std::isfinite(width) || most < 1) return {};
  double step = std::pow(10.0, std::floor(std::log10(width / most)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0, 20.0}) {
    const double first = std::ceil(low / (factor * step)), last = std::floor(high / (factor * step));
    if (last - first + 1.0 > most) continue;
    std::vector<double> ticks;
    for (double k = first; k <= last; k += 1.0) ticks.push_back(k * factor * step);
    return ticks;
  }
  return {};
}

std::string chart_svg(const Chart& chart, const FigureSize& size) { return Drawing(chart, size).document(); }

}  // namespace kalfem
