// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/identified_connector.hpp"
#include "kalfem/steps/estimation/sections.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index curve_points = 201;

const Connector* true_connector(const Study& study, const std::string& name) {
  if (!study.simulation) return nullptr;
  const auto& connectors = study.model->system().connectors;
  const auto found = std::ranges::find(connectors, name, &Connector::name);
  return found == connectors.end() ? nullptr : &*found;
}

/// How often the connector was at each abscissa after settling, as an area of a quarter of the chart's height along
/// its lower edge. The law is known only where the data were.
Series data_share(const VectorXd& x, const VectorXd& visited, const std::vector<Series>& curves) {
  double low = 0.0, high = 0.0;
  for (const auto& curve : curves)
    for (const auto* values : {&curve.y, &curve.lower, &curve.upper})
      for (const double value : *values) low = std::min(low, value), high = std::max(high, value);
  VectorXd counts = VectorXd::Zero(x.size());
  const double step = x[1] - x[0];
  for (const double value : visited)
    if (std::isfinite(value)) counts[std::clamp<Index>(std::lround((value - x[0]) / step), 0, x.size() - 1)] += 1.0;
  VectorXd smooth = counts;  // over five neighbours: a histogram of fewer, wider bins
  for (Index k = 2; k + 2 < counts.size(); ++k) smooth[k] = counts.segment(k - 2, 5).mean();
  const double height = 0.25 * (high - low) / std::max(1.0, smooth.maxCoeff());
  const VectorXd upper = (low + height * smooth.array()).matrix();
  return {.label = "where the data were",
          .y = series_values(upper),
          .lower = std::vector<double>(static_cast<std::size_t>(x.size()), low),
          .upper = series_values(upper),
          .role = Role::measured};
}

Chart characteristic(const Study& study, const EstimationOutcome& outcome, Index index, bool over_rate) {
  const auto& connector = outcome.augmented_model->system().connectors[static_cast<std::size_t>(index)];
  const auto* range = connector_motion(
      outcome, connector.name, over_rate ? ObservedQuantity::connector_rate : ObservedQuantity::connector_deformation);
  const double largest = std::max(1e-12, range->mean.tail(range->mean.size() - outcome.settled).cwiseAbs().maxCoeff());
  const VectorXd x = VectorXd::LinSpaced(curve_points, -largest, largest), zero = VectorXd::Zero(curve_points);
  const VectorXd &deformation = over_rate ? zero : x, &rate = over_rate ? x : zero;
  Chart chart{.id = connector.name + (over_rate ? "-damper" : "-spring"),
              .title = connector.name + (over_rate ? ": force over rate" : ": force over deformation"),
              .caption = std::string(over_rate ? "At zero deformation." : "At rest.") +
                         " The grey area: how often the connector was there. Elsewhere the law is extrapolated.",
              .x = series_values(x),
              .series = {IdentifiedConnector(outcome, index).curve(deformation, rate)},
              .half_width = true};
  if (const auto* truth = true_connector(study, connector.name))
    chart.series.push_back({.label = "true",
                            .y = series_values(force_of(*truth->law, truth->parameters, deformation, rate)),
                            .role = Role::truth});
  chart.series.push_back(data_share(x, range->mean.tail(range->mean.size() - outcome.settled), chart.series));
  return with_readable_abscissae(with_readable_ordinates(std::move(chart), "force", "N"),
                                 over_rate ? "deformation rate" : "deformation", over_rate ? "m/s" : "m");
}

/// Force over deformation as it went, over the last part of the record.
Chart path(const EstimationOutcome& outcome, const std::string& name) {
  const auto *force_history = connector_motion(outcome, name, ObservedQuantity::connector_force),
             *deformation = connector_motion(outcome, name, ObservedQuantity::connector_deformation);
  const Index count = std::min<Index>(2000, force_history->mean.size() - outcome.settled);
  Chart chart{.id = name + "-path",
              .title = name + ": path",
              .caption = "The last part of the record.",
              .series = {{.label = "estimated",
                          .y = series_values(force_history->mean.tail(count)),
                          .role = Role::estimate,
                          .x = series_values(deformation->mean.tail(count))}},
              .scatter = true};
  if (force_history->truth.size() > 0 && deformation->truth.size() > 0)
    chart.series.push_back({.label = "true",
                            .y = series_values(force_history->truth.tail(count)),
                            .role = Role::truth,
                            .x = series_values(deformation->truth.tail(count))});
  return with_readable_abscissae(with_readable_ordinates(std::move(chart), "force", "N"), "deformation", "m");
}

