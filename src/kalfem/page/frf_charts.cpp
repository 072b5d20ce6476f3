// SPDX-License-Identifier: Apache-2.0
#include "kalfem/page/frf_charts.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "kalfem/page/chart_series.hpp"

namespace kalfem {
namespace {

double decibels(const std::complex<double>& value) { return 20.0 * std::log10(std::abs(value)); }
double degrees(const std::complex<double>& value) { return std::arg(value) * 180.0 / std::numbers::pi; }

Chart chart(const std::string& id, const std::string& title, const std::string& y_label, const Eigen::VectorXd& lines,
            const std::vector<FrfSeries>& series, double (*value_of)(const std::complex<double>&)) {
  Chart chart{.id = id,
              .title = title,
              .x_label = "frequency [Hz]",
              .y_label = y_label,
              .x = series_values(lines),
              .half_width = true};
  for (const auto& [label, values, role] : series)
    chart.series.push_back({.label = label, .y = series_values(values.unaryExpr(value_of)), .role = role});
  return chart;
}

}  // namespace

Chart magnitude_chart(const FrfChartWords& words, const Eigen::VectorXd& lines, const std::vector<FrfSeries>& series) {
  return chart("frf-" + words.id, words.title, "magnitude [dB re 1 " + words.unit + "]", lines, series, decibels);
}

Chart phase_chart(const FrfChartWords& words, const Eigen::VectorXd& lines, const std::vector<FrfSeries>& series) {
  return chart("phase-" + words.id, words.title, "phase [°]", lines, series, degrees);
}

}  // namespace kalfem
