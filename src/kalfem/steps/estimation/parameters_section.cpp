// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/information/identifiability.hpp"
#include "kalfem/page/chart_series.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/heat_map.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/estimation/sections.hpp"

// The filter's unknowns: a table, their course, their correlation at the end, and which combinations the record left as
// the prior had them.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double band_probability = 0.95;

/// The course of one unknown with the band that the filter states.
Chart course_of(const Study& study, const EstimationOutcome& outcome, Index i) {
  const auto& layout = outcome.augmented_model->layout();
  const auto& unknown = outcome.augmented_model->options().unknowns[static_cast<std::size_t>(i)];
  Series estimate{
      .label = "estimate", .y = series_values(outcome.result.unknowns.mean.row(i).transpose()), .role = Role::estimate};
  for (Index k = 0; k < outcome.result.unknowns.mean.cols(); ++k) {
    const auto interval =
        confidence_interval(unknown.transform, outcome.result.state.mean(layout.unknown() + i, k),
                            outcome.result.state.deviation(layout.unknown() + i, k), band_probability);
    estimate.lower.push_back(interval.lower);
    estimate.upper.push_back(interval.upper);
  }
  Chart chart{.id = fmt::format("parameter-{}", i + 1),
              .title = unknown.name,
              .x_label = "time [s]",
              .x = times(outcome.measurements),
              .series = {estimate},
              .half_width = true};
  if (const auto& truth = study.augmented_model->true_parameters[static_cast<std::size_t>(i)])
    chart.series.push_back({.label = "truth", .y = std::vector<double>(chart.x.size(), *truth), .role = Role::truth});
  return with_readable_ordinates(std::move(chart), unknown.name, unknown.unit, study.written_unit(unknown.name));
}

/// The end of the same, where the band is narrow: what follows a fifth of the record.
Chart zoomed(Chart chart) {
  chart.id += "-zoom";
  chart.title += ", after a fifth of the record";
  chart.x_window = AxisRange{chart.x.front() + 0.2 * (chart.x.back() - chart.x.front()), chart.x.back()};
  return chart;
}

/// Constant unknowns at the end of the record: values, deviations and covariances in their own units.
struct ConstantUnknowns {
  std::vector<InformedParameter> parameters;
  MatrixXd prior, posterior;

  explicit ConstantUnknowns(const EstimationOutcome& outcome) {
    const auto& layout = outcome.augmented_model->layout();
    const auto& unknowns = outcome.augmented_model->options().unknowns;
    std::vector<Index> rows;
    std::vector<double> slopes;
    for (Index i = 0; i < layout.unknowns; ++i) {
      const auto& unknown = unknowns[static_cast<std::size_t>(i)];
      if (unknown.random_walk > 0.0) continue;
      const Index row = layout.unknown() + i, last = outcome.result.unknowns.mean.cols() - 1;
      rows.push_back(row);
      slopes.push_back(unknown.transform.slope(outcome.result.state.mean(row, last)));
      const double prior_deviation = slopes.back() * std::sqrt(outcome.result.prior.covariance(row, row));
      parameters.push_back({unknown.name, outcome.result.unknowns.mean(i, last), prior_deviation});
    }
    const auto slope = Eigen::Map<const VectorXd>(slopes.data(), static_cast<Index>(slopes.size())).asDiagonal();
    prior = slope * outcome.result.prior.covariance(rows, rows) * slope;
    posterior = slope * outcome.result.final_covariance(rows, rows) * slope;
  }

  /// P^-1 - P_0^-1: what the record added, without the negative parts that rounding leaves.
  [[nodiscard]] MatrixXd information() const {
    const VectorXd scale = prior.diagonal().cwiseSqrt();
    const auto scaled = [&](const MatrixXd& covariance) -> MatrixXd {
      return scale.asDiagonal() * covariance.inverse() * scale.asDiagonal();
    };
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled(posterior) - scaled(prior));
    const MatrixXd added =
        eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
    const MatrixXd unscaled = scale.cwiseInverse().asDiagonal() * added * scale.cwiseInverse().asDiagonal();
    return 0.5 * (unscaled + unscaled.transpose());
  }

  [[nodiscard]] MatrixXd correlation() const {
    const VectorXd scale = posterior.diagonal().cwiseSqrt().cwiseInverse();
    return scale.asDiagonal() * posterior * scale.asDiagonal();
  }
};

Picture correlation_picture(const ConstantUnknowns& unknowns) {
  HeatMap map{.name = "Correlation of the parameters", .values = unknowns.correlation(), .diverging = true};
  for (const auto& parameter : unknowns.parameters) map.rows.push_back(parameter.name);
  map.columns = map.rows;
  return {.title = "Correlation of the parameters",
          .caption = "At the end of the record. Near 1 or −1: the record tells the two apart badly.",
          .svg = heat_map_svg(map),
          .half_width = true};
}