/// How often the connector stood at each deformation after settling: the share of the time by bins of equal width.
Chart stroke_chart(const EstimationOutcome& outcome, const std::string& name) {
  constexpr Index bins = 40;
  const auto* deformation = connector_motion(outcome, name, ObservedQuantity::connector_deformation);
  const VectorXd stroke = deformation->mean.tail(deformation->mean.size() - outcome.settled);
  const double low = stroke.minCoeff(), width = std::max(stroke.maxCoeff() - low, 1e-12) / bins;
  VectorXd share = VectorXd::Zero(bins);
  for (const double value : stroke)
    share[std::clamp<Index>(static_cast<Index>((value - low) / width), 0, bins - 1)] +=
        100.0 / static_cast<double>(stroke.size());
  Series outline{.label = "estimated", .y = {0.0}, .role = Role::estimate, .x = {low}};
  for (Index b = 0; b < bins; ++b) {
    const double from = low + static_cast<double>(b) * width;
    outline.x.insert(outline.x.end(), {from, from + width});
    outline.y.insert(outline.y.end(), {share[b], share[b]});
  }
  outline.x.push_back(low + bins * width);
  outline.y.push_back(0.0);
  return with_readable_abscissae({.id = name + "-stroke",
                                  .title = name + ": stroke",
                                  .caption = "Share of the time after settling.",
                                  .y_label = "time [%]",
                                  .series = {std::move(outline)},
                                  .scatter = true},
                                 "deformation", "m");
}

/// Part of a connector's force that no spring and dashpot explain: rms(f - k d - c v) / rms(f) of the best k and c.
double nonlinear_share(const VectorXd& force, const VectorXd& deformation, const VectorXd& rate) {
  MatrixXd motion(force.size(), 2);
  motion << deformation, rate;
  const VectorXd scale = motion.colwise().norm().cwiseMax(1e-300).transpose();
  const MatrixXd scaled = motion * scale.cwiseInverse().asDiagonal();
  const VectorXd linear = scaled * scaled.colPivHouseholderQr().solve(force);
  return force.norm() > 0.0 ? (force - linear).norm() / force.norm() : 0.0;
}

/// Size of motion and force of a connector after settling.
std::vector<std::string> size_row(const EstimationOutcome& outcome, const std::string& name) {
  const auto settled = [&](ObservedQuantity quantity) -> VectorXd {
    const auto& mean = connector_motion(outcome, name, quantity)->mean;
    return mean.tail(mean.size() - outcome.settled);
  };
  const VectorXd force = settled(ObservedQuantity::connector_force),
                 deformation = settled(ObservedQuantity::connector_deformation),
                 rate = settled(ObservedQuantity::connector_rate);
  const auto with_unit = [](double value, const char* unit) {
    const DisplayUnit shown(unit, {value});
    return shown.value(value) + " " + shown.unit();
  };
  return {name, with_unit(rms(force), "N"), with_unit(rms(deformation), "m"), with_unit(rms(rate), "m/s"),
          per_cent(nonlinear_share(force, deformation, rate))};
}

/// Whether there is a deformation to show: not of a load alone, nor of a mass, which is a change of inertia.
bool moves(const EstimationOutcome& outcome, const Connector& connector) {
  if (connector.law->name() == "preload" || connector.name.ends_with(".mass")) return false;
  const auto* deformation = connector_motion(outcome, connector.name, ObservedQuantity::connector_deformation);
  return deformation && deformation->mean.size() > outcome.settled;
}

}  // namespace

Section connectors_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{"Connectors", "", {}};
  Table sizes{.title = "Rms after settling",
              .columns = {"connector", "force", "deformation", "rate", "nonlinear share of the force"},
              .caption = "Nonlinear share: the part of the force that no linear spring and dashpot explain."};
  std::vector<Chart> charts;
  const auto& connectors = outcome.augmented_model->system().connectors;
  for (std::size_t j = 0; j < connectors.size(); ++j) {
    if (!has_unknown(outcome, static_cast<Index>(j)) || !moves(outcome, connectors[j])) continue;
    // Of a lumped element the connector is only the change from its stated value: no law to show.
    const bool is_change = connectors[j].law->name() == "linear_change";
    if (!is_change) sizes.rows.push_back(size_row(outcome, connectors[j].name));
    if (!is_change && connectors[j].law->states().empty()) {
      charts.push_back(characteristic(study, outcome, static_cast<Index>(j), false));
      charts.push_back(characteristic(study, outcome, static_cast<Index>(j), true));
    }
    if (!is_change) charts.push_back(path(outcome, connectors[j].name));
    charts.push_back(stroke_chart(outcome, connectors[j].name));
  }
  add_connector_forces(study, outcome, section);
  if (charts.empty()) return section;
  section.text = "Forces over time, and the identified laws.";
  if (!sizes.rows.empty()) section.items.emplace_back(std::move(sizes));
  std::ranges::move(charts, std::back_inserter(section.items));
  return section;
}

}  // namespace kalfem
