#include "kalfem/report/sections.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "kalfem/report/updating_tables.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index curve_points = 201;

/// Force of a law without memory at given deformations and rates.
VectorXd force(const ConnectorLaw& law, const VectorXd& parameters, const VectorXd& deformation, const VectorXd& rate) {
  const Index n = deformation.size();
  const ArrayXXd p = parameters.transpose().array().replicate(n, 1), none = ArrayXXd::Zero(n, 0);
  const ArrayXd d = deformation.array(), v = rate.array(), zero = ArrayXd::Zero(n);
  ArrayXd f(n), k(n), c(n), b(n);
  ArrayXXd states(n, 0);
  law.respond({0.0, p, d, v, none, d, v, zero}, {f, k, c, b, states});
  return f.matrix();
}

/// Parameters of one connector in the augmented model as a function of the unknowns' states.
class IdentifiedConnector {
public:
  IdentifiedConnector(const EstimationOutcome& outcome, Index connector) : outcome_(outcome), connector_(connector) {
    const auto& layout = outcome.augmented_model->layout();
    last_ = outcome.result.state.mean.cols() - 1;
    state_ = outcome.result.state.mean.col(last_).segment(layout.unknown(), layout.unknowns);
    covariance_ =
        outcome.result.final_covariance.block(layout.unknown(), layout.unknown(), layout.unknowns, layout.unknowns);
  }

  [[nodiscard]] VectorXd parameters(const VectorXd& state) const {
    VectorXd values = outcome_.augmented_model->system().connectors[static_cast<std::size_t>(connector_)].parameters;
    const auto& unknowns = outcome_.augmented_model->options().unknowns;
    for (std::size_t i = 0; i < unknowns.size(); ++i)
      for (const auto& target : unknowns[i].targets)
        if (target.connector == connector_)
          values[target.parameter] = unknowns[i].transform.to_parameter(state[static_cast<Index>(i)]);
    return values;
  }

  /// Curve with the band that the parameters' covariance gives to first order.
  [[nodiscard]] Series curve(const VectorXd& deformation, const VectorXd& rate) const {
    const auto& law = *outcome_.augmented_model->system().connectors[static_cast<std::size_t>(connector_)].law;
    const VectorXd mean = force(law, parameters(state_), deformation, rate);
    MatrixXd slope(mean.size(), state_.size());
    for (Index i = 0; i < state_.size(); ++i) {
      const double step = 1e-3 * std::sqrt(std::max(covariance_(i, i), 1e-300));
      VectorXd shifted = state_;
      shifted[i] += step;
      slope.col(i) = (force(law, parameters(shifted), deformation, rate) - mean) / step;
    }
    const VectorXd width =
        normal_quantile(0.975) * ((slope * covariance_).cwiseProduct(slope)).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
    return {.label = "identified, 95 %",
            .y = series_values(mean),
            .lower = series_values(mean - width),
            .upper = series_values(mean + width),
            .role = Role::estimate};
  }

private:
  const EstimationOutcome& outcome_;
  Index connector_, last_ = 0;
  VectorXd state_;
  MatrixXd covariance_;
};

const PointQuantity* find(const EstimationOutcome& outcome, const std::string& name, ObservedQuantity quantity) {
  const auto found =
      std::ranges::find_if(outcome.points, [&](const auto& p) { return p.point == name && p.quantity == quantity; });
  return found == outcome.points.end() ? nullptr : &*found;
}

const Connector* true_connector(const Study& study, const std::string& name) {
  if (!study.simulation) return nullptr;
  const auto& connectors = study.model->system().connectors;
  const auto found = std::ranges::find(connectors, name, &Connector::name);
  return found == connectors.end() ? nullptr : &*found;
}

Chart characteristic(const Study& study, const EstimationOutcome& outcome, Index index, bool over_rate) {
  const auto& connector = outcome.augmented_model->system().connectors[static_cast<std::size_t>(index)];
  const auto* range = find(outcome, connector.name,
                           over_rate ? ObservedQuantity::connector_rate : ObservedQuantity::connector_deformation);
  const double largest = std::max(1e-12, range->mean.tail(range->mean.size() - outcome.settled).cwiseAbs().maxCoeff());
  const VectorXd x = VectorXd::LinSpaced(curve_points, -largest, largest), zero = VectorXd::Zero(curve_points);
  const VectorXd &deformation = over_rate ? zero : x, &rate = over_rate ? x : zero;
  Chart chart{.id = connector.name + (over_rate ? "-damper" : "-spring"),
              .title = connector.name + (over_rate ? ": force over rate" : ": force over deformation"),
              .caption = over_rate ? "At zero deformation." : "At rest.",
              .x_label = over_rate ? "deformation rate [m/s]" : "deformation [m]",
              .y_label = "force [N]",
              .x = series_values(x),
              .series = {IdentifiedConnector(outcome, index).curve(deformation, rate)},
              .half_width = true};
  if (const auto* truth = true_connector(study, connector.name))
    chart.series.push_back({.label = "true",
                            .y = series_values(force(*truth->law, truth->parameters, deformation, rate)),
                            .role = Role::truth});
  return chart;
}

