// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/typeset.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/identified_connector.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/system/laws/law_library.hpp"
#include "kalfem/system/sensors/output_map.hpp"

// The law that a run is about, for the first screen: its force over velocity with what the sensors ask for, and its
// equation.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const Connector& connector_of(const EstimationOutcome& outcome, Index index) {
  return outcome.augmented_model->system().connectors[static_cast<std::size_t>(index)];
}

VectorXd settled(const EstimationOutcome& outcome, const std::string& name, ObservedQuantity quantity) {
  const auto& mean = connector_motion(outcome, name, quantity)->mean;
  return mean.tail(mean.size() - outcome.settled);
}

/// Of the connectors with an unknown parameter the one with the largest force; those that stand for lumped elements of
/// a substructure only where there are no others.
std::optional<Index> main_connector(const EstimationOutcome& outcome) {
  std::optional<Index> best;
  double largest = 0.0;
  bool best_is_change = true;
  for (Index j = 0; j < outcome.augmented_model->system().connector_count(); ++j) {
    const auto& connector = connector_of(outcome, j);
    if (connector.law->name() == "preload" || !has_unknown(outcome, j) ||
        !connector_motion(outcome, connector.name, ObservedQuantity::connector_force))
      continue;
    const bool is_change = connector.law->name() == "linear_change";
    const double size = rms(settled(outcome, connector.name, ObservedQuantity::connector_force));
    if (best && (is_change > best_is_change || (is_change == best_is_change && size <= largest))) continue;
    best = j, largest = size, best_is_change = is_change;
  }
  return best;
}

/// What each sample of the sensors asks for beyond a connector's estimated force: an acceleration or a force that was
/// measured feels the force at once, by g = F - S_a M^-1 b, so that innovations e ask for sum(g e / r) / sum(g^2 / r)
/// more of it. Empty where no sensor feels it at once.
VectorXd asked_force(const Study& study, const EstimationOutcome& outcome, Index index) {
  const auto& model = *study.augmented_model->model;
  const auto& system = model.system();
  if (system.size() != outcome.augmented_model->system().size()) return {};
  const VectorXd acceleration =
      -Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(system.mass).solve(connector_of(outcome, index).deformation);
  const Index samples = outcome.result.innovation.cols() - outcome.settled;
  VectorXd asked = VectorXd::Zero(samples), weight = VectorXd::Zero(samples);
  for (Index row = 0; row < outcome.result.innovation.rows(); ++row) {
    const auto& channel = outcome.measurements.channels[static_cast<std::size_t>(row)];
    const auto sensor = std::ranges::find(study.sensors, channel.name, &Sensor::name);
    if (sensor == study.sensors.end()) continue;
    const OutputMap map = make_outputs(model, {sensor->output});
    const double feels = (map.acceleration * acceleration)[0] + map.force(0, index);
    if (!(std::abs(feels) > 0.0) || !(channel.noise > 0.0)) continue;
    const VectorXd innovation = outcome.result.innovation.row(row).tail(samples).transpose();
    for (Index k = 0; k < samples; ++k) {
      if (!std::isfinite(innovation[k])) continue;
      asked[k] += feels * innovation[k] / (channel.noise * channel.noise);
      weight[k] += feels * feels / (channel.noise * channel.noise);
    }
  }
  if (!(weight.size() > 0 && weight.maxCoeff() > 0.0)) return {};
  return (weight.array() > 0.0).select(asked.array() / weight.array(), std::nan("")).matrix();
}

/// At most so many points, at equal distances in time.
VectorXd thinned(const VectorXd& values) {
  constexpr Index most = 1500;
  const Index stride = (values.size() + most - 1) / most,
              count = (values.size() + stride - 1) / std::max<Index>(1, stride);
  return values(Eigen::seqN(0, count, stride));
}

/// Whether a law without memory has any force that depends on the rate; a spring's points stand over its deformation.
bool resists_rate(const IdentifiedConnector& identified, const Connector& connector) {
  const VectorXd zero = VectorXd::Zero(3), rates = VectorXd::LinSpaced(3, -1.0, 1.0);
  const VectorXd force = force_of(*connector.law, identified.parameters(), zero, rates);
  return force.maxCoeff() > force.minCoeff();
}

