// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/steps/estimation/identified_connector.hpp"
#include "kalfem/steps/estimation/sections.hpp"

// The forces of connectors over time: what a strut gives, what a wheel presses on the ground.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::size_t most_charts = 12;

bool is_preload(const ConnectorDescription& connector) { return connector.law->name() == "preload"; }

bool is_ground(const Study& study, const std::string& point) {
  return point == "ground" || point.ends_with(".ground") ||
         std::ranges::any_of(study.structure->parts.inputs, [&](const auto& input) {
           return input.kind != InputKind::force && input.target == point;
         });
}

bool joins_ground(const Study& study, const ConnectorDescription& connector) {
  return is_ground(study, connector.from) || is_ground(study, connector.to);
}

/// A connector's force, and the constant forces of the preloads that join the same points: what it carries at rest.
struct ForceOverTime {
  std::string name;
  bool on_ground = false;
  PointQuantity force = {};
  std::optional<double> static_share = {};  ///< at the last estimate [N]
};

std::optional<double> preload_beside(const Study& study, const EstimationOutcome& outcome, const std::string& from,
                                     const std::string& to) {
  std::optional<double> sum;
  for (const auto& other : study.structure->parts.connectors) {
    if (!is_preload(other) || other.from != from || other.to != to) continue;
    const auto* force = connector_motion(outcome, other.name, ObservedQuantity::connector_force);
    if (force && force->mean.size() > 0) sum = sum.value_or(0.0) + force->mean[force->mean.size() - 1];
  }
  return sum;
}

double last_deviation(const EstimationOutcome& outcome, const std::string& unknown) {
  const auto& unknowns = outcome.augmented_model->options().unknowns;
  const auto at = std::ranges::find(unknowns, unknown, &UnknownParameter::name) - unknowns.begin();
  const auto& deviation = outcome.result.unknowns.deviation;
  return at == std::ssize(unknowns) || deviation.cols() == 0 ? 0.0 : deviation(at, deviation.cols() - 1);
}

/// f = k d + c v of a spring that stands for a connector because k or c is sought; its deviation from those of d, v, k
/// and c, as if these were independent.
PointQuantity force_of_spring(const EstimationOutcome& outcome, const std::string& name, Index connector) {
  const auto* deformation = connector_motion(outcome, name, ObservedQuantity::connector_deformation);
  const auto* rate = connector_motion(outcome, name, ObservedQuantity::connector_rate);
  const VectorXd parameters = IdentifiedConnector(outcome, connector).parameters();
  PointQuantity force{.point = name, .quantity = ObservedQuantity::connector_force};
  force.mean = parameters[0] * deformation->mean + parameters[1] * rate->mean;
  if (deformation->deviation.size() == force.mean.size())
    force.deviation = ((parameters[0] * deformation->deviation).array().square() +
                       (parameters[1] * rate->deviation).array().square() +
                       (last_deviation(outcome, name + ".stiffness") * deformation->mean).array().square() +
                       (last_deviation(outcome, name + ".damping") * rate->mean).array().square())
                          .sqrt();
  return force;
}

/// Springs of lumped substructures of which something is sought: struts, and tyres on their ground.
void add_springs(const Study& study, const EstimationOutcome& outcome, std::vector<ForceOverTime>& forces) {
  const auto& connectors = outcome.augmented_model->system().connectors;
  for (const auto& substructure : study.structure->parts.substructures)
    for (const auto& spring : substructure.springs) {
      const std::string name = substructure.name + "." + spring.name;
      const auto at = std::ranges::find(connectors, name, &Connector::name) - connectors.begin();
      const auto* motion = connector_motion(outcome, name, ObservedQuantity::connector_deformation);
      if (at == std::ssize(connectors) || !motion || motion->mean.size() <= outcome.settled) continue;
      forces.push_back(
          {name, spring.from == "ground" || spring.to == "ground", force_of_spring(outcome, name, at),
           preload_beside(study, outcome, substructure.name + "." + spring.from, substructure.name + "." + spring.to)});
    }
}

