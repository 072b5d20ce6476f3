// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/identified_parameters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/inference/report.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/updating/parameter_interval.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

Interval about(double value, double deviation) {
  const double half = normal_quantile(0.975) * deviation;
  return {value - half, value + half};
}

void add_unknowns(const Study& study, const EstimationOutcome& outcome, std::vector<IdentifiedParameter>& found) {
  if (!outcome.has_samples()) return;
  const Index last = outcome.result.unknowns.mean.cols() - 1, first = outcome.augmented_model->layout().unknown();
  const auto& unknowns = outcome.augmented_model->options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const auto& prior = outcome.result.prior;
    const auto stated = stated_interval(outcome, row);
    found.push_back({.name = unknowns[i].name,
                     .unit = unknowns[i].unit,
                     .own_unit = study.written_unit(unknowns[i].name),
                     .value = outcome.result.unknowns.mean(row, last),
                     .deviation = stated_deviation(outcome, row),
                     .prior = confidence_interval(unknowns[i].transform, prior.mean[first + row],
                                                  std::sqrt(prior.covariance(first + row, first + row))),
                     .interval = Interval{stated.lower, stated.upper},
                     .truth = study.augmented_model->true_parameters[i]});
  }
}

void add_likelihood_unknowns(const Study& study, const LikelihoodEstimate& likelihood,
                             std::vector<IdentifiedParameter>& found) {
  for (std::size_t i = 0; i < likelihood.unknowns.size(); ++i) {
    const auto& unknown = likelihood.unknowns[i];
    const auto row = static_cast<Index>(i);
    const auto stated = likelihood.interval(row);
    found.push_back({.name = unknown.name,
                     .unit = unknown.unit,
                     .own_unit = study.written_unit(unknown.name),
                     .value = likelihood.values[row],
                     .deviation = std::fmax(likelihood.deviation[row], likelihood.robust_deviation[row]),
                     .prior = about(unknown.initial, unknown.deviation),
                     .interval = Interval{stated.lower, stated.upper},
                     .truth = unknown.truth});
  }
}

void add_updated(const Study& study, const UpdatingOutcome& outcome, std::vector<IdentifiedParameter>& found) {
  const auto deviation_in = [](const Eigen::VectorXd& deviations, Index i) {
    return i < deviations.size() ? deviations[i] : std::nan("");
  };
  for (std::size_t i = 0; i < study.updating->parameters.size(); ++i) {
    const auto& parameter = study.updating->parameters[i];
    const auto row = static_cast<Index>(i);
    const double value = outcome.values[row];
    const auto interval = parameter_interval(parameter, row, value, outcome.statistics, outcome.robust);
    IdentifiedParameter own{.name = parameter.name,
                            .unit = parameter.unit,
                            .own_unit = study.written_unit(parameter.name),
                            .value = value,
                            .deviation = std::hypot(std::fmax(deviation_in(outcome.statistics.deviations, row),
                                                              deviation_in(outcome.robust.deviations, row)),
                                                    outcome.considered ? outcome.considered->deviations[row] : 0.0),
                            .truth = study.updating->true_parameters[i]};
    if (std::isfinite(parameter.deviation)) own.prior = about(parameter.initial, parameter.deviation);
    if (interval) own.interval = Interval{interval->lower, interval->upper};
    found.push_back(std::move(own));
  }
}

void add_inferred(const Study& study, const InferenceOutcome& outcome, std::vector<IdentifiedParameter>& found) {
  for (const auto& each : inferred_values(outcome)) {
    if (!each.posterior) continue;
    const auto interval = [](const ParameterSummary& summary) { return Interval{summary.q2_5, summary.q97_5}; };
    IdentifiedParameter own{.name = each.name,
                            .unit = each.unit,
                            .own_unit = study.written_unit(each.name),
                            .value = each.posterior->mean,
                            .deviation = each.posterior->deviation,
                            .interval = interval(*each.posterior),
                            .truth = each.truth};
    if (each.prior) own.prior = interval(*each.prior);
    found.push_back(std::move(own));
  }
}