constexpr Index curve_points = 61;

/// Force over rate: points along the record less the force at rest at the same deformation, and the law with its band
/// where it has no memory.
Chart force_chart(const Study& study, const EstimationOutcome& outcome, Index index) {
  const auto& connector = connector_of(outcome, index);
  const IdentifiedConnector identified(outcome, index);
  const bool memoryless = connector.law->states().empty(),
             over_rate = !memoryless || resists_rate(identified, connector);
  const VectorXd deformation = settled(outcome, connector.name, ObservedQuantity::connector_deformation),
                 rate = settled(outcome, connector.name, ObservedQuantity::connector_rate),
                 zero = VectorXd::Zero(curve_points);
  VectorXd points = settled(outcome, connector.name, ObservedQuantity::connector_force);
  if (memoryless && over_rate)
    points -= force_of(*connector.law, identified.parameters(), deformation, VectorXd::Zero(deformation.size()));
  const VectorXd asked = asked_force(study, outcome, index);
  if (asked.size() == points.size()) points += asked;
  const bool of_sensors = asked.size() > 0;
  Chart chart{.id = "law",
              .title = connector.name + (over_rate ? ": force over velocity" : ": force over deformation"),
              .caption = of_sensors ? "Each point is what the sensors of one sample ask for."
                                    : "Each point is an estimate: no sensor feels this force at once.",
              .series = {{.label = of_sensors ? "measured" : "estimated",
                          .y = series_values(thinned(points)),
                          .role = Role::measured,
                          .x = series_values(thinned(over_rate ? rate : deformation)),
                          .points = true}},
              .scatter = true};
  if (memoryless) {
    const double largest = std::max(1e-12, (over_rate ? rate : deformation).cwiseAbs().maxCoeff());
    const VectorXd x = VectorXd::LinSpaced(curve_points, -largest, largest);
    Series law = over_rate ? identified.curve(zero, x) : identified.curve(x, zero);
    law.label = "law, 95 %";
    law.x = series_values(x);
    chart.series.push_back(std::move(law));
    if (over_rate) chart.caption += " Without the force at rest at the same deformation.";
  }
  return with_readable_abscissae(with_readable_ordinates(std::move(chart), "force", "N"),
                                 over_rate ? "velocity" : "deformation", over_rate ? "m/s" : "m");
}

bool is_of_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The text with every name that stands alone replaced by what `value` gives for it, if it gives any.
template <typename Value>
std::string with_names_replaced(const std::string& text, const Value& value) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at;
    while (end < text.size() && is_of_name(text[end])) ++end;
    const std::string name = text.substr(at, std::max<std::size_t>(1, end - at));
    const std::optional<std::string> replacement = end > at ? value(name) : std::nullopt;
    result += replacement.value_or(name);
    at += name.size();
  }
  return result;
}

/// The equation without the terms whose first factor is a parameter that is zero.
template <typename IsZero>
std::string without_absent_terms(const std::string& equation, const IsZero& is_zero) {
  const std::string head = "f = ", plus = " + ";
  if (!equation.starts_with(head)) return equation;
  std::string kept;
  for (std::size_t begin = head.size(); begin < equation.size();) {
    const std::size_t end = std::min(equation.find(plus, begin), equation.size());
    const std::string term = equation.substr(begin, end - begin);
    const auto name_end = std::ranges::find_if_not(term, is_of_name);
    if (!is_zero(std::string(term.begin(), name_end))) kept += (kept.empty() ? "" : plus) + term;
    begin = end + plus.size();
  }
  return kept.empty() ? equation : head + kept;
}