/// Force over deformation as it went, over the last part of the record.
Chart path(const EstimationOutcome& outcome, const std::string& name) {
  const auto *force_history = find(outcome, name, ObservedQuantity::connector_force),
             *deformation = find(outcome, name, ObservedQuantity::connector_deformation);
  const Index count = std::min<Index>(2000, force_history->mean.size() - outcome.settled);
  Chart chart{.id = name + "-path",
              .title = name + ": path",
              .caption = "The last part of the record.",
              .x_label = "deformation [m]",
              .y_label = "force [N]",
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
  return chart;
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

Section connectors_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{"Connectors", "The identified laws.", {}};
  const auto& connectors = outcome.augmented_model->system().connectors;
  for (std::size_t j = 0; j < connectors.size(); ++j) {
    const bool unknown = std::ranges::any_of(outcome.augmented_model->options().unknowns, [&](const auto& each) {
      return std::ranges::any_of(each.targets,
                                 [&](const auto& target) { return target.connector == static_cast<Index>(j); });
    });
    if (!unknown) continue;
    if (connectors[j].law->states().empty()) {
      section.items.emplace_back(characteristic(study, outcome, static_cast<Index>(j), false));
      section.items.emplace_back(characteristic(study, outcome, static_cast<Index>(j), true));
    }
    section.items.emplace_back(path(outcome, connectors[j].name));
  }
  return section;
}

namespace {

std::vector<double> list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

/// The parameters of every iteration, relative to their initial values.
Chart trace_chart(const Study& study, const UpdatingOutcome& outcome) {
  Chart chart{.id = "updating-trace",
              .title = "Parameters by iteration",
              .caption = "Accepted values, relative to the initial values.",
              .x_label = "iteration",
              .y_label = "value / initial [-]"};
  for (std::size_t k = 0; k < outcome.trace.size(); ++k) chart.x.push_back(static_cast<double>(k + 1));
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    Series series{.label = parameter.name, .role = Role::other};
    for (const auto& step : outcome.trace)
      series.y.push_back(step.parameters[static_cast<Index>(i)] / parameter.scale());
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart residual_chart(const UpdatingOutcome& outcome) {
  Chart chart{
      .id = "updating-residual", .title = "Residual by iteration", .x_label = "iteration", .y_label = "rms [std]"};
  Series series{.label = "accepted", .role = Role::estimate};
  for (std::size_t k = 0; k < outcome.trace.size(); ++k) {
    chart.x.push_back(static_cast<double>(k + 1));
    series.y.push_back(outcome.trace[k].residual);
  }
  chart.series.push_back(std::move(series));
  return chart;
}

std::vector<double> decibels(const Eigen::VectorXd& magnitudes) {
  std::vector<double> values;
  for (const double value : magnitudes) values.push_back(20.0 * std::log10(value));
  return values;
}

Chart response_chart(const std::string& comparison, const FrfCurve& curve, std::size_t number) {
  return {.id = fmt::format("frf-{}-{}", comparison, number),
          .title = curve.name,
          .x_label = "frequency [Hz]",
          .y_label = "magnitude [dB re SI]",
          .x = list(curve.lines),
          .series = {{.label = "measured", .y = decibels(curve.measured), .role = Role::measured},
                     {.label = "before", .y = decibels(curve.before), .role = Role::predicted},
                     {.label = "after", .y = decibels(curve.after), .role = Role::estimate}},
          .half_width = true};
}

std::string sentence(std::string words) {
  if (!words.empty()) words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
  return words;
}

std::string words_on(const UpdatingOutcome& outcome) {
  std::string text = fmt::format("{} evaluations, {} steps, {:.1f} s, by {}. {}. ", outcome.evaluations,
                                 outcome.iterations, outcome.seconds, outcome.method, sentence(outcome.termination));
  for (const auto& remark : outcome.remarks) text += "\n\n" + sentence(remark) + ".";
  return text;
}

}  // namespace

Section updating_section(const Study& study, const StudyResults& results) {
  const auto& outcome = *results.updating;
  Section section{
      "Updated model", words_on(outcome), {updated_parameter_table(study, outcome), comparison_table(outcome)}};
  if (auto table = before_and_after_table(study, results); !table.rows.empty())
    section.items.emplace_back(std::move(table));
  for (const auto& comparison : outcome.comparisons)
    if (!comparison.modes_final.empty()) section.items.emplace_back(paired_mode_table(comparison));
  if (!outcome.minima.empty()) section.items.emplace_back(minima_table(study, outcome));
  if (outcome.statistics.correlation.rows() > 1) section.items.emplace_back(correlation_table(study, outcome));
  if (!outcome.sensitivities.empty()) section.items.emplace_back(sensitivity_table(outcome));
  if (outcome.trace.size() > 1) {
    section.items.emplace_back(trace_chart(study, outcome));
    section.items.emplace_back(residual_chart(outcome));
    section.items.emplace_back(updating_trace_table(study, outcome));
  }
  for (const auto& comparison : outcome.comparisons)
    for (std::size_t i = 0; i < comparison.responses.size(); ++i)
      section.items.emplace_back(response_chart(comparison.name, comparison.responses[i], i + 1));
  return section;
}

}  // namespace kalfem
