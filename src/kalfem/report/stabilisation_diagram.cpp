// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/stabilisation_diagram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kalfem {
namespace {

constexpr double width = 760.0, height = 380.0, left = 52.0, right = 14.0, top = 26.0, bottom = 44.0;  // [pixel]

/// From frequency and order to the drawing.
class Axes {
public:
  explicit Axes(const ModalResult& result) : orders_(std::max(2, result.max_order)) {
    double highest = 0.0;
    for (const auto& pole : result.diagram) highest = std::max(highest, pole.frequency);
    for (const auto& mode : result.modes) modes_ = std::max(modes_, mode.frequency);
    // Poles far above the last mode squeeze all others.
    last_ = modes_ > 0.0 ? std::min(highest, 1.3 * modes_) : highest;
    if (last_ <= 0.0) last_ = 1.0;
  }

  [[nodiscard]] double x(double frequency) const { return left + (width - left - right) * frequency / last_; }
  [[nodiscard]] double y(double order) const { return height - bottom - (height - top - bottom) * order / orders_; }
  [[nodiscard]] bool shows(double frequency) const { return frequency <= last_; }

  [[nodiscard]] std::string svg() const {
    std::string out = fmt::format(
        "<path class=\"axis\" d=\"M{0:.1f} {1:.1f}V{2:.1f}H{3:.1f}\"/>\n<text x=\"{4:.1f}\" y=\"{5:.1f}\" "
        "text-anchor=\"middle\">frequency [Hz]</text>\n<text transform=\"translate(14 {6:.1f}) rotate(-90)\" "
        "text-anchor=\"middle\">order</text>\n",
        left, top, height - bottom, width - right, 0.5 * (left + width - right), height - 8.0,
        0.5 * (top + height - bottom));
    for (const double frequency : ticks(last_))
      out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:g}</text>\n", x(frequency),
                         height - bottom + 16.0, frequency);
    for (const double order : ticks(orders_))
      out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:g}</text>\n", left - 6.0,
                         y(order) + 4.0, order);
    return out;
  }

private:
  /// Round numbers from 0 on, four to eight of them.
  static std::vector<double> ticks(double last) {
    const double decade = std::pow(10.0, std::floor(std::log10(last)));
    const double step = last / decade >= 4.0 ? decade : last / decade >= 2.0 ? 0.5 * decade : 0.2 * decade;
    std::vector<double> all;
    for (int i = 0; i * step <= last * (1.0 + 1e-9); ++i) all.push_back(i * step);
    return all;
  }

  double orders_, modes_ = 0.0, last_ = 0.0;
};

std::string dot(const DiagramPole& pole, const Axes& axes) {
  const double x = axes.x(pole.frequency), y = axes.y(pole.order);
  if (!pole.stable) return fmt::format("<circle class=\"other\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"1.6\"/>\n", x, y);
  const double reach = axes.x(2.0 * pole.frequency_std) - axes.x(0.0);
  return fmt::format(
      "<path class=\"bar\" d=\"M{:.1f} {:.1f}H{:.1f}\"/><circle class=\"mode\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.6\">"
      "<title>order {}: {:.5g} +- {:.2g} Hz, damping {:.3g} %</title></circle>\n",
      x - reach, y, x + reach, x, y, pole.order, pole.frequency, pole.frequency_std, 100.0 * pole.damping);
}

}  // namespace

std::string stabilisation_svg(const ModalResult& result) {
  const Axes axes(result);
  std::string out = fmt::format(
      "<svg class=\"stabilisation\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" "
      "aria-label=\"Stabilisation diagram\" font-family=\"system-ui, sans-serif\" font-size=\"11.5\" "
      "style=\"max-width:{0:.0f}px\">\n<style>.stabilisation text{{fill:var(--muted,#5b6673)}}.stabilisation .axis,"
      ".stabilisation .line{{fill:none;stroke:var(--muted,#5b6673)}}.stabilisation .line{{stroke-opacity:.35}}"
      ".stabilisation .bar{{stroke:#0072b2;stroke-opacity:.5}}.stabilisation .mode{{fill:#0072b2}}"
      ".stabilisation .other{{fill:#999}}</style>\n",
      width, height);
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const double x = axes.x(result.modes[i].frequency);
    out += fmt::format(
        "<path class=\"line\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" "
        "text-anchor=\"middle\">{4}</text>\n",
        x, top, height - bottom, top - 6.0, i + 1);
  }
  for (const bool stable : {false, true})
    for (const auto& pole : result.diagram)
      if (pole.stable == stable && axes.shows(pole.frequency)) out += dot(pole, axes);
  return out + axes.svg() + "</svg>";
}

}  // namespace kalfem