/// Of connectors with an unknown parameter, and of those that press on the ground.
std::vector<ForceOverTime> forces_of(const Study& study, const EstimationOutcome& outcome) {
  const auto& connectors = outcome.augmented_model->system().connectors;
  std::vector<ForceOverTime> forces;
  for (const auto& connector : study.structure->parts.connectors) {
    const auto* force = connector_motion(outcome, connector.name, ObservedQuantity::connector_force);
    if (is_preload(connector) || !force || force->mean.size() <= outcome.settled) continue;
    const auto index = std::ranges::find(connectors, connector.name, &Connector::name) - connectors.begin();
    const bool on_ground = joins_ground(study, connector);
    if (!on_ground && (index == std::ssize(connectors) || !has_unknown(outcome, index))) continue;
    forces.push_back({connector.name, on_ground, *force, preload_beside(study, outcome, connector.from, connector.to)});
  }
  add_springs(study, outcome, forces);
  return forces;
}

Chart force_chart(const EstimationOutcome& outcome, const ForceOverTime& each) {
  Chart chart{.id = each.name + "-force",
              .title = each.name + (each.on_ground ? ": force on the ground over time" : ": force over time"),
              .x_label = "time [s]",
              .x = times(outcome.measurements),
              .series = {with_band("estimated, 95 %", each.force.mean, each.force.deviation, Role::estimate)},
              .half_width = true};
  if (each.force.truth.size() > 0)
    chart.series.push_back({.label = "true", .y = series_values(each.force.truth), .role = Role::truth});
  if (each.static_share)
    chart.series.push_back({.label = "static share, not in the estimated force",
                            .y = std::vector<double>(chart.x.size(), *each.static_share),
                            .role = Role::limit});
  return with_readable_ordinates(std::move(chart), "force", "N");
}

/// Two digits of the deviation at the extreme.
std::string extreme_words(const ForceOverTime& each, const DisplayUnit& shown, Index settled, bool largest) {
  const auto& [mean, deviation] = std::tie(each.force.mean, each.force.deviation);
  Index at = 0;
  const VectorXd judged = mean.tail(mean.size() - settled);
  largest ? judged.maxCoeff(&at) : judged.minCoeff(&at);
  const double error = deviation.size() > 0 ? deviation[settled + at] : std::nan("");
  return shown.value(judged[at], error) + (error > 0.0 ? " ± " + shown.deviation(error) : "");
}

Table force_table(const std::vector<ForceOverTime>& forces, Index settled) {
  Table table{.title = "Forces after settling",
              .columns = {"connector", "unit", "smallest", "largest", "rms", "static share", "smallest with it",
                          "largest with it"},
              .caption = "Static share: the preload between the same points. Positive: the connector is stretched."};
  for (const auto& each : forces) {
    const VectorXd force = each.force.mean.tail(each.force.mean.size() - settled);
    const DisplayUnit shown("N", {force.cwiseAbs().maxCoeff()});
    const auto with_share = [&](double extreme) {
      return each.static_share ? shown.value(extreme + *each.static_share) : "-";
    };
    table.rows.push_back({each.name, shown.unit(), extreme_words(each, shown, settled, false),
                          extreme_words(each, shown, settled, true), shown.value(rms(force)),
                          each.static_share ? shown.value(*each.static_share) : "-", with_share(force.minCoeff()),
                          with_share(force.maxCoeff())});
  }
  if (std::ranges::none_of(forces, [](const auto& each) { return each.static_share.has_value(); }))
    table.caption = "Positive: the connector is stretched.";
  return without_empty_columns(std::move(table));
}

}  // namespace

void add_connector_forces(const Study& study, const EstimationOutcome& outcome, Section& section) {
  const auto forces = forces_of(study, outcome);
  if (forces.empty()) return;
  section.items.emplace_back(force_table(forces, outcome.settled));
  for (std::size_t i = 0; i < std::min(forces.size(), most_charts); ++i)
    section.items.emplace_back(force_chart(outcome, forces[i]));
}

}  // namespace kalfem