/// A line over the prior's interval, a thick one over the posterior's, a tick at the value, a diamond at the truth; all
/// on one axis that holds them.
std::string bar_svg(const IdentifiedParameter& parameter) {
  constexpr double width = 120.0, height = 22.0, middle = 0.5 * height, margin = 5.0;
  const Interval posterior = parameter.interval.value_or(Interval{parameter.value, parameter.value});
  const Interval prior = parameter.prior.value_or(posterior);
  double low = std::min({prior.lower, posterior.lower, parameter.value});
  double high = std::max({prior.upper, posterior.upper, parameter.value});
  if (parameter.truth) low = std::min(low, *parameter.truth), high = std::max(high, *parameter.truth);
  const double range = high > low ? high - low : 1.0;
  const auto x = [&](double value) { return margin + (value - low) / range * (width - 2.0 * margin); };
  const auto line = [&](const Interval& interval, const char* colour, double thickness) {
    const double from = x(interval.lower), to = std::max(x(interval.upper), from + 2.0);
    return fmt::format("<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{}\" y2=\"{}\" stroke=\"var({})\" stroke-width=\"{}\"/>",
                       from, to, middle, middle, colour, thickness);
  };
  std::string svg = fmt::format(
      "<svg class=\"bar\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "aria-label=\"From the prior to the posterior\">",
      width, height);
  if (parameter.prior) svg += line(prior, "--line", 8.0);
  svg += line(posterior, "--estimate", 8.0);
  svg += fmt::format(
      "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"2\" y2=\"{1}\" stroke=\"var(--estimate)\" "
      "stroke-width=\"2\"/>",
      x(parameter.value), height - 2.0);
  if (parameter.truth)
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1} l4 -5 l-4 -5 l-4 5 z\" fill=\"none\" stroke=\"var(--truth)\" "
        "stroke-width=\"1.4\"/>",
        x(*parameter.truth), middle + 5.0);
  return svg + "</svg>";
}

std::string z_in_words(const IdentifiedParameter& parameter) {
  const auto z = parameter.z();
  if (!z) return "-";
  return std::abs(*z) < 0.05 ? "0.0" : fmt::format("{:+.1f}", *z);
}

}  // namespace

std::optional<double> IdentifiedParameter::z() const {
  if (!truth || !(deviation > 0.0) || !std::isfinite(deviation)) return std::nullopt;
  return (value - *truth) / deviation;
}

std::vector<IdentifiedParameter> identified_unknowns(const Study& study, const EstimationOutcome& outcome) {
  std::vector<IdentifiedParameter> found;
  add_unknowns(study, outcome, found);
  if (outcome.likelihood) add_likelihood_unknowns(study, *outcome.likelihood, found);
  return found;
}

std::vector<IdentifiedParameter> identified_parameters(const Study& study, const StudyResults& results) {
  std::vector<IdentifiedParameter> found;
  if (const auto* updating = results.find<UpdatingOutcome>()) add_updated(study, *updating, found);
  if (const auto* estimation = results.find<EstimationOutcome>()) {
    const auto unknowns = identified_unknowns(study, *estimation);
    found.insert(found.end(), unknowns.begin(), unknowns.end());
  }
  if (const auto* inference = results.find<InferenceOutcome>(); found.empty() && inference)
    add_inferred(study, *inference, found);
  return found;
}

std::string value_in_words(const IdentifiedParameter& parameter) {
  const DisplayUnit shown(parameter.unit, {parameter.value, parameter.deviation}, parameter.own_unit);
  const bool is_known = std::isfinite(parameter.deviation) && parameter.deviation > 0.0;
  std::string text = shown.value(parameter.value, parameter.deviation);
  if (is_known) text += " ± " + shown.deviation(parameter.deviation);
  return shown.unit() == "-" || shown.unit().empty() ? text : text + " " + shown.unit();
}

namespace {

/// For a spreadsheet: every digit, in SI, cells apart by tabs.
std::string copied_numbers(const std::vector<IdentifiedParameter>& parameters) {
  std::string text = "parameter\tvalue\tstd\tlower 95 %\tupper 95 %\tunit\n";
  const auto cell = [](double value) { return std::isfinite(value) ? fmt::format("{:.10g}", value) : ""; };
  for (const auto& each : parameters)
    text += fmt::format("{}\t{}\t{}\t{}\t{}\t{}\n", each.name, cell(each.value), cell(each.deviation),
                        each.interval ? cell(each.interval->lower) : "",
                        each.interval ? cell(each.interval->upper) : "", each.unit);
  return text;
}

}  // namespace

Table identified_parameter_table(const std::vector<IdentifiedParameter>& parameters) {
  const bool with_truth = std::ranges::any_of(parameters, [](const auto& each) { return each.z().has_value(); });
  const bool with_prior = std::ranges::any_of(parameters, [](const auto& each) { return each.prior.has_value(); });
  Table table{.title = "What was found",
              .columns = {"parameter", "value ± std"},
              .graphics_title = with_prior ? "prior → posterior" : "95 % interval",
              .half_width = true};
  if (with_truth) table.columns.emplace_back("z");
  for (const auto& each : parameters) {
    auto& row = table.rows.emplace_back(std::vector<std::string>{each.name, value_in_words(each)});
    if (with_truth) row.push_back(z_in_words(each));
    table.graphics.push_back(bar_svg(each));
  }
  table.copied = copied_numbers(parameters);
  table.caption = "Bars: 95 % intervals.";
  if (with_truth) table.caption += " z: (value - truth) / standard deviation. The diamond is the truth.";
  return table;
}

}  // namespace kalfem
