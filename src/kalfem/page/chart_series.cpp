// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Scales all lists alike; the axis' label then.
std::string scale_alike(const std::vector<std::vector<double>*>& lists, const std::string& quantity,
                        const std::string& unit, const std::string& own = {}) {
  double largest = 0.0;
  for (const auto* list : lists)
    for (const double value : *list)
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  const DisplayUnit shown(unit, {largest}, own);
  for (auto* list : lists)
    for (double& value : *list) value = shown.scaled(value);
  return (quantity.empty() ? "" : quantity + " ") + "[" + shown.unit() + "]";
}

}  // namespace

std::vector<double> times(const Record& record) {
  std::vector<double> t(static_cast<std::size_t>(record.samples()));
  for (std::size_t k = 0; k < t.size(); ++k) t[k] = record.time(static_cast<Index>(k));
  return t;
}

Series with_band(const std::string& label, const VectorXd& mean, const VectorXd& deviation, Role role) {
  Series series{.label = label, .y = series_values(mean), .role = role};
  if (deviation.size() == 0) return series;
  const VectorXd width = normal_quantile(0.975) * deviation;
  series.lower = series_values(mean - width);
  series.upper = series_values(mean + width);
  return series;
}

Chart with_readable_ordinates(Chart chart, const std::string& quantity, const std::string& unit,
                              const std::string& own) {
  std::vector<std::vector<double>*> lists;
  for (auto& series : chart.series) lists.insert(lists.end(), {&series.y, &series.lower, &series.upper});
  chart.y_label = scale_alike(lists, quantity, unit, own);
  return chart;
}

Chart with_readable_abscissae(Chart chart, const std::string& quantity, const std::string& unit) {
  std::vector<std::vector<double>*> lists{&chart.x};
  for (auto& series : chart.series) lists.push_back(&series.x);
  chart.x_label = scale_alike(lists, quantity, unit);
  return chart;
}

}  // namespace kalfem
