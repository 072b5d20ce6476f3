// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/heat_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/base/text.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr double text_width = 6.6;  ///< of a character [pixel]
constexpr std::size_t longest_name = 26;

std::string shortened(const std::string& name) {
  if (name.size() <= longest_name) return name;
  std::size_t begin = name.size() - longest_name + 1;
  while (begin < name.size() && (static_cast<unsigned char>(name[begin]) & 0xC0U) == 0x80U) ++begin;
  return "…" + name.substr(begin);
}

double widest(const std::vector<std::string>& names) {
  std::size_t most = 0;
  for (const auto& name : names) most = std::max(most, std::min(name.size(), longest_name));
  return text_width * static_cast<double>(most) + 10.0;
}

class Drawing {
public:
  explicit Drawing(const HeatMap& map)
      : map_(map),
        cell_(std::clamp(520.0 / static_cast<double>(std::max<Index>(1, map.values.cols())), 12.0, 46.0)),
        left_(widest(map.rows) + (map.row_title.empty() ? 0.0 : 18.0)),
        top_(slanted() ? 0.72 * widest(map.columns) + 12.0 : 22.0),
        with_numbers_(cell_ >= 30.0) {
    if (!map.column_title.empty()) top_ += 18.0;
  }

  std::string svg() const {
    const double right = slanted() ? 0.72 * widest(map_.columns) : 8.0;
    const double width = left_ + cell_ * static_cast<double>(map_.values.cols()) + right;
    const double height = top_ + cell_ * static_cast<double>(map_.values.rows()) + 6.0;
    std::string out = fmt::format(
        "<svg class=\"heat-map\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" role=\"img\" "
        "aria-label=\"{2}\" font-family=\"system-ui, sans-serif\" font-size=\"11.5\" style=\"max-width:{0:.0f}px\">\n"
        "<style>.heat-map text{{fill:var(--text,#1b2129)}}.heat-map .on-dark{{fill:#fff}}.heat-map .on-light{{fill:"
        "#1b2129}}.heat-map .quiet{{fill:var(--muted,#5b6673)}}</style>\n",
        width, height, escaped(map_.name));
    for (Index i = 0; i < map_.values.rows(); ++i)
      for (Index j = 0; j < map_.values.cols(); ++j) out += square(i, j);
    return out + names() + "</svg>";
  }

private:
  [[nodiscard]] bool slanted() const { return widest(map_.columns) > cell_; }

  [[nodiscard]] std::string square(Index i, Index j) const {
    const double value = map_.values(i, j);
    if (!std::isfinite(value)) return "";
    const double x = left_ + cell_ * static_cast<double>(j), y = top_ + cell_ * static_cast<double>(i);
    const auto [colour, is_dark] = colour_of(value);
    std::string out = fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\">"
        "<title>{}, {}: {:.3f}</title></rect>",
        x, y, cell_ - 1.0, cell_ - 1.0, colour, escaped(name(map_.rows, i)), escaped(name(map_.columns, j)), value);
    if (with_numbers_)
      out += fmt::format("<text class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>",
                         is_dark ? "on-dark" : "on-light", x + 0.5 * cell_, y + 0.5 * cell_ + 4.0, in_digits(value));
    return out + "\n";
  }

  static std::string name(const std::vector<std::string>& names, Index k) { return names[static_cast<std::size_t>(k)]; }

  /// "0.97", "1", "-0.2": what fits into a square.
  static std::string in_digits(double value) {
    if (std::abs(value) >= 0.995) return value > 0.0 ? "1" : "−1";
    const std::string text = fmt::format("{:.2f}", std::abs(value));
    return (value <= -0.005 ? "−" : "") + text;
  }

  /// From white to blue, and to vermilion below zero: the two ends of the palette of Okabe and Ito.
  [[nodiscard]] std::pair<std::string, bool> colour_of(double value) const {
    const double part = std::clamp(std::abs(value), 0.0, 1.0);
    const bool below = map_.diverging && value < 0.0;
    const double end[3] = {below ? 178.0 : 0.0, below ? 72.0 : 96.0, below ? 0.0 : 156.0};
    const auto mixed = [&](int k) { return static_cast<int>(std::lround(246.0 + part * (end[k] - 246.0))); };
    return {fmt::format("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2)), part > 0.55};
  }

  [[nodiscard]] std::string names() const {
    std::string out;
    for (std::size_t i = 0; i < map_.rows.size(); ++i)
      out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", left_ - 6.0,
                         top_ + cell_ * (static_cast<double>(i) + 0.5) + 4.0, escaped(shortened(map_.rows[i])));
    for (std::size_t j = 0; j < map_.columns.size(); ++j) {
      const double x = left_ + cell_ * (static_cast<double>(j) + 0.5), y = top_ - 6.0;
      const std::string place = slanted() ? fmt::format("transform=\"translate({:.1f} {:.1f}) rotate(-45)\"", x, y)
                                          : fmt::format("x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\"", x, y);
      out += fmt::format("<text {}>{}</text>\n", place, escaped(shortened(map_.columns[j])));
    }
    const double across = left_ + 0.5 * cell_ * static_cast<double>(map_.values.cols());
    const double down = top_ + 0.5 * cell_ * static_cast<double>(map_.values.rows());
    if (!map_.column_title.empty())
      out += fmt::format("<text class=\"quiet\" x=\"{:.1f}\" y=\"12\" text-anchor=\"middle\">{}</text>\n", across,
                         escaped(map_.column_title));
    if (!map_.row_title.empty())
      out += fmt::format(
          "<text class=\"quiet\" transform=\"translate(12 {:.1f}) rotate(-90)\" text-anchor=\"middle\">"
          "{}</text>\n",
          down, escaped(map_.row_title));
    return out;
  }

  const HeatMap& map_;
  double cell_, left_, top_;
  bool with_numbers_;
};

}  // namespace

std::string heat_map_svg(const HeatMap& map) { return Drawing(map).svg(); }

}  // namespace kalfem
