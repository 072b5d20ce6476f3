// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/estimation/sensor_course.hpp"

#include <fmt/format.h>

#include "kalfem/base/text.hpp"

namespace kalfem {
namespace {

constexpr double width = 150.0, height = 24.0, bar_height = 16.0;

struct BarStyle {
  const char* colour;
  double part;  ///< of the full height
};

BarStyle style_of(Agreement agreement) {
  switch (agreement) {
    case Agreement::green:
      return {"--limit", 0.35};
    case Agreement::amber:
      return {"--other-1", 0.65};
    case Agreement::red:
      return {"--bad", 1.0};
    case Agreement::small:
      return {"--accent", 0.2};
    case Agreement::missing:
      break;
  }
  return {"--line", 0.1};
}

}  // namespace

std::string agreement_strip_svg(const SensorCourse& sensor, const std::string& chart_id) {
  const auto count = sensor.windows.size();
  std::string svg = fmt::format(
      "<svg width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"Agreement over time: as "
      "expected "
      "{2:.0f} %, too large {3:.0f} %, too small {4:.0f} %\">",
      width, height, 100.0 * sensor.share(Agreement::green),
      100.0 * (sensor.share(Agreement::amber) + sensor.share(Agreement::red)), 100.0 * sensor.share(Agreement::small));
  const double step = width / static_cast<double>(std::max<std::size_t>(1, count));
  for (std::size_t first = 0; first < count;) {  // equal neighbours are one bar
    std::size_t end = first;
    while (end < count && sensor.windows[end] == sensor.windows[first]) ++end;
    const auto [colour, part] = style_of(sensor.windows[first]);
    svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"var({})\"/>",
                       static_cast<double>(first) * step, height - part * bar_height,
                       static_cast<double>(end - first) * step, part * bar_height, colour);
    first = end;
  }
  const double at = (sensor.worst_time() - sensor.settled_at) / sensor.window_length * step;
  if (count > 0)
    svg += fmt::format(
        "<a href=\"#chart-{0}@{1:.6g}\" aria-label=\"the worst moment, {1:.4g} s\"><path d=\"M{2:.1f} 7l-5 "
        "-6h10z\" fill=\"var(--text)\"/></a>",
        escaped(chart_id), sensor.worst_time(), at);
  return svg + "</svg>";
}

}  // namespace kalfem