/// How much of the prior's deviation is left in each combination that the record informs by itself.
Table combination_table(const Identifiability& found) {
  Table table{.title = "Combinations, the best determined first",
              .columns = {"combination", "left of the prior's deviation"},
              .alignment = {Align::left, Align::right},
              .caption = "A combination of which more than half is left was not determined by the record.",
              .half_width = true};
  for (const auto& each : found.combinations) {
    std::string words;
    for (Index i = 0; i < each.direction.size(); ++i)
      if (std::abs(each.direction[i]) >= 0.1 * each.direction.cwiseAbs().maxCoeff())
        words += fmt::format("{}{:+.2f} {}", words.empty() ? "" : " ", each.direction[i],
                             found.parameters[static_cast<std::size_t>(i)].name);
    table.rows.push_back({words, per_cent(each.posterior_deviation)});
  }
  return table;
}

/// Correlation and combinations of two or more constant unknowns.
void add_correlation(const EstimationOutcome& outcome, Section& section) {
  if (outcome.result.failure) return;
  const ConstantUnknowns unknowns(outcome);
  if (unknowns.parameters.size() < 2 || !unknowns.posterior.allFinite()) return;
  const auto found = identifiability(unknowns.information(), unknowns.parameters);
  section.text += "\n\n" + found.text;
  section.items.emplace_back(correlation_picture(unknowns));
  section.items.emplace_back(combination_table(found));
}

/// A delay in milliseconds, a drift in parts per million.
struct ClockUnit {
  std::string word, unit;
  double factor = 1.0;
};
std::optional<ClockUnit> clock_unit(const LikelihoodUnknown& unknown) {
  if (unknown.kind == LikelihoodUnknownKind::sensor_delay) return ClockUnit{"delay", "ms", 1e3};
  if (unknown.kind == LikelihoodUnknownKind::sensor_drift) return ClockUnit{"drift", "ppm", 1e6};
  return std::nullopt;
}

/// How likely the record is over the values of a delay, drift or gain; what a clock is late by also in samples.
void add_tried(const EstimationOutcome& outcome, Section& section) {
  if (!outcome.likelihood) return;
  for (const auto& [index, values, log_likelihood] : outcome.likelihood->tried) {
    if (values.size() < 3) continue;
    const auto& unknown = outcome.likelihood->unknowns[static_cast<std::size_t>(index)];
    const auto clock = clock_unit(unknown);
    const double factor = clock ? clock->factor : 1.0;
    Chart chart{.id = "likelihood-" + unknown.name,
                .title = "Log-likelihood over " + unknown.name,
                .caption = "Of the whole record, less its largest value.",
                .x_label = clock ? clock->word + " [" + clock->unit + "]" : unknown.name + " [" + unknown.unit + "]",
                .y_label = "log-likelihood [-]",
                .half_width = true};
    const double best = *std::ranges::max_element(log_likelihood);
    for (const double value : values) chart.x.push_back(factor * value);
    Series series{.label = "tried", .role = Role::estimate};
    for (const double value : log_likelihood) series.y.push_back(value - best);
    chart.series = {series};
    if (clock) {
      const auto& record = outcome.measurements;
      const bool drifts = unknown.kind == LikelihoodUnknownKind::sensor_drift;
      const double found = outcome.likelihood->values[index],
                   late = drifts ? found * (record.end() - unknown.since.value_or(record.start)) : found;
      chart.caption += fmt::format(" The {} found, {:.4g} {}, is {:.3g} samples{}.", clock->word, factor * found,
                                   clock->unit, late * record.sample_rate, drifts ? " at the record's end" : "");
    }
    section.items.emplace_back(std::move(chart));
  }
}

}  // namespace

Section parameters_section(const Study& study, const EstimationOutcome& outcome) {
  Section section{"Parameters",
                  "The 95 % interval in the table comes from the larger of the two standard deviations; `from` names "
                  "it; known_to: it holds what is stated of fixed numbers, too. The charts show the estimates over "
                  "time with the 95 % bands that the filter states (std).",
                  {parameter_table(study, outcome)}};
  for (Index i = 0; i < outcome.augmented_model->layout().unknowns; ++i) {
    Chart chart = course_of(study, outcome, i);
    Chart end = zoomed(chart);
    section.items.emplace_back(std::move(chart));
    section.items.emplace_back(std::move(end));
  }
  add_tried(outcome, section);
  add_correlation(outcome, section);
  return section;
}

}  // namespace kalfem
