// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/steps/estimation/compute.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Standard deviations of the motion change slowly, so a hundred values per second suffice.
int samples_between_deviations(double sample_rate) {
  return std::max(1, static_cast<int>(std::lround(sample_rate / 100.0)));
}

std::string words_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return "displacement";
    case ObservedQuantity::velocity:
      return "velocity";
    case ObservedQuantity::acceleration:
      return "acceleration";
    case ObservedQuantity::connector_deformation:
      return "deformation";
    case ObservedQuantity::connector_rate:
      return "deformation rate";
    case ObservedQuantity::connector_force:
      return "force";
    case ObservedQuantity::strain:
      return "strain";
  }
  return "";
}

/// What was computed before a failure: the rest would be drawn as nothing and averaged as zero. At least one sample
/// stays, which holds no number where none was computed.
void keep_computed(EstimationOutcome& outcome) {
  auto& result = outcome.result;
  if (!result.failure) return;
  const Index count = std::max<Index>(1, result.failure->computed);
  const auto cut = [&](MatrixXd& series) { series = series.leftCols(std::min(count, series.cols())).eval(); };
  for (auto* series : {&result.state, &result.unknowns, &result.monitored}) {
    cut(series->mean);
    cut(series->deviation);
  }
  for (auto& input : outcome.inputs) {
    input.mean = input.mean.head(std::min(count, input.mean.size())).eval();
    input.deviation = input.deviation.head(input.mean.size()).eval();
  }
  for (auto* series : {&result.innovation, &result.innovation_deviation, &outcome.measurements.values}) cut(*series);
  result.nis = result.nis.head(count).eval();
  result.measured = result.measured.head(count).eval();
  if (outcome.measurements.used) outcome.measurements.used = std::min(*outcome.measurements.used, count);
}

/// Error and coverage against the excitation's signal, where the case gives it although the filter does not know it.
void compare_inputs(const Study& study, const EstimationOutcome& outcome, std::vector<EstimatedInput>& inputs) {
  constexpr double band = 1.96;
  const auto& parts = study.structure->parts.inputs;
  for (auto& input : inputs) {
    if (!input.input.has_truth) continue;
    const auto place = std::ranges::find(parts, input.input.name, &InputDescription::name) - parts.begin();
    const auto samples = study.structure->signals[static_cast<std::size_t>(place)]->sample(
        outcome.measurements.start, 1.0 / study.sample_rate(), input.mean.size());
    input.truth = samples.col(input.input.acceleration ? 2 : 0).matrix();
    const Index count = input.truth.size() - std::min(outcome.settled, input.truth.size() - 1);
    const Eigen::ArrayXd error = (input.mean - input.truth).tail(count).array().abs();
    if (const double found = nrmse(input.mean.tail(count), input.truth.tail(count)); std::isfinite(found))
      input.nrmse = found;
    input.coverage = (error <= band * input.deviation.tail(count).array()).cast<double>().mean();
  }
}

/// By the root mean squares of deviation and estimate after settling.
bool is_hardly_known(const Eigen::VectorXd& mean, const Eigen::VectorXd& deviation, Index settled) {
  const Index count = mean.size() - std::min(settled, mean.size() - 1);
  const double spread = deviation.tail(count).squaredNorm();
  return spread > 0.25 * (mean.tail(count).squaredNorm() + spread);
}

std::vector<std::string> hardly_known(const EstimationOutcome& outcome) {
  std::vector<std::string> names;
  for (const auto& input : outcome.inputs)
    if (is_hardly_known(input.mean, input.deviation, outcome.settled)) names.push_back(input.input.name);
  for (const auto& point : outcome.points)
    if (is_hardly_known(point.mean, point.deviation, outcome.settled))
      names.push_back(point.point + " " + words_of(point.quantity));
  return names;
}

/// The rows of a series, read sample by sample as they stand in memory.
std::vector<VectorXd> rows_of(const MatrixXd& series) {
  std::vector<VectorXd> rows;
  for (Index i = 0; i < series.rows(); ++i) rows.emplace_back(series.cols());
  for (Index k = 0; k < series.cols(); ++k)
    for (Index i = 0; i < series.rows(); ++i) rows[static_cast<std::size_t>(i)][k] = series(i, k);
  return rows;
}

/// The monitored quantities one by one, compared with the reference if the record was simulated.
std::vector<PointQuantity> point_quantities(const Study& study, const StudyResults& results,
                                            const EstimationOutcome& outcome,
                                            const std::vector<OutputDescription>& monitored,
                                            const EstimatedSeries& estimated) {
  std::vector<PointQuantity> points;
  TruthComparison comparison(outcome.settled, study.sample_rate(), outcome.band);
  auto means = rows_of(estimated.mean), deviations = rows_of(estimated.deviation);
  for (std::size_t i = 0; i < monitored.size(); ++i) {
    PointQuantity quantity{
        monitored[i].name, monitored[i].quantity, std::move(means[i]), std::move(deviations[i]), {}, {}, {}};
    if (const auto* simulation = results.find<SimulationOutcome>())
      if (const auto* truth = find_quantity(simulation->points, quantity.point, quantity.quantity))
        comparison.compare(quantity, truth->mean.head(outcome.measurements.samples()));
    points.push_back(std::move(quantity));
  }
  return points;
}

/// What is reported of an estimation, compared with the reference if the record was simulated.
EstimationOutcome outcome_of(const Study& study, const StudyResults& results,
                             const std::vector<OutputDescription>& monitored, RecordEstimate estimate,
                             const Stopwatch& watch) {
  EstimationOutcome outcome{std::move(estimate), {}, {}, {}, {}, study.excitation_band, {}, 0.0};
  keep_computed(outcome);
  outcome.points = point_quantities(study, results, outcome, monitored, outcome.result.monitored);
  if (outcome.smoothed)
    outcome.smoothed_points = point_quantities(study, results, outcome, monitored, outcome.smoothed->monitored);
  compare_inputs(study, outcome, outcome.inputs);
  compare_inputs(study, outcome, outcome.smoothed_inputs);
  if (!outcome.inputs.empty()) outcome.hardly_known = hardly_known(outcome);
  outcome.seconds = watch.seconds();
  return outcome;
}

}  // namespace

EstimationOutcome run_estimation(const Study& study, AugmentedModelSetup& setup, const StudyResults& results,
                                 const std::vector<std::string>& updated, const Progress& progress,
                                 const std::function<void(EstimationOutcome)>& on_first_answer) {
  const Stopwatch watch;
  const auto monitored = reported_quantities(*setup.model);
  RecordEstimateOptions options{.monitored = monitored,
                                .deviation_stride = samples_between_deviations(study.sample_rate()),
                                .progress = progress,
                                .updated = updated};
  double first_answer = 0.0;
  options.on_first_answer = [&](const RecordEstimate& estimate) {
    first_answer = watch.seconds();
    if (!on_first_answer || estimate.second_thoughts != SecondThoughts::pending) return;
    EstimationOutcome outcome = outcome_of(study, results, monitored, estimate, watch);
    outcome.first_answer_seconds = first_answer;
    on_first_answer(std::move(outcome));
  };
  EstimationOutcome outcome =
      outcome_of(study, results, monitored,
                 estimate_record_thoroughly(study.problem, setup, record_of(study, results), options), watch);
  outcome.first_answer_seconds = first_answer;
  return outcome;
}

}  // namespace kalfem