/// The law as an equation, with names and with numbers; of a law whose equation does not name every parameter, its
/// parameters one by one.
std::optional<Listing> law_equation(const EstimationOutcome& outcome, Index index) {
  const auto& connector = connector_of(outcome, index);
  const auto library = law_library();
  const auto entry = std::ranges::find(library, connector.law->name(), &LawDescription::name);
  if (entry == library.end() || connector.law->name() == "linear_change") return std::nullopt;
  const VectorXd values = IdentifiedConnector(outcome, index).parameters();
  const auto& quantities = connector.law->parameters();
  const auto place = [&](const std::string& name) -> std::optional<Index> {
    const auto found = std::ranges::find(quantities, name, &LawQuantity::name);
    if (found == quantities.end()) return std::nullopt;
    return static_cast<Index>(found - quantities.begin());
  };
  const auto number = [&](const std::string& name) -> std::optional<std::string> {
    const auto at = place(name);
    if (!at) return std::nullopt;
    const DisplayUnit shown(quantities[static_cast<std::size_t>(*at)].unit, {values[*at]});
    const std::string unit = shown.unit() == "-" || shown.unit().empty() ? "" : " " + shown.unit();
    return shown.value(values[*at]) + unit;
  };
  const auto is_zero = [&](const std::string& name) {
    const auto at = place(name);
    return at && values[*at] == 0.0;
  };
  const std::string equation = without_absent_terms(entry->equation, is_zero);
  std::string text = connector.law->name() == "expression" ? "" : equation, numbers;
  bool complete = true;
  for (const auto& quantity : quantities) {
    if (is_zero(quantity.name)) continue;
    bool named = false;
    with_names_replaced(equation, [&](const std::string& name) {
      named |= name == quantity.name;
      return std::optional<std::string>();
    });
    complete &= named;
    numbers += fmt::format("{}{} = {}", numbers.empty() ? "" : "\n", quantity.name, *number(quantity.name));
  }
  const bool short_enough = std::ranges::count(numbers, '\n') < 5 && equation.find(';') == std::string::npos;
  const auto multiplied = [&](const std::string& name) -> std::optional<std::string> {
    auto value = number(name);
    if (value) *value = "(" + *value + ")";
    return value;
  };
  if (complete && short_enough)
    text += "\n" + with_names_replaced(equation, multiplied);
  else
    text += (text.empty() ? "" : "\n") + numbers;
  return Listing{.title = "The law of " + connector.name,
                 .text = typeset(text),
                 .folded = false,
                 .caption = "f: force, d: deformation, v: its rate. Further laws stand under Connectors."};
}

}  // namespace

std::optional<LawCurve> law_curve(const EstimationOutcome& outcome) {
  const auto index = main_connector(outcome);
  if (!index || !connector_of(outcome, *index).law->states().empty()) return std::nullopt;
  const auto& connector = connector_of(outcome, *index);
  const IdentifiedConnector identified(outcome, *index);
  LawCurve curve{.connector = connector.name, .over_rate = resists_rate(identified, connector)};
  const VectorXd visited =
      settled(outcome, connector.name,
              curve.over_rate ? ObservedQuantity::connector_rate : ObservedQuantity::connector_deformation);
  if (visited.size() == 0 || !(visited.cwiseAbs().maxCoeff() > 0.0)) return std::nullopt;
  const double largest = visited.cwiseAbs().maxCoeff();
  curve.abscissa = VectorXd::LinSpaced(curve_points, -largest, largest);
  const VectorXd zero = VectorXd::Zero(curve_points);
  const Series law = curve.over_rate ? identified.curve(zero, curve.abscissa) : identified.curve(curve.abscissa, zero);
  const auto values = [](const std::vector<double>& list) {
    return VectorXd(Eigen::Map<const VectorXd>(list.data(), static_cast<Index>(list.size())));
  };
  curve.force = values(law.y);
  if (!law.upper.empty()) curve.deviation = (values(law.upper) - values(law.lower)) / (2.0 * normal_quantile(0.975));
  return curve;
}

LawOverview law_overview(const Study& study, const EstimationOutcome& outcome) {
  if (!outcome.has_samples()) return {};
  const auto index = main_connector(outcome);
  if (!index) return {};
  return {force_chart(study, outcome, *index), law_equation(outcome, *index)};
}

}  // namespace kalfem
